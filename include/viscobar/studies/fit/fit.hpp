#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "viscobar/case/case.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"

namespace viscobar {

/// Columns of ends.csv, of gauges.csv at a place, and of joints.csv at a joint.
enum class TraceColumn {
  u_left,
  v_left,
  reaction_left,
  u_right,
  v_right,
  reaction_right,
  u_at,
  v_at,
  strain_at,
  stress_at,
  u_left_of,
  u_right_of,
  force_of
};
/// Their names in headers, in the order of the enumeration; one that ends with "@" or ":" is followed by a place.
std::span<const std::string_view> trace_column_names();
/// True if it is of a joint, whose number is its place.
inline bool is_of_joint(TraceColumn column) { return column >= TraceColumn::u_left_of; }
/// True if it is of a gauge.
inline bool is_of_gauge(TraceColumn column) { return column >= TraceColumn::u_at && !is_of_joint(column); }
/// In the header: "u_left", "strain@0.25", "force:1".
std::string name(TraceColumn column, double place = 0.0);
/// The column of that name, and its place; absent: there is none.
std::optional<std::pair<TraceColumn, double>> trace_column(std::string_view name);

/// A measured trace: a value for each time of the data, NaN where there is none.
struct MeasuredTrace {
  TraceColumn column = TraceColumn::u_left;  ///< quantity that was measured
  std::vector<double> values;                ///< K
  double deviation = 1.0;                    ///< standard deviation of its noise, or what weighs it against others, > 0
  bool assumed = false;                      ///< nobody gave that deviation: noise may be larger
  double place = 0.0;                        ///< x of a column of gauges.csv, 0 <= x <= L; number of a joint
};

/// A parameter that a fit looks for.
struct FittedParameter {
  std::string key;                                        ///< of a direction
  double start = 0.0;                                     ///< where it begins
  double low = -std::numeric_limits<double>::infinity();  ///< lower bound
  double high = std::numeric_limits<double>::infinity();  ///< upper bound
};

/// Least squares: the parameters p that make
///
///     S(p) = sum over traces and times of ((model - data) / deviation)^2 + the same over the times of contact changes
///
/// least, within their bounds, by Levenberg's and Marquardt's method on the sensitivities of each run, or on
/// differences of runs where it has none.
///
/// Velocities and reactions jump. So the search compares their integrals first, displacements and impulses, and then
/// the samples, those beside a contact change with the nearest value that the model has from one sample to the next but
/// one. While much is left to explain, it begins anew where some of many trial runs came closest to the data.
struct FitStudy {
  /// The scene for values of the parameters, with the direction of each, in their order; may throw where there is none.
  std::function<Case(std::span<const double> values)> model;
  std::vector<FittedParameter> parameters;  ///< one at least
  std::vector<double> times;                ///< K, of the traces; they do not fall
  std::vector<MeasuredTrace> traces;        ///< may be none where there are changes
  std::vector<Event> changes;               ///< measured contact changes: time, where, node and change count
  double change_deviation = 1.0;            ///< of their times
  std::size_t starts = 1;  ///< so many beginnings: the one given, others spread over the bounds, which must be finite
  std::size_t most_runs = 100;  ///< for each of them
  /// Differences of 1 + p runs instead of sensitivities, for methods without these.
  bool differences = false;
  std::function<bool()> stop;           ///< asked after each step of each run; may be empty
  std::vector<std::string> understood;  ///< how files of data were read, a line each, told with the result
  std::vector<std::string> warnings;    ///< suspect features of the data, a sentence each, told among the warnings
};

/// Result for one parameter.
struct Estimate {
  std::string key;                  ///< of the parameter
  double estimate = 0.0;            ///< its value
  double standard_deviation = 0.0;  ///< of it, the model's own error included; NaN where the data do not determine it
  bool at_bound = false;            ///< it would leave its bounds: it has no deviation
};

/// A combination of parameters that the data do not determine: a change of p_i by share_i (p_i counted in its estimate)
/// leaves the model as it is.
struct Undetermined {
  double singular_value = 0.0;  ///< over the largest
  std::vector<double> shares;   ///< of the parameters, a unit vector
};

/// The result of a fit.
struct FitResult {
  std::vector<Estimate> parameters;        ///< n, in the order of the study
  std::vector<double> model_errors;        ///< n: what mesh, steps and tolerances of the model may move each by
  std::vector<double> covariance;          ///< n x n, with the squares of these; NaN where there is none
  std::vector<double> correlation;         ///< n x n
  std::vector<double> singular_values;     ///< of the Jacobian, parameters counted in their estimates; decreasing
  std::vector<Undetermined> undetermined;  ///< those that count for nothing
  double residual = 0.0;                   ///< (S / (m - n))^(1/2), m numbers measured
  /// The same of twice the elements, at their minimum near by; NaN where that was not looked for.
  double finer_residual = std::numeric_limits<double>::quiet_NaN();
  std::size_t measured = 0;                 ///< m
  std::size_t freedom = 0;                  ///< m - n; 0: the deviations are those of the data as given
  std::size_t runs = 0;                     ///< of the model, all starts together
  std::size_t iterations = 0;               ///< of the best start
  bool converged = false;                   ///< true if it reached a minimum and `warnings` is empty
  std::vector<std::string> warnings;        ///< reasons not to trust the result, a sentence each
  std::string reason;                       ///< why it ended
  std::vector<double> sums;                 ///< S at each start's end
  std::vector<std::vector<double>> traces;  ///< of the model, as the study's
  std::vector<Event> changes;               ///< of the model
  std::optional<double> lost;               ///< from when on the best run has no derivatives
};

/// Fits a model. @throws std::invalid_argument for a study that makes no sense, and where no run of it succeeds
/// @throws StudyStopped
FitResult fit(const FitStudy& study);

}  // namespace viscobar
