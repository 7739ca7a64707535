#include "viscobar/studies/fit/fit.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <new>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace viscobar {

std::string_view name(TraceColumn column) {
  constexpr std::string_view names[] = {"u_left", "v_left", "reaction_left", "u_right", "v_right", "reaction_right"};
  return names[static_cast<std::size_t>(column)];
}

namespace {

// A run of the model beside the data.
struct Misfit {
  bool sound = false;                       ///< the run succeeded
  std::string error;                        ///< why it did not
  Eigen::VectorXd residual;                 ///< (model - data) / deviation of all numbers measured
  Eigen::MatrixXd jacobian;                 ///< of it by the parameters; a row is zero where there is no derivative
  std::vector<std::vector<double>> traces;  ///< of the model
  std::vector<Event> changes;               ///< likewise
  std::optional<double> lost;               ///< from when on there are no derivatives
  std::size_t steps = 0;                    ///< of the run

  double sum() const { return sound ? residual.squaredNorm() : std::numeric_limits<double>::infinity(); }  ///< S
  /// S / (m - n); of deviations that are as given, 1, where there are no more numbers than parameters.
  double variance(Eigen::Index parameters) const {
    const Eigen::Index freedom = residual.size() - parameters;
    return freedom > 0 ? sum() / static_cast<double>(freedom) : 1.0;
  }
};

template <class Fields>
double value_of(TraceColumn column, const Fields& at) {
  switch (column) {
    case TraceColumn::u_left: return at.u.front();
    case TraceColumn::v_left: return at.v.front();
    case TraceColumn::reaction_left: return at.reaction_left;
    case TraceColumn::u_right: return at.u.back();
    case TraceColumn::v_right: return at.v.back();
    case TraceColumn::reaction_right: return at.reaction_right;
  }
  return 0.0;
}

using Kind = std::tuple<Where, std::size_t, Change>;
Kind kind(const Event& event) { return {event.where, event.where == Where::span ? event.node : 0, event.change}; }

// What is compared. Samples of velocities and reactions, which jump, make many valleys; their integrals from the first
// sample on change smoothly with the parameters.
enum class Compared { samples, integrals };

bool is_displacement(TraceColumn column) { return column == TraceColumn::u_left || column == TraceColumn::u_right; }
bool is_velocity(TraceColumn column) { return column == TraceColumn::v_left || column == TraceColumn::v_right; }
bool is_left(TraceColumn column) { return column <= TraceColumn::reaction_left; }

// A number and, behind it, its derivatives by the parameters.
using Traced = Eigen::VectorXd;
double number(const Traced& traced) { return traced(0); }
Traced product(const Traced& a, const Traced& b) {
  Traced both = number(a) * b + number(b) * a;
  both(0) = number(a) * number(b);
  return both;
}

// How close a contact change is to t_k, from 0 at the samples beside it to 1.
Traced closeness(const std::vector<double>& t, std::size_t k, std::span<const Event> changes, Eigen::Index size) {
  Traced close = Traced::Zero(size);
  for (const Event& at : changes) {
    const bool earlier = at.time < t[k];
    const double side = earlier ? t[k] - t[k > 0 ? k - 1 : 0] : t[std::min(k + 1, t.size() - 1)] - t[k];
    const double away = std::abs(at.time - t[k]);
    if (away >= side || 1.0 - away / side <= number(close)) continue;
    close(0) = 1.0 - away / side;
    for (Eigen::Index j = 1; j < size; ++j) close(j) = (earlier ? 1.0 : -1.0) * at.sensitivities[j - 1].time / side;
  }
  return close;
}

// A sample beside a contact change tells its time no better than the sampling does: it is compared with the nearest
// value of the model from the sample before to the one behind, of less than that the farther off the change is, for S
// is to be continuous.
void compare_samples(const MeasuredTrace& trace, const std::vector<double>& t, const std::vector<Traced>& model,
                     std::span<const Event> changes, std::vector<Traced>& rows) {
  for (std::size_t k = 0; k < t.size(); ++k) {
    const double datum = trace.values[k];
    if (std::isnan(datum)) continue;
    Traced row = model[k];
    if (const Traced close = closeness(t, k, changes, row.size()); number(close) > 0.0) {
      const auto towards = [&](std::size_t other) { return Traced(row + product(close, model[other] - row)); };
      const Traced about[] = {row, towards(k > 0 ? k - 1 : 0), towards(std::min(k + 1, t.size() - 1))};
      const auto [low, high] = std::ranges::minmax_element(about, {}, number);
      row = datum < number(*low) ? *low : datum > number(*high) ? *high : Traced::Unit(row.size(), 0) * datum;
    }
    row(0) -= datum;
    rows.push_back(row / trace.deviation);
  }
}

// `model` has the integrals of the model, from any time on; those of the data are by the trapezoidal rule.
void compare_integrals(const MeasuredTrace& trace, const std::vector<double>& t, const std::vector<Traced>& model,
                       std::vector<Traced>& rows) {
  const std::size_t begin = rows.size();
  std::optional<std::size_t> first, last;
  double integral = 0.0, most = 0.0, most_integral = 0.0;
  for (std::size_t k = 0; k < t.size(); ++k) {
    if (std::isnan(trace.values[k])) continue;
    if (last) integral += 0.5 * (trace.values[k] + trace.values[*last]) * (t[k] - t[*last]);
    if (!first) first = k;
    last = k;
    rows.push_back(model[k] - model[*first]);
    rows.back()(0) -= integral;
    most = std::max(most, std::abs(trace.values[k]));
    most_integral = std::max(most_integral, std::abs(integral));
  }
  const double deviation = trace.deviation * (most_integral > 0.0 ? most_integral / most : 1.0);
  for (std::size_t k = begin; k < rows.size(); ++k) rows[k] /= deviation;
}

// Integrals of a reaction: where its contact closes or opens between two samples, over that part of the interval.
std::vector<Traced> impulses(Where where, const std::vector<double>& t, const std::vector<Traced>& reaction,
                             const std::vector<Event>& changes) {
  const Eigen::Index n = reaction.front().size();
  std::vector<Traced> sums = {Traced::Zero(n)};
  std::size_t next = 0;
  for (std::size_t k = 1; k < t.size(); ++k) {
    double share = 0.5;
    Traced length = Traced::Unit(n, 0) * (t[k] - t[k - 1]);
    for (; next < changes.size() && changes[next].time <= t[k]; ++next) {
      const Event& change = changes[next];
      if (change.where != where || change.time < t[k - 1]) continue;
      const bool closes = change.change == Change::closing;
      share = 1.0;
      length(0) -= closes ? change.time - t[k - 1] : t[k] - change.time;
      for (Eigen::Index j = 1; j < n; ++j) length(j) -= (closes ? 1.0 : -1.0) * change.sensitivities[j - 1].time;
    }
    length(0) = std::max(length(0), 0.0);
    sums.push_back(sums.back() + product(share * (reaction[k - 1] + reaction[k]), length));
  }
  return sums;
}

// Runs a model beside the data, with so many steps at most. A measured contact change that the model does not have, in
// the order of those of its kind, counts as one at twice the end of the run.
Misfit measure(const FitStudy& study, Case run, Compared compared, bool derivatives, std::size_t most_steps) {
  Misfit misfit;
  double end = study.times.empty() ? 0.0 : study.times.back();
  for (const Event& change : study.changes) end = std::max(end, change.time);
  // A change that the model has later than the data counts, too.
  if (!study.changes.empty()) end *= 1.5;
  run.end = end;
  std::vector<double> times = study.times;
  times.erase(std::unique(times.begin(), times.end()), times.end());
  if (times.empty() || times.front() > 0.0) times.insert(times.begin(), 0.0);
  if (times.back() < end) times.push_back(end);
  if (times.size() < 2) throw std::invalid_argument("fit: the data have no time after 0");

  const Setup setup = resolve(run);
  const Eigen::Index parameters = derivatives ? std::ssize(study.parameters) : 0;
  std::vector<std::vector<Traced>> model(study.traces.size());
  Observers observers;
  observers.off_the_clock = false;
  if (derivatives) observers.directions = run.directions;
  observers.snapshot = [&, told = std::size_t{0}](const Snapshot& at) mutable {
    for (; told < study.times.size() && study.times[told] == at.time; ++told)
      for (std::size_t i = 0; i < model.size(); ++i) {
        TraceColumn column = study.traces[i].column;
        if (compared == Compared::integrals && is_velocity(column))
          column = is_left(column) ? TraceColumn::u_left : TraceColumn::u_right;
        model[i].emplace_back(1 + parameters);
        model[i].back()(0) = value_of(column, at);
        for (Eigen::Index j = 0; j < parameters; ++j) model[i].back()(1 + j) = value_of(column, at.sensitivities[j]);
      }
  };
  observers.event = [&](const Event& event) { misfit.changes.push_back(event); };
  bool stopped = false;
  observers.progress = [&](double) {
    stopped = stopped || (study.stop && study.stop());
    return stopped || ++misfit.steps > most_steps ? RunControl::stop : RunControl::go_on;
  };
  const Statistics done = simulate(setup, times, observers);
  if (stopped) throw FitStopped();
  if (!done.completed) throw std::runtime_error(fmt::format("the run takes more than {} steps", most_steps));
  if (done.sensitivity) misfit.lost = done.sensitivity->lost;

  std::vector<Traced> rows;
  for (std::size_t i = 0; i < model.size(); ++i) {
    const MeasuredTrace& trace = study.traces[i];
    const bool smooth = is_displacement(trace.column);
    misfit.traces.emplace_back();
    std::ranges::transform(model[i], std::back_inserter(misfit.traces.back()), number);
    if (smooth || compared == Compared::samples)
      compare_samples(trace, study.times, model[i], smooth ? std::span<const Event>() : misfit.changes, rows);
    else if (is_velocity(trace.column))
      compare_integrals(trace, study.times, model[i], rows);
    else
      compare_integrals(
          trace, study.times,
          impulses(is_left(trace.column) ? Where::left : Where::right, study.times, model[i], misfit.changes), rows);
  }
  std::map<Kind, std::size_t> seen;
  for (const Event& measured : study.changes) {
    std::size_t skip = seen[kind(measured)]++;
    const auto same = std::ranges::find_if(
        misfit.changes, [&](const Event& event) { return kind(event) == kind(measured) && skip-- == 0; });
    Traced row = Traced::Zero(1 + parameters);
    row(0) = (same == misfit.changes.end() ? 2.0 * end : same->time) - measured.time;
    if (same != misfit.changes.end())
      for (Eigen::Index j = 0; j < parameters; ++j) row(1 + j) = same->sensitivities[j].time;
    rows.push_back(row / study.change_deviation);
  }
  misfit.residual.resize(std::ssize(rows));
  misfit.jacobian = Eigen::MatrixXd::Zero(std::ssize(rows), parameters);
  for (Eigen::Index i = 0; i < std::ssize(rows); ++i) {
    misfit.residual(i) = number(rows[i]);
    if (rows[i].allFinite()) misfit.jacobian.row(i) = rows[i].tail(parameters);
  }
  misfit.sound = misfit.residual.allFinite();
  if (!misfit.sound) misfit.error = "the run is not finite";
  return misfit;
}

// From here on a step changes nothing that the data tell: of a standard deviation, and of a parameter.
constexpr double small_step = 1e-3, rounding_step = 1e-9;
// A residual, in deviations: so small that no other minimum is of interest, and so large that the model is not the
// data's.
constexpr double small_residual = 0.01, large_residual = 3.0;
// So many times as large or small as where it begins a parameter is looked for.
constexpr double far_off = 10.0;
// So large where it follows a curve.
constexpr double curved_residual = 1.2;

struct Minimum {
  Eigen::VectorXd at;
  Misfit misfit;
  std::size_t iterations = 0;
  bool converged = false;
  std::string reason;
};

bool leaves(const FittedParameter& parameter, double value, double step) {
  return (value <= parameter.low && step < 0.0) || (value >= parameter.high && step > 0.0);
}

class Search {
 public:
  explicit Search(const FitStudy& study) : study_(study), n_(std::ssize(study.parameters)) {}

