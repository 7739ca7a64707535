#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace viscobar {

/// Laws that the obstacle at an end may answer with instead of the penalty; src/scene/stop.cpp has a row for each.
enum class Law { spring_damper, hertz, hunt_crossley };
/// In the order of Law.
inline constexpr Law all_laws[] = {Law::spring_damper, Law::hertz, Law::hunt_crossley};
std::string_view name(Law law);     ///< in a scene file
std::string_view meaning(Law law);  ///< for lists of them
/// True if the law has a damper, and with it a key `damping`.
bool has_damper(Law law);

/// A stop with numbers of its own. At the penetration d and its rate d' it answers the force per area
///
///     spring_damper    N = k d + c d'
///     hertz            N = k d^(3/2)
///     hunt_crossley    N = k d^(3/2) (1 + lambda d')
///
/// while d > 0 and N > 0, and 0 else: it pushes and never pulls. Behind a contact that opens by N = 0 its surface is
/// back at d = 0 at once. While it pushes it stores the energy of its spring, N at rest integrated from 0 to d; the
/// rest of the work of N is dissipated, and what is stored where it lets go [Hunt and Crossley 1975; Petrov 2010,
/// section 1, has k d].
///
/// The functions are those of a closed stop, continued beyond d = 0 as odd functions of d: a step that reaches past the
/// opening sees a smooth force.
struct Stop {
  Law law = Law::spring_damper;  ///< the formula
  double stiffness = 1.0;        ///< k > 0: stress per length, or per length^(3/2)
  double damping = 0.0;          ///< c >= 0: stress times time per length; lambda >= 0: time per length
  bool shared = false;           ///< one of all ends that name no law of their own ([contact] of a scene file)

  /// The key of the scene file that one of its numbers, or its law, comes from.
  std::string key(std::string_view end, std::string_view leaf) const;
  /// True if N is linear in d and d'.
  bool linear() const;
  double force(double depth, double rate) const;         ///< N
  double by_depth(double depth, double rate) const;      ///< dN/dd
  double by_rate(double depth, double rate) const;       ///< dN/dd'
  double by_stiffness(double depth, double rate) const;  ///< dN/dk
  double by_damping(double depth, double rate) const;    ///< dN/dc or dN/dlambda
  double energy(double depth) const;                     ///< stored, 0 for d <= 0

  /// The condition a d + b d' + e > 0 under which the stop pushes at d > 0.
  struct Push {
    double a;  ///< of d
    double b;  ///< of d'
    double e;  ///< constant
  };
  /// Absent: it pushes wherever d > 0. `time` makes a displacement of the condition on a velocity.
  std::optional<Push> push(double time) const;
  /// Derivative of that by k and by c or lambda, whose derivatives are those of `rates`.
  Push push_rate(double time, const Stop& rates) const;
};

}  // namespace viscobar
