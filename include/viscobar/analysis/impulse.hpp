#pragma once

#include <vector>

#include "viscobar/analysis/case.hpp"
#include "viscobar/analysis/comparison.hpp"
#include "viscobar/analysis/recording.hpp"

namespace viscobar {

/// Impulse of the reactions at the ends from the recording's beginning to each of its times, by the balance of momentum
/// of the end node's row,
///
///     int R dt = [rho M v + eta K u] + int (E K u - M f) dt,
///
/// whose integrand is as smooth as u: a node that bounces many times between two output times, of whose reaction the
/// recording has single samples only, is accounted for.
class EndImpulses {
 public:
  EndImpulses(const Case& run, const Recording& recording);

  /// Over a contact period at an end, taken from the output time before it to the one after it; 0 under a span.
  double over(const ContactPeriod& period) const;

 private:
  const std::vector<double>& times_;
  double blur_;
  std::vector<double> left_, right_;
};

}  // namespace viscobar
