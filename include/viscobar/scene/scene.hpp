#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "viscobar/scene/stop.hpp"

namespace viscobar {

/// The bar itself:  A rho u_tt - (A (E u_x + eta u_xt))_x = A f  on 0 < x < length, A the section of its Scene.
/// Any consistent set of units; the paper's non-dimensional problem has rho = E = 1, eta = alpha.
struct Bar {
  double length = 1.0;     ///< L > 0
  double density = 1.0;    ///< rho > 0
  double modulus = 1.0;    ///< E > 0
  double viscosity = 0.0;  ///< eta >= 0; zero means that no damping term is built

  bool damped() const { return viscosity > 0.0; }                     ///< true if it has any
  double wave_speed() const { return std::sqrt(modulus / density); }  ///< c
  double slowness() const { return std::sqrt(density / modulus); }    ///< 1 / c
  double impedance() const { return std::sqrt(density * modulus); }   ///< rho c
  double transit() const { return length * slowness(); }              ///< of a wave through it
};

/// Stress-free end (Neumann): s = E u_x + eta u_xt = 0.
struct Free {};

/// End that keeps its initial displacement (Dirichlet), u = u_0(X) for all times, unless EndInput moves it.
struct Fixed {};

/// From where an obstacle bounds the displacement: u >= -gap, the paper's reading at either end, u <= gap, or both,
/// a slit, which only the span can be in.
enum class Side { below, above, both };
/// In the order of Side.
inline constexpr Side all_sides[] = {Side::below, Side::above, Side::both};
std::string_view name(Side side);  ///< in a scene file

/// Unilateral obstacle (Signorini): 0 <= s u + gap, reaction s R with R >= 0, and one of the two vanishes, s = 1 below
/// and s = -1 above [Petrov 2010, (1.3)].
struct Obstacle {
  double gap = 0.0;         ///< >= 0, at the start where EndInput moves it
  Side side = Side::below;  ///< s

  /// True if it bounds u from that side, `below` or `above`.
  bool bounds(Side from) const { return side == from || side == Side::both; }
  /// How deep a displacement lies in it; not positive outside.
  double depth(double u) const {
    return side == Side::both ? (u < 0.0 ? -u : u) - gap : side == Side::below ? -u - gap : u - gap;
  }
  /// True where that is more than a rounding, which the end of a run in contact has, where another one may begin.
  bool passed_by(double u) const { return depth(u) > 1e-12 * std::abs(u); }
};

/// The condition at an end of the bar; src/scene/end_kinds.hpp has a row for each alternative.
using EndCondition = std::variant<Free, Fixed, Obstacle>;

/// f(x), 0 <= x <= L.
using SpaceFunction = std::function<double(double x)>;
/// f(t), t >= 0.
using TimeFunction = std::function<double(double t)>;
/// f(x, t).
using SpaceTimeFunction = std::function<double(double x, double t)>;
/// The same with f(x_i, t) at once for many x_i, where that is quicker: a density that holds one is evaluated so.
struct RowFunction {
  SpaceTimeFunction value;                                                            ///< f
  std::function<void(std::span<const double> x, double t, std::span<double> f)> row;  ///< as many f as x

