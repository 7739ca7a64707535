#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "integration/layout.hpp"
#include "integration/radau/formula.hpp"
#include "integration/radau/step_powers.hpp"

namespace viscobar::radau {

/// The powers of energy_flow() at all of Gauss' points of a step at once. A velocity there is
///
///     w_i(theta_g) = w_i + sum_k c_k(theta_g) (X_k)_i
///
/// with weights that are the same in each step: the points are the lanes of vectors, where energy_flow() makes the
/// motion of all nodes once a point. For a frame at rest, and nodes that do not follow others: see takes().
class GaussPowers {
 public:
  static constexpr std::size_t points = StepPowers::of_gauss;

  static bool takes(const BarSystem& bar) {
    return !bar.frame().moving() && !bar.inertia().has_massless() && !bar.side() && bar.inertia().matrix().skew.empty();
  }

  /// @param w velocities where the step begins
  /// @param x the solutions X_k of the step from `begin`, of that length
  std::array<StepPowers::Flow, points> operator()(PenalisedSystem& system, const Layout& layout,
                                                  std::span<const double> w, std::span<const Complex> x, double begin,
                                                  double length);

 private:
  using Points = Eigen::Array<double, points, 1>;
  static std::array<Points, parts> weights(int derivative);
  Points load(PenalisedSystem& system, double begin, double length) const;

  std::vector<Points> w_;  // of all nodes
};

}  // namespace viscobar::radau