  std::size_t runs = 0;

  // A run at these values; of one that fails, why. A trial run takes no more than so many times the steps of the first.
  Misfit at(const Eigen::VectorXd& values, Compared compared, bool derivatives = true) {
    try {
      Misfit misfit = run(values, compared, derivatives && !study_.differences);
      if (most_steps_ == unlimited) most_steps_ = 1000 + 50 * misfit.steps;
      // Where derivatives end, differences go on.
      if (derivatives && misfit.sound && (study_.differences || misfit.lost)) difference(values, compared, misfit);
      return misfit;
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      Misfit failed;
      failed.error = error.what();
      return failed;
    }
  }

  bool jumps() const {
    return std::ranges::any_of(study_.traces, [](const MeasuredTrace& one) { return !is_displacement(one.column); });
  }

  // Integrals of what jumps lead to the neighbourhood of a minimum, samples to the minimum.
  Minimum minimum_from(Eigen::VectorXd start, Compared first, std::size_t most_runs) {
    if (first == Compared::integrals && jumps())
      if (const Minimum near = descend(start, Compared::integrals, most_runs); near.misfit.sound) start = near.at;
    return descend(start, Compared::samples, most_runs);
  }

 private:
  static constexpr std::size_t unlimited = std::numeric_limits<std::size_t>::max();

