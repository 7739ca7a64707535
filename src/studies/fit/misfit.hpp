#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "viscobar/studies/fit/fit.hpp"

namespace viscobar::fitting {

/// A run of the model beside the data.
struct Misfit {
  bool sound = false;                       ///< the run succeeded
  std::string error;                        ///< why it did not
  Eigen::VectorXd residual;                 ///< (model - data) / deviation of all numbers measured
  Eigen::MatrixXd jacobian;                 ///< of it by the parameters; a row is zero where there is no derivative
  std::vector<std::vector<double>> traces;  ///< of the model
  std::vector<Event> changes;               ///< contact changes of the model
  std::optional<double> lost;               ///< from when on there are no derivatives
  std::size_t steps = 0;                    ///< of the run
  Eigen::Index forgiven = 0;                ///< samples beside contact changes that count as met: they tell no noise
  Eigen::Index repeated = 0;                ///< times of contact changes within a deviation of another of the contact

  double sum() const { return sound ? residual.squaredNorm() : std::numeric_limits<double>::infinity(); }  ///< S
  /// m - n, of m numbers that are compared; not below 0.
  Eigen::Index freedom(Eigen::Index parameters) const {
    return std::max<Eigen::Index>(residual.size() - forgiven - repeated - parameters, 0);
  }
  /// True if more numbers tell the parameters than these are. As many are met by any motion, and the others, such as
  /// those of a bar at rest, do not tell how well they are.
  bool is_tested(Eigen::Index parameters) const {
    return (jacobian.rowwise().squaredNorm().array() > 0.0).count() - repeated > parameters;
  }
  /// S / (m - n); 1 at least, of deviations that are as given, where nothing tests it.
  double variance(Eigen::Index parameters) const {
    const double known = sum() / static_cast<double>(std::max<Eigen::Index>(freedom(parameters), 1));
    return freedom(parameters) == 0 ? 1.0 : is_tested(parameters) ? known : std::max(known, 1.0);
  }
};

/// Samples of velocities and reactions, which jump, make many valleys; their integrals from the first sample on change
/// smoothly with the parameters. Samples beside contact changes are compared with what lies between their neighbours,
/// but for `exact` ones.
enum class Compared { samples, integrals, exact };

inline bool is_velocity(TraceColumn column) {
  return column == TraceColumn::v_left || column == TraceColumn::v_right || column == TraceColumn::v_at;
}
inline bool is_reaction(TraceColumn column) {
  return column == TraceColumn::reaction_left || column == TraceColumn::reaction_right ||
         column == TraceColumn::force_of;
}

/// End, node and change of contact changes.
using Kind = std::tuple<Where, std::size_t, Change>;
Kind kind_of(const Event& event);
/// How wrong the model itself is in the times of contact changes, of each kind in their order. Within it `exact`
/// samples are compared as those beside changes.
using TimeErrors = std::map<Kind, std::vector<double>>;

/// Runs a model beside the data, with so many steps at most. A measured contact change that the model does not have, in
/// the order of those of its kind, counts as one at twice the end of the run. @throws as
/// simulate_within()
Misfit measure(const FitStudy& study, Case run, Compared compared, bool derivatives, std::size_t most_steps,
               const TimeErrors& errors = {});

}  // namespace viscobar::fitting
