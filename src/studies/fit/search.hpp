#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "studies/fit/misfit.hpp"

namespace viscobar::fitting {

/// Where a search ended.
struct Minimum {
  Eigen::VectorXd at;
  Misfit misfit;
  std::size_t iterations = 0;
  bool converged = false;
  std::string reason;
  Compared compared = Compared::samples;
  TimeErrors errors;  ///< of `exact` samples; empty where they are met without
};

/// True if a parameter has come to one of its bounds.
inline bool on_bound(const FittedParameter& parameter, double value) {
  return value <= parameter.low || value >= parameter.high;
}
/// True if a step leaves the bounds.
bool leaves(const FittedParameter& parameter, double value, double step);

/// Coordinate k of the i-th of Halton's points, which fill the unit cube evenly.
double halton(std::size_t i, std::size_t k);

/// Levenberg's and Marquardt's descents of a study.
class Search {
 public:
  /// The first run takes so many steps at most.
  explicit Search(const FitStudy& study, std::size_t most_steps = std::numeric_limits<std::size_t>::max())
      : study_(study), n_(std::ssize(study.parameters)), first_steps_(most_steps) {}

  std::size_t runs = 0;
  std::optional<Eigen::Index> held;  ///< a parameter that no descent moves
  TimeErrors errors;                 ///< that `exact` samples are excused
  struct Tried {
    Eigen::VectorXd at;
    Compared compared;
    double sum;  ///< S
  };
  std::vector<Tried> tried;  ///< all runs that succeeded but differences

  /// A run at these values; of one that fails, why. A trial run takes no more than so many times the steps of the
  /// first.
  Misfit at(const Eigen::VectorXd& values, Compared compared, bool derivatives = true);
  /// True if velocities or reactions are among the data.
  bool jumps() const;
  /// Axes of an ellipsoid, its columns, in which values change what is smooth in them by a deviation, and no longer
  /// than the values.
  Eigen::MatrixXd axes_of_deviations(const Eigen::VectorXd& values);
  /// The i-th of values beside some: along these axes.
  Eigen::VectorXd beside(const Eigen::VectorXd& centre, const Eigen::MatrixXd& axes, std::size_t i) const;
  /// Integrals of what jumps lead to the neighbourhood of a minimum, samples to the minimum; exact ones alone.
  Minimum minimum_from(const Eigen::VectorXd& start, Compared first, std::size_t most_runs);
  /// No step is longer than the parameter is large, three times, or takes more than three quarters of a positive one.
  double limited(Eigen::Index k, double from, double to) const;

 private:
  Misfit run(const Eigen::VectorXd& values, Compared compared, bool derivatives);
  void difference(const Eigen::VectorXd& values, Compared compared, Misfit& misfit);
  Minimum descend(const Eigen::VectorXd& start, Compared compared, std::size_t most_runs);

  const FitStudy& study_;
  Eigen::Index n_;
  std::size_t first_steps_;
  std::optional<std::size_t> most_steps_;  // of all others
};

}  // namespace viscobar::fitting