  /// f(x, t)
  double operator()(double x, double t) const { return value(x, t); }
};

/// The first time in (after, until) at which a function of time jumps or has a kink; absent: none there. `after` may be
/// a rounding before the start.
using NextBreak = std::function<std::optional<double>(double after, double until)>;
/// The same for a function of x and t, at x.
using NextBreakAt = std::function<std::optional<double>(double x, double after, double until)>;

/// The first of both.
inline NextBreak either_of(const NextBreak& a, const NextBreak& b) {
  return [a, b](double after, double until) {
    const std::optional<double> first = a(after, until), second = b(after, until);
    return first && (!second || *first < *second) ? first : second;
  };
}

/// Properties of a function of x, known from its formula; empty functions: nothing is known. Such data enter a mesh by
/// moments between those places, int phi_i f dx, where they are not smooth or the mesh is too coarse for them, and on
/// `fourth_order` always; else, and where nothing is known, by their values at the nodes.
struct Places {
  NextBreak breaks = {};    ///< of x: where it jumps or has a kink
  NextBreak detail = {};    ///< where a stretch begins or ends that needs a finer mesh than one of some 100 elements
  bool by_moments = false;  ///< it enters by moments on any mesh, where breaks are known
};

/// f(x): evaluated once per node.
struct SteadyLoad {
  SpaceFunction profile;  ///< f(x)
  Places places = {};     ///< of it
};

/// f(x,t) = profile(x) history(t): the profile is evaluated once per node, the history once per step.
///
/// No step of an adaptive method and none of `exponential` reaches across a break; from either side of it the load is
/// evaluated a few roundings of the time away.
struct SeparableLoad {
  SpaceFunction profile;  ///< of x
  TimeFunction history;   ///< of t
  NextBreak breaks = {};  ///< of the history; empty: it is smooth
  Places places = {};     ///< of the profile
  /// Added to it, in the derivative of a load: that of a product is two of them.
  std::shared_ptr<const SeparableLoad> plus = {};
};

/// f(x,t) of no known structure: evaluated at every node and every step.
struct GeneralLoad {
  SpaceTimeFunction density;     ///< f(x,t), force per volume
  NextBreak breaks = {};         ///< of the density, the same for all x; empty: none
  NextBreakAt breaks_at = {};    ///< those that are at another time for another x, such as a front that moves
  NextBreakAt breaks_in_x = {};  ///< of the density, at a time
  NextBreakAt detail_in_x = {};  ///< details of the density, as of Places; only an error estimate asks for them
  /// The jumps and kinks among `breaks`; the others show where the density is quick, and that no step may pass. Absent:
  /// all are jumps or kinks.
  std::optional<NextBreak> sharp = {};
};

/// The density f of a load, in the narrowest kind that holds it.
using Load = std::variant<SteadyLoad, SeparableLoad, GeneralLoad>;

/// A force on an end of the bar, in the direction of u.
struct EndForce {
  TimeFunction value;     ///< F(t)
  NextBreak breaks = {};  ///< of it; empty: it is smooth
  bool steady = false;    ///< true if F is constant
};

/// How far what holds or bounds an end has moved since the start, in the direction of u. It does not jump.
struct EndMotion {
  TimeFunction displacement;  ///< d(t), d(0) = 0
  TimeFunction velocity;      ///< d'(t)
  TimeFunction acceleration;  ///< d''(t); the fully discrete schemes do without
  NextBreak breaks = {};      ///< of any of the three; empty: it is smooth
};

/// Force, spring, dashpot, mass, motion and stop that an end is given beside its condition. With the outward stress s
/// at the end, -s at x = 0, and the reaction R,
///
///     s = F(t) - k u - c u_t - m u_tt + R    at a free end, R = 0, or one with an obstacle.
struct EndInput {
  std::optional<EndForce> force{};    ///< F
  std::optional<EndMotion> motion{};  ///< of a fixed end, u = u_0 + d(t), or of an obstacle, gap(t) = gap - s d(t)
  double stiffness = 0.0;             ///< k >= 0, of a spring to the ground at rest at u = 0
  double dashpot = 0.0;               ///< c >= 0, of a dashpot beside it
  double mass = 0.0;                  ///< m >= 0, of a rigid mass on the end, a mass per area of the bar
  std::optional<Stop> stop{};         ///< the law of its obstacle; absent: rigid, or the penalty, as the method has it
};

/// Resistance along the whole bar, a force -k(x) u - c(x) u_t per volume:
///
///     rho u_tt = (E u_x + eta u_xt)_x + f - k u - c u_t.
struct SideResistance {
  SpaceFunction stiffness{};                              ///< k >= 0, a stress per area of the side; empty: none
  SpaceFunction drag{};                                   ///< c >= 0; empty: none
  Places stiffness_places{} /**< of k */, drag_places{};  ///< of c
};

/// How a member of a chain hangs together with the next.
enum class JointKind {
  bonded,   ///< as one: displacement and force are continuous
  contact,  ///< they meet where a gap between them closes, and push
  spring    ///< by a spring and a dashpot, which pull as well
};
/// In the order of JointKind.
inline constexpr JointKind all_joints[] = {JointKind::bonded, JointKind::contact, JointKind::spring};
std::string_view name(JointKind kind);     ///< in a scene file
std::string_view meaning(JointKind kind);  ///< in half a sentence

/// The joint between a member of a chain and the next. u_a is the displacement to its left, u_b that to its right, and
/// the force N pushes the two apart:
///
///     contact  0 <= u_b - u_a + gap  _|_  N >= 0      spring  N = k (u_a - u_b) + c (u_a' - u_b')
struct Joint {
  JointKind kind = JointKind::bonded;  ///< decides which of the others count
  double gap = 0.0;                    ///< of a contact, >= 0, where nothing is displaced
  std::optional<Stop> stop{};          ///< the law of a contact; absent: as of an obstacle
  double stiffness = 0.0;              ///< k >= 0 of a spring
  double damping = 0.0;                ///< c >= 0 of a spring
};

/// A member of a chain: a bar, or a rigid body, which has a mass and no length. Its functions are of x from its own
/// left end.
struct Member {
  Bar bar{};                                        ///< length 0: rigid
  double mass = 0.0;                                ///< m > 0 of a rigid one
  SpaceFunction section{};                          ///< A(x) > 0; empty: 1
  Places section_places{};                          ///< of A
  SpaceFunction displacement{};                     ///< u_0
  SpaceFunction velocity{};                         ///< u_1
  Joint joint{};                                    ///< to the next member; of the last one none
  bool rigid() const { return bar.length == 0.0; }  ///< true if it is no bar
};

/// The bar that a chain is as a whole: its length, the wave speed by which it takes a wave the same time, and the mean
/// impedance of its bars over that time; the largest eta / E. Bars that are alike are that bar.
Bar whole_of(const std::vector<Member>& chain);

/// Names of the units of a scene, for labels alone: any may be empty.
struct Units {
  std::string length;  ///< such as "m"
  std::string time;    ///< such as "s"
  std::string mass;    ///< such as "kg"; a stress is then "kg/(m s^2)"
  std::string force;   ///< such as "N"; a stress is then "N/m^2"
  std::string stress;  ///< such as "Pa"
  /// True of a scene with a section: its areas have a unit, and its forces are no stresses.
  bool of_section = false;
};

/// The physical problem, free of any discretisation [Petrov 2010, (1.1)-(1.3)].
struct Scene {
  std::string title;                     ///< free text, for reports
  Bar bar;                               ///< geometry and material
  EndCondition left = Free{};            ///< at x = 0
  EndCondition right = Free{};           ///< at x = L
  std::optional<Obstacle> span;          ///< of u(x,t) for every x (section 4 of the paper, figure 3)
  SpaceFunction displacement;            ///< u_0(x)
  SpaceFunction velocity;                ///< u_1(x)
  std::optional<Load> load;              ///< f; absent: none
  std::optional<SideResistance> side{};  ///< k and c; absent: none
  EndInput left_input{};                 ///< force, motion and supports of the left end
  EndInput right_input{};                ///< the same of the right end
  Units units;                           ///< of its numbers
  Places displacement_places{};          ///< of u_0
  Places velocity_places{};              ///< of u_1
  SpaceFunction section{};               ///< A(x) > 0; empty: 1, and forces are stresses
  Places section_places{};               ///< of A
  /// Bars in line from left to right, of two members or more: `bar` is then whole_of() them, and displacement and
  /// velocity are those of the member that x is in, the left one at a joint. Empty: one bar.
  std::vector<Member> chain{};
};

/// A fault of the user's input: the key (as in the scene file) and the problem.
struct Finding {
  std::string key;      ///< "table.key"
  std::string problem;  ///< a sentence about its value
};

/// Why a method that knows no stop with a law of its own, or linear ones alone, does not take these ends; absent: it
/// takes them.
std::optional<Finding> law_refusal(std::string_view method, const EndInput& left, const EndInput& right,
                                   bool takes_linear = false);
/// Why a method does not take a stop, that of `table`: "left", "joint.1".
Finding law_refusal(std::string_view method, const Stop& stop, const std::string& table);

/// All faults of a scene: values that are not finite or out of range, initial data that penetrate an
/// obstacle at an end. Empty when the scene is sound.
std::vector<Finding> validate(const Scene& scene);

/// True if the end meets an obstacle.
inline bool is_obstacle(const EndCondition& end) { return std::holds_alternative<Obstacle>(end); }
/// True if the end stands still.
inline bool is_fixed(const EndCondition& end) { return std::holds_alternative<Fixed>(end); }
/// How many ends meet an obstacle.
inline std::size_t end_obstacles(const Scene& scene) {
  return std::size_t{is_obstacle(scene.left)} + std::size_t{is_obstacle(scene.right)};
}
/// True if a joint of a chain is a contact for which holds(its law).
inline bool has_contact_joint(const Scene& scene, auto&& holds) {
  for (std::size_t k = 0; k + 1 < scene.chain.size(); ++k)
    if (const Joint& joint = scene.chain[k].joint; joint.kind == JointKind::contact && holds(joint.stop)) return true;
  return false;
}
/// True if any is.
inline bool has_contact_joint(const Scene& scene) {
  return has_contact_joint(scene, [](const std::optional<Stop>&) { return true; });
}
/// True if that end of a member of a chain meets an obstacle or another member, itself or by a rigid body on it.
bool meets_contact(const Scene& scene, std::size_t member, bool right);
/// True if an end or a joint has a stop with a law of its own that `holds(stop)` takes.
template <class Holds>
bool has_stops(const Scene& scene, Holds holds) {
  const auto held = [&](const std::optional<Stop>& stop) { return stop && holds(*stop); };
  return held(scene.left_input.stop) || held(scene.right_input.stop) || has_contact_joint(scene, held);
}
/// True if it has any.
inline bool has_stops(const Scene& scene) {
  return has_stops(scene, [](const Stop&) { return true; });
}
/// True if an obstacle has none, so that penalised methods give it the penalty.
inline bool has_penalty(const Scene& scene) {
  return scene.span || has_contact_joint(scene, [](const std::optional<Stop>& stop) { return !stop; }) ||
         (is_obstacle(scene.left) && !scene.left_input.stop) || (is_obstacle(scene.right) && !scene.right_input.stop);
}
/// True if the bar can touch anything, at an end, along the span or at a joint.
inline bool meets_obstacle(const Scene& scene) {
  return end_obstacles(scene) > 0 || scene.span || has_contact_joint(scene);
}

}  // namespace viscobar