  Misfit run(const Eigen::VectorXd& values, Compared compared, bool derivatives) {
    ++runs;
    return measure(study_, study_.model({values.data(), static_cast<std::size_t>(values.size())}), compared,
                   derivatives, most_steps_);
  }

  void difference(const Eigen::VectorXd& values, Compared compared, Misfit& misfit) {
    misfit.jacobian.resize(misfit.residual.size(), n_);
    for (Eigen::Index k = 0; k < n_; ++k) {
      const FittedParameter& parameter = study_.parameters[k];
      const double step = 1e-4 * std::max({std::abs(values(k)), 1e-2 * std::abs(parameter.start), 1e-6});
      const double forth = values(k) + step <= parameter.high ? step : -step;
      Eigen::VectorXd beside = values;
      beside(k) += forth;
      const Misfit other = run(beside, compared, false);
      misfit.jacobian.col(k) = (other.residual - misfit.residual) / (beside(k) - values(k));
    }
  }

  // No step is longer than the parameter is large, three times, or takes more than three quarters of a positive one.
  double limited(Eigen::Index k, double from, double to) const {
    const FittedParameter& parameter = study_.parameters[k];
    const double given = std::abs(parameter.start), size = std::max(std::abs(from), 0.1 * given), far = 1e4;
    // Nor does any lead to where no run ends, or nothing moves.
    if (given > 0.0) to = std::clamp(to, parameter.low >= 0.0 ? given / far : -given * far, given * far);
    if (size > 0.0) to = std::clamp(to, parameter.low >= 0.0 ? 0.25 * from : from - 3.0 * size, from + 3.0 * size);
    return std::clamp(to, parameter.low, parameter.high);
  }

