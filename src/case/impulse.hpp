#pragma once

#include <optional>
#include <vector>

#include "viscobar/case/case.hpp"

namespace viscobar {

/// Impulse of the reactions at the ends, from the first snapshot of a run to the latest, by the balance of momentum of
/// the end node's row,
///
///     int R dt = [rho M v + eta K u] + int (E K u - M f) dt,
///
/// whose integrand is as smooth as u: a node that bounces many times between two output times, of whose reaction the
/// snapshots have single samples only, is accounted for. `system` outlives it.
class EndImpulse {
 public:
  explicit EndImpulse(const BarSystem& system);  ///< for a run of this system

  void add(const Snapshot& snapshot);          ///< the next one in order of time
  double left() const { return left_sum_; }    ///< impulse of the left end's reaction so far
  double right() const { return right_sum_; }  ///< likewise of the right end's

 private:
  struct Row {
    double stored, rate;  // rho M v + eta K u, and E K u - M f
  };
  const BarSystem& system_;
  std::optional<LoadVector> load_;
  std::vector<double> momentum_, force_, rest_;
  double time_ = 0.0;
  std::optional<Row> left_, right_;
  double left_sum_ = 0.0, right_sum_ = 0.0;
};

}  // namespace viscobar
