#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar {

/// Added to u it gives displacements: -s gap at nodes that are measured from their obstacle, so that a penetration
/// keeps all its digits, and 0 at others.
class Origin {
 public:
  std::span<const double> values() const { return values_; }  ///< empty where all are 0
  std::span<const double> force() const { return force_; }    ///< -E K times them; empty, too
  double at(std::size_t unknown) const { return values_.empty() ? 0.0 : values_[unknown]; }  ///< of one node
  /// Moves it, n values.
  void move(const BarSystem& bar, std::vector<double> values) {
    values_ = std::move(values);
    const std::vector<double> nothing(values_.size(), 0.0);
    std::vector<double> without(values_.size());
    force_.resize(values_.size());
    bar.internal_force(values_, nothing, force_);
    bar.internal_force(nothing, nothing, without);
    for (std::size_t i = 0; i < force_.size(); ++i) force_[i] -= without[i];
  }
  /// The displacements.
  std::vector<double> displacement(std::span<const double> u) const {
    std::vector<double> displacement(u.begin(), u.end());
    for (std::size_t i = 0; i < values_.size(); ++i) displacement[i] += values_[i];
    return displacement;
  }
  /// max |u_j| of them
  double largest_displacement(std::span<const double> u) const {
    const Eigen::Map<const Eigen::ArrayXd> relative(u.data(), static_cast<Eigen::Index>(u.size()));
    if (values_.empty()) return relative.abs().maxCoeff();
    return (relative + Eigen::Map<const Eigen::ArrayXd>(values_.data(), relative.size())).abs().maxCoeff();
  }

 private:
  std::vector<double> values_, force_;
};

}  // namespace viscobar