  Minimum descend(const Eigen::VectorXd& start, Compared compared, std::size_t most_runs) {
    Minimum now{start, at(start, compared), 0, false, ""};
    const auto ended = [&now](std::string reason) {
      now.reason = std::move(reason);
      return now;
    };
    const auto converged = [&](const char* reason) {
      now.converged = true;
      return ended(reason);
    };
    if (!now.misfit.sound) return ended(now.misfit.error);
    double damping = 1e-3;
    bool differenced = study_.differences;
    const std::size_t first_run = runs;
    while (runs - first_run < most_runs) {
      const Eigen::MatrixXd& jacobian = now.misfit.jacobian;
      const Eigen::VectorXd gradient = jacobian.transpose() * now.misfit.residual;
      std::vector<Eigen::Index> free;
      for (Eigen::Index k = 0; k < n_; ++k)
        if (!leaves(study_.parameters[k], now.at(k), -gradient(k))) free.push_back(k);
      if (free.empty()) return converged("all parameters are at their bounds");
      const Eigen::MatrixXd part = jacobian(Eigen::all, free);
      const Eigen::MatrixXd normal = part.transpose() * part;
      const Eigen::VectorXd slope = gradient(free);
      Eigen::VectorXd scale = normal.diagonal();
      const double least = 1e-30 * std::max(scale.maxCoeff(), 1e-300);
      scale = scale.cwiseMax(least);
      Eigen::MatrixXd damped = normal;
      damped.diagonal() += damping * scale;
      const Eigen::VectorXd step = damped.ldlt().solve(-slope);
      Eigen::VectorXd next = now.at;
      for (std::size_t j = 0; j < free.size(); ++j)
        next(free[j]) = limited(free[j], now.at(free[j]), now.at(free[j]) + step(j));
      const Eigen::VectorXd moved = next - now.at;
      const double variance = now.misfit.variance(n_);
      // Of the quadratic model: |J step|^2 in units of the variance is the step in standard deviations, squared.
      const double deviations = std::sqrt((jacobian * moved).squaredNorm() / std::max(variance, 1e-300));
      const bool still = ((moved.array().abs() <= rounding_step * now.at.array().abs().max(1e-300)).all());
      if ((damping <= 1.0 && deviations < small_step) || still)
        return converged("a step would change less than the data tell");
      Misfit trial = at(next, compared);
      ++now.iterations;
      const double predicted = now.misfit.sum() - (now.misfit.residual + jacobian * moved).squaredNorm();
      const double gained = trial.sound ? now.misfit.sum() - trial.sum() : -1.0;
      if (gained > 0.0) {
        const double ratio = gained / std::max(predicted, 1e-300);
        damping *= ratio > 0.75 ? 0.1 : ratio > 0.25 ? 0.5 : 2.0;
        damping = std::max(damping, 1e-12);
        now.at = next;
        now.misfit = std::move(trial);
        continue;
      }
      // What rounding makes of a sum is no gain to look for.
      if (trial.sound && std::abs(gained) <= 1e-12 * now.misfit.sum() && predicted <= 1e-9 * now.misfit.sum())
        return converged("the sum of squares does not fall any more");
      damping = std::max(10.0 * damping, 1e-3);
      if (damping < 1e8) continue;
      if (differenced) return ended("no step makes the sum of squares smaller, though its derivatives say so");
      try {  // the sum of squares has a kink, which its derivatives on one side do not tell
        difference(now.at, compared, now.misfit);
      } catch (const std::runtime_error& error) {
        return ended(error.what());
      }
      differenced = true;
      damping = 1e-3;
    }
    return ended(fmt::format("{} runs were not enough", most_runs));
  }

