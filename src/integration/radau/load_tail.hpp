#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <vector>

#include "integration/radau/formula.hpp"
#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar::radau {

/// Error of a step by the load between its stages. The error of the motion itself cannot see a kink of
/// the load, at which the stages are no worse than elsewhere.
class LoadTail {
 public:
  void resize(std::size_t nodes) { tail_.resize(nodes); }
  /// Change of the load of node i at a stage; stages in order.
  void add(std::size_t stage, std::size_t i, double change) {
    const Eigen::Array4d share = change * Eigen::Map<const Eigen::Array4d>(Formula::get().tail[stage].data());
    tail_[i] = stage == 0 ? share : tail_[i] + share;
  }
  /// Times the weights of a displacement and a velocity. With b and a the larger of the last two pairs of Chebyshev
  /// coefficients, geometric decay leaves a^2 / b behind them: taken as a force on the node alone, all over the step.
  double error(const BarSystem& bar, double h, double of_displacement, double of_velocity) const {
    double fastest = 0.0;
    for (std::size_t i = bar.inertia().massive_begin(); i < bar.inertia().massive_end(); ++i) {
      const Eigen::Array4d size = tail_[i].abs();
      const double before = std::max(size[0], size[1]), last = std::max(size[2], size[3]);
      const double rest = last < before ? last * (last / before) : last;
      fastest = std::max(fastest, h * rest / bar.inertia().matrix().diagonal[i]);
    }
    return fastest * std::max(of_velocity, h * of_displacement);
  }

 private:
  std::vector<Eigen::Array4d> tail_;  // of each node
};

}  // namespace viscobar::radau
