#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "viscobar/studies/fit/fit.hpp"

namespace viscobar {

/// A run of the model beside the data.
struct Misfit {
  bool sound = false;                       ///< the run succeeded
  std::string error;                        ///< why it did not
  Eigen::VectorXd residual;                 ///< (model - data) / deviation of all numbers measured
  Eigen::MatrixXd jacobian;                 ///< of it by the parameters; a row is zero where there is no derivative
  std::vector<std::vector<double>> traces;  ///< of the model
  std::vector<Event> changes;               ///< likewise
  std::optional<double> lost;               ///< from when on there are no derivatives

  double sum() const { return residual.squaredNorm(); }  ///< S
};

/// Runs the model, and counts its runs. A measured contact change that the model does not have, in the order of those
/// of its kind, counts as one at twice the end of the run.
Misfit measure_misfit(const FitStudy& study, const Eigen::VectorXd& values, std::size_t& runs);

}  // namespace viscobar