  const FitStudy& study_;
  Eigen::Index n_;
  std::size_t most_steps_ = unlimited;
};

// Whether what is left follows a curve: its successive values are alike, as those of noise are not, whose squared
// differences are twice its squares, to 2 / m^(1/2). Or whether it stands out at few places: the median of noise is two
// thirds of its root mean square. Of few numbers nobody can tell.
bool is_systematic(const Eigen::VectorXd& residual, Eigen::Index parameters) {
  const Eigen::Index m = residual.size();
  if (m < parameters + 8) return true;
  const double sum = residual.squaredNorm(), size = static_cast<double>(m);
  std::vector<double> sizes(residual.begin(), residual.end());
  for (double& one : sizes) one = std::abs(one);
  std::ranges::nth_element(sizes, sizes.begin() + m / 2);
  return (residual.tail(m - 1) - residual.head(m - 1)).squaredNorm() <
             std::max(1.2, 2.0 - 6.0 / std::sqrt(size)) * sum ||
         sizes[static_cast<std::size_t>(m / 2)] < 0.3 * std::sqrt(sum / size);
}

double residual_of(const Misfit& misfit, Eigen::Index parameters) {
  return std::sqrt(misfit.sum() / static_cast<double>(std::max<Eigen::Index>(misfit.residual.size() - parameters, 1)));
}

bool is_large(const FitStudy& study, const Misfit& misfit) {
  const Eigen::Index n = std::ssize(study.parameters);
  const double residual = residual_of(misfit, n);
  if (residual <= curved_residual) return false;
  const bool assumed = std::ranges::all_of(study.traces, &MeasuredTrace::assumed) && study.changes.empty();
  if (residual > large_residual && !assumed) return true;
  return misfit.residual.size() >= n + 8 || residual > large_residual ? is_systematic(misfit.residual, n) : false;
}

bool is_explained(const FitStudy& study, const Misfit& misfit) {
  const Eigen::Index n = std::ssize(study.parameters);
  if (!misfit.sound) return false;
  return residual_of(misfit, n) <= small_residual || (!is_systematic(misfit.residual, n) && !is_large(study, misfit));
}

// A parameter that the data hardly know, far from where it begins, seldom is that of the best minimum.
bool runs_away(const FitStudy& study, const Eigen::VectorXd& values, const Misfit& misfit) {
  const Eigen::MatrixXd inverse = (misfit.jacobian.transpose() * misfit.jacobian).inverse();
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const double start = study.parameters[k].start, ratio = std::abs(values(k) / start);
    const bool known = misfit.variance(values.size()) * inverse(k, k) < values(k) * values(k);
    if (start != 0.0 && !known && (ratio > far_off || ratio < 1.0 / far_off)) return true;
  }
  return false;
}

// Halton's points, which fill the bounds evenly.
double halton(std::size_t i, std::size_t base) {
  double fraction = 1.0, value = 0.0;
  for (; i > 0; i /= base) fraction /= static_cast<double>(base), value += fraction * static_cast<double>(i % base);
  return value;
}

void check(const FitStudy& study) {
  const auto require = [](bool holds, const std::string& what) {
    if (!holds) throw std::invalid_argument("fit: " + what);
  };
  require(!study.parameters.empty(), "there is no parameter to look for");
  require(!study.traces.empty() || !study.changes.empty(), "there are no data");
  for (const FittedParameter& parameter : study.parameters) {
    require(std::isfinite(parameter.start) && parameter.low <= parameter.start && parameter.start <= parameter.high,
            fmt::format("{} begins at {}, outside of its bounds {} to {}", parameter.key, parameter.start,
                        parameter.low, parameter.high));
    require(study.starts <= 1 || (std::isfinite(parameter.low) && std::isfinite(parameter.high)),
            fmt::format("several starts are spread over the bounds, and {} has none", parameter.key));
  }
  require(study.parameters.size() <= 12, "at most 12 parameters can be looked for");
  for (const MeasuredTrace& trace : study.traces) {
    require(trace.values.size() == study.times.size(),
            fmt::format("{} has not a value for each time", name(trace.column)));
    require(trace.deviation > 0.0, fmt::format("the deviation of {} is not positive", name(trace.column)));
  }
  require(study.change_deviation > 0.0, "the deviation of the contact times is not positive");
  require(std::ranges::is_sorted(study.times) && (study.times.empty() || study.times.front() >= 0.0),
          "the times must not fall, and begin at 0 or later");
  require(!study.changes.empty() || std::ranges::any_of(study.traces,
                                                        [](const MeasuredTrace& trace) {
                                                          return std::ranges::any_of(trace.values, [](double value) {
                                                            return std::isfinite(value);
                                                          });
                                                        }),
          "the data have no value");
}

