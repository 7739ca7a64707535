#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/acting_load.hpp"
#include "dynamics/contacts.hpp"

namespace viscobar {

/// The part of an indicator beside entries: rest + load * (the sum of (M f)_j over the unknowns from first to last).
struct IndicatorOffset {
  double rest = 0.0, load = 0.0;
  std::size_t first = 0, last = 0;

  /// `of_unknown(j)` is (M f)_j.
  double of_load(auto&& of_unknown) const {
    double sum = 0.0;
    for (std::size_t j = first; j <= last; ++j) sum += of_unknown(j);
    return load * sum;
  }
};

/// Weights in an indicator of the values of its entries, in their order, and where the contact holds_mass() of the
/// rates of the last ones.
struct IndicatorWeights {
  std::array<double, 8> values{};  ///< beyond the third only with a side that resists, or at a joint
  std::array<double, 6> rates{};
  bool sided = false;                           ///< true if those count
  bool alone = true;                            ///< the first value is all that it takes
  std::optional<double> offset = std::nullopt;  ///< the rest, where it is the same at all times
  IndicatorOffset varying{};                    ///< the same where it is not

  double operator()(std::span<const double> entries, std::span<const double> of_entries = {}) const {
    if (alone) return values[0] * entries[0];
    double sum = values[1] * entries[1] + values[2] * entries[2];
    for (std::size_t k = 3; sided && k < entries.size(); ++k) sum += values[k] * entries[k];
    for (std::size_t k = 2; k < of_entries.size(); ++k) sum += rates[k - 2] * of_entries[k];
    return sum;
  }
};

/// The indicators of contacts. Contact i is closed by the sign of p = linear part of some entries of (u, w) +
/// offset(t), negative where it should be closed. p is a displacement:
///
///     a node with inertia or viscosity    its clearance
///     a contact that holds, while it is closed
///                                         (h/E) times minus its reaction R, s (u_1 + (eta/E) w_1 + (h/E) (M f)_i -
///                                         (h/E) (rho M a)_i) + gap
///     a closed contact that holds two nodes of a joint
///                                         (h/E) times minus N, which the row of the bar's node tells
///     an undamped massless node           the same in either state, its clearance while it is open: its own
///                                         displacement shrinks by 1 + k h/E as it closes, this one passes smoothly
class Indicators {
 public:
  /// Both outlive it.
  Indicators(const Contacts& contacts, ActingLoad& load) : contacts_(contacts), load_(load) {}

  std::vector<std::size_t> entries(std::size_t i) const;  ///< of (u, w), of contact i
  IndicatorWeights weights(std::size_t i) const;          ///< as the contacts are now
  IndicatorOffset offset(std::size_t i) const;            ///< the rest: gap, and load where the row asks for it
  /// The same at t.
  double offset(std::size_t i, double t) const {
    const IndicatorOffset all = offset(i);
    return all.load == 0.0 ? all.rest : all.rest + all.of_load([&](std::size_t j) { return load_.alone(j, t); });
  }
  /// Rounding error of p, for displacements up to `largest`: as that of the clearance; of a closed contact measured
  /// from its obstacle, smaller by 1 / (1 + kappa).
  double rounding(std::size_t i, double largest) const;

 private:
  const Contacts& contacts_;
  ActingLoad& load_;
};

/// A stop that may let go pushes where p < 0 and this condition is negative, too, -(a d + b d' + e) of Stop::Push, of
/// the same entries; absent: of contact i p alone tells.
std::optional<IndicatorWeights> push_weights(const Contacts& contacts, std::size_t i);
/// The derivative of that condition, in the motion of a system by a parameter, by which the numbers of the stop change
/// by those of `rates`: of the clearance and the velocity w there, w_bar being the velocity of the bar itself.
double push_rate(const Contacts& contacts, std::size_t i, double clearance, double w, double w_bar, const Stop& rates);

}  // namespace viscobar