// Contact changes are where something can touch.
void check_places(const FitStudy& study) {
  std::vector<double> values;
  for (const FittedParameter& parameter : study.parameters) values.push_back(parameter.start);
  const Case run = study.changes.empty() ? Case() : study.model(values);
  for (const Event& change : study.changes) {
    const bool left = change.where == Where::left;
    if (change.where == Where::span ? run.scene.span && change.node <= run.elements
                                    : is_obstacle(left ? run.scene.left : run.scene.right))
      continue;
    const std::string place = change.where == Where::span ? fmt::format("node {} of a span obstacle", change.node)
                                                          : fmt::format("the {} end", left ? "left" : "right");
    throw std::invalid_argument(
        fmt::format("fit: a contact was measured at t = {} at {}, where the scene has none", change.time, place));
  }
}

// The same case with half of the errors of its mesh, its steps and its tolerances, or less.
Case finer(Case run) {
  run.elements *= 2;
  run.tolerance.relative = std::max(0.1 * run.tolerance.relative, 1e-13);
  if (run.tolerance.absolute) *run.tolerance.absolute *= 0.1;
  if (run.step) *run.step *= 0.5;
  run.directions.clear();
  return run;
}

// How far the model's own error moves the parameters, counted in `scale`: what a finer run changes its values by, twice
// for an error of order one, taken for data that are wrong by so much.
Eigen::VectorXd model_error(const FitStudy& study, const Minimum& best, const Eigen::MatrixXd& scaled,
                            const Eigen::MatrixXd& inverse, FitResult& result) {
  try {
    const Case run = finer(study.model({best.at.data(), static_cast<std::size_t>(best.at.size())}));
    if (const auto found = faults(resolve(run)); !found.empty()) throw std::runtime_error(found.front().problem);
    ++result.runs;
    const Misfit fine = measure(study, run, Compared::samples, false, 1000 + 200 * best.misfit.steps);
    return 2.0 * (inverse * (scaled.transpose() * (fine.residual - best.misfit.residual))).cwiseAbs();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    result.doubts.push_back(fmt::format("the model's own error is not in the deviations: {}", error.what()));
    return Eigen::VectorXd::Zero(inverse.rows());
  }
}

void judge(const FitStudy& study, const Minimum& best, FitResult& result) {
  const Eigen::Index n = std::ssize(study.parameters);
  const Misfit& misfit = best.misfit;
  const double variance = misfit.variance(n);
  result.residual = residual_of(misfit, n);
  result.measured = static_cast<std::size_t>(misfit.residual.size());
  result.freedom = static_cast<std::size_t>(std::max<Eigen::Index>(misfit.residual.size() - n, 0));
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const auto size = static_cast<std::size_t>(n);
  result.covariance.assign(size * size, none);
  result.correlation.assign(size * size, none);
  result.model_errors.assign(size, none);

  Eigen::VectorXd scale(n);
  std::vector<Eigen::Index> free;
  const Eigen::VectorXd gradient = misfit.jacobian.transpose() * misfit.residual;
  for (Eigen::Index k = 0; k < n; ++k) {
    const FittedParameter& parameter = study.parameters[k];
    const double range = parameter.high - parameter.low;
    scale(k) = best.at(k) != 0.0 ? std::abs(best.at(k)) : std::isfinite(range) ? range : 1.0;
    const bool bound = leaves(parameter, best.at(k), -gradient(k));
    result.parameters.push_back({parameter.key, best.at(k), none, bound});
    if (!bound) free.push_back(k);
  }
  if (free.empty()) return;
  const auto count = std::ssize(free);
  const Eigen::MatrixXd scaled = misfit.jacobian(Eigen::all, free) * scale(free).asDiagonal();
  const Eigen::JacobiSVD<Eigen::MatrixXd> factors(scaled, Eigen::ComputeFullV);
  Eigen::VectorXd values = Eigen::VectorXd::Zero(count);
  values.head(factors.singularValues().size()) = factors.singularValues();
  // What changes nothing: less than roundings make of it.
  const double least = std::max(1e-8 * values(0), 1e-6);
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(count, count);
  std::vector<bool> known(size, true);
  for (Eigen::Index j = 0; j < count; ++j) {
    result.singular_values.push_back(values(j));
    const Eigen::VectorXd direction = factors.matrixV().col(j);
    if (values(j) > least) {
      inverse += direction * direction.transpose() / (values(j) * values(j));
      continue;
    }
    Undetermined lack{values(0) > 0.0 ? values(j) / values(0) : 0.0, std::vector<double>(size, 0.0)};
    for (Eigen::Index a = 0; a < count; ++a) {
      lack.shares[free[a]] = direction(a);
      if (std::abs(direction(a)) > 1e-3) known[free[a]] = false;
    }
    result.undetermined.push_back(std::move(lack));
  }
  const Eigen::VectorXd moved = model_error(study, best, scaled, inverse, result);
  for (Eigen::Index a = 0; a < count; ++a) {
    const FittedParameter& parameter = study.parameters[free[a]];
    Estimate& one = result.parameters[free[a]];
    if (!known[free[a]]) continue;
    const double error = scale(free[a]) * moved(a);
    const double deviation = std::hypot(scale(free[a]) * std::sqrt(variance * inverse(a, a)), error);
    // A step of one deviation leaves the bounds, or what the parameter is large by.
    if (deviation > std::min(0.5 * (parameter.high - parameter.low),
                             10.0 * std::max(std::abs(one.estimate), std::abs(parameter.start)))) {
      known[free[a]] = false;
      result.undetermined.push_back(
          {inverse(a, a) > 0.0 ? 1.0 / std::sqrt(inverse(a, a)) / values(0) : 0.0, std::vector<double>(size, 0.0)});
      result.undetermined.back().shares[free[a]] = 1.0;
      continue;
    }
    result.model_errors[free[a]] = error;
    if (deviation > 0.0) one.standard_deviation = deviation;
  }
  for (Eigen::Index a = 0; a < count; ++a)
    for (Eigen::Index b = 0; b < count; ++b) {
      if (!known[free[a]] || !known[free[b]]) continue;
      const double covariance = variance * scale(free[a]) * scale(free[b]) * inverse(a, b);
      const std::size_t at = static_cast<std::size_t>(free[a] * n + free[b]);
      result.covariance[at] = covariance + (a == b ? std::pow(result.model_errors[free[a]], 2) : 0.0);
      result.correlation[at] = inverse(a, b) / std::sqrt(inverse(a, a) * inverse(b, b));
    }
}

// Other values than the best that meet the data as well.
bool is_another(const Minimum& other, const Minimum& best, const FitResult& result) {
  const double variance = std::max(std::pow(result.residual, 2), std::pow(small_residual, 2));
  if (!other.misfit.sound || other.misfit.sum() - best.misfit.sum() > 4.0 * variance) return false;
  for (Eigen::Index k = 0; k < best.at.size(); ++k) {
    const double deviation = result.parameters[k].standard_deviation;  // NaN: whatever the value, the data agree
    if (std::abs(other.at(k) - best.at(k)) > std::max(5.0 * deviation, 0.01 * std::abs(best.at(k)))) return true;
  }
  return false;
}

// What speaks against a minimum.
void doubt(const FitStudy& study, const std::vector<Minimum>& found, const Minimum& best, FitResult& result) {
  const std::size_t before = result.doubts.size();
  if (is_large(study, best.misfit))
    result.doubts.push_back(
        fmt::format("the model stays {:.3g} deviations away from the data: either it is not theirs, or these are not "
                    "the values; other starts, bounds, or parameters that are held now may help",
                    result.residual));
  for (const Minimum& other : found)
    if (is_another(other, best, result)) {
      std::string values;
      for (Eigen::Index k = 0; k < other.at.size(); ++k)
        values += fmt::format("{}{} = {:.6g}", values.empty() ? "" : ", ", study.parameters[k].key, other.at(k));
      result.doubts.push_back("starts disagree: other values meet the data as well: " + values);
      break;
    }
  const bool bound = std::ranges::any_of(result.parameters, &Estimate::at_bound);
  if (result.doubts.size() == before && !bound && result.undetermined.empty()) return;
  if (result.converged) result.reason = "it came to a minimum that is not to be relied on: see the warnings";
  result.converged = false;
}

constexpr std::size_t primes[] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37};

// The i-th of values near some: within that part of them.
Eigen::VectorXd near_to(Eigen::VectorXd values, double distance, const FitStudy& study, std::size_t i) {
  for (std::size_t k = 0; k < study.parameters.size(); ++k) {
    const FittedParameter& parameter = study.parameters[k];
    const double size = values(k) != 0.0 ? values(k) : 0.1 * parameter.start;
    values(k) =
        std::clamp(values(k) + size * (2.0 * halton(i, primes[k]) - 1.0) * distance, parameter.low, parameter.high);
  }
  return values;
}

// The i-th of values to begin with, besides those given.
Eigen::VectorXd start_of(const FitStudy& study, std::size_t i, bool spread) {
  Eigen::VectorXd start(study.parameters.size());
  for (std::size_t k = 0; k < study.parameters.size(); ++k) {
    const auto& [key, given, low, high] = study.parameters[k];
    // Up to twice as far off as is looked for, and every other one between bounds that are near.
    const double size = given != 0.0 ? std::abs(given) : 1.0;
    const bool linear = spread || (i % 2 == 0 && high - low <= 1e3 * size);
    const double part = halton(spread ? i : (i + 1) / 2, primes[k]);
    const double sign = low < 0.0 && i % 4 < 2 ? -1.0 : 1.0;
    const double logarithmic = high - low <= 1e3 * size ? part : halton(i, primes[k]);
    start(k) =
        linear ? low + (high - low) * part
               : std::clamp(std::copysign(1.0, given) * sign * size * std::pow(2.0 * far_off, 2.0 * logarithmic - 1.0),
                            low, high);
  }
  return start;
}

}  // namespace

FitResult fit(const FitStudy& study) {
  check(study);
  check_places(study);
  FitResult result;
  Search search(study);
  std::vector<Minimum> found;
  std::size_t best = 0;
  const auto begin_at = [&](const Eigen::VectorXd& start, Compared first, std::size_t most) {
    found.push_back(search.minimum_from(start, first, most));
    result.sums.push_back(found.back().misfit.sound ? found.back().misfit.sum()
                                                    : std::numeric_limits<double>::quiet_NaN());
    if (found.back().misfit.sum() < found[best].misfit.sum()) best = found.size() - 1;
    return is_explained(study, found[best].misfit) && !runs_away(study, found[best].at, found[best].misfit);
  };
  Eigen::VectorXd given(study.parameters.size());
  for (std::size_t k = 0; k < study.parameters.size(); ++k) given(k) = study.parameters[k].start;
  bool explained = begin_at(given, Compared::integrals, study.most_runs);
  for (std::size_t i = 1; i < study.starts; ++i)
    explained = begin_at(start_of(study, i, true), Compared::integrals, study.most_runs);
  // Many runs without derivatives say where to begin again.
  const std::size_t tries = 24 * std::min<std::size_t>(study.parameters.size(), 4), most_runs = 8 * study.most_runs;
  // The best of them shows soon; it goes on below.
  const std::size_t few_runs = (study.most_runs + 3) / 4;
  std::size_t far = 0, near = 0;
  const auto begin_among = [&](std::size_t count, std::size_t most, Compared compared, const auto& next) {
    std::vector<std::pair<double, Eigen::VectorXd>> tried;
    for (std::size_t i = 0; i < count && search.runs < most_runs; ++i) {
      const Eigen::VectorXd start = next();
      tried.emplace_back(search.at(start, compared, false).sum(), start);
    }
    std::ranges::sort(tried, {}, [](const auto& one) { return one.first; });
    for (std::size_t i = 0; i < std::min(most, tried.size()) && search.runs < most_runs; ++i)
      if (std::isfinite(tried[i].first)) explained = begin_at(tried[i].second, compared, few_runs);
  };
  // Jumps of velocities and reactions leave narrow valleys beside each other: from one of them to the next, as long as
  // that leads down.
  const auto begin_near = [&](std::size_t count) {
    for (double least = INFINITY; found[best].misfit.sum() < least && search.runs < most_runs;) {
      // A third of a standard deviation.
      least = found[best].misfit.sum() - 0.1 * found[best].misfit.variance(given.size());
      for (const double distance : {1.0 / 3.0, 0.1, 1.0 / 30.0, 0.01, 1.0 / 300.0}) {
        const Eigen::VectorXd centre = found[best].at;
        begin_among(count, 1, Compared::samples, [&] { return near_to(centre, distance, study, ++near); });
      }
    }
  };
  for (std::size_t round = 0; round < 6 && !explained && search.runs < most_runs; ++round) {
    begin_among(tries, 4, Compared::integrals, [&] { return start_of(study, ++far, false); });
    if (search.jumps()) begin_near(tries / 8);
  }
  if (explained && search.jumps() && residual_of(found[best].misfit, given.size()) > small_residual)
    begin_near(tries / 12);
  if (!found[best].converged && found.size() > study.starts)
    explained = begin_at(found[best].at, Compared::samples, study.most_runs);
  const Minimum& minimum = found[best];
  if (!minimum.misfit.sound) throw std::invalid_argument("fit: no start gives a run: " + found.front().reason);
  result.runs = search.runs;
  result.iterations = minimum.iterations;
  result.converged = minimum.converged;
  result.reason = minimum.reason;
  judge(study, minimum, result);
  doubt(study, found, minimum, result);
  result.traces = minimum.misfit.traces;
  result.changes = minimum.misfit.changes;
  result.lost = minimum.misfit.lost;
  return result;
}

}  // namespace viscobar
