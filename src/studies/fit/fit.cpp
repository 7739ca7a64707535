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

  double sum() const { return residual.squaredNorm(); }  ///< S
  double variance(Eigen::Index parameters) const {
    return sum() / std::max(1.0, static_cast<double>(residual.size() - parameters));
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

Misfit measure(const FitStudy& study, const Eigen::VectorXd& values, bool derivatives) {
  Misfit misfit;
  Case run = study.model({values.data(), static_cast<std::size_t>(values.size())});
  double end = study.times.empty() ? 0.0 : study.times.back();
  for (const Event& change : study.changes) end = std::max(end, change.time);
  // A change that the model has later than the data counts, too.
  if (!study.changes.empty()) end *= 1.5;
  run.end = end;
  std::vector<double> times = study.times;
  const bool from_start = !times.empty() && times.front() == 0.0;
  if (!from_start) times.insert(times.begin(), 0.0);
  if (times.back() < end) times.push_back(end);
  if (times.size() < 2) throw std::invalid_argument("fit: the data have no time after 0");

  const BarSystem system = make_system(run);
  const Eigen::Index parameters = derivatives ? std::ssize(study.parameters) : 0;
  misfit.traces.assign(study.traces.size(), {});
  std::size_t told = 0;
  const std::size_t first = from_start ? 0 : 1;
  Observers observers;
  observers.off_the_clock = false;
  if (derivatives) observers.directions = run.directions;
  std::vector<double> residual;
  std::vector<Eigen::VectorXd> rows;
  observers.snapshot = [&](const Snapshot& at) {
    const std::size_t k = told++ - first;  // of a time before the data more than there are
    if (k >= study.times.size()) return;
    for (std::size_t i = 0; i < study.traces.size(); ++i) {
      const MeasuredTrace& trace = study.traces[i];
      const double value = value_of(trace.column, at);
      misfit.traces[i].push_back(value);
      if (std::isnan(trace.values[k])) continue;
      residual.push_back((value - trace.values[k]) / trace.deviation);
      Eigen::VectorXd row(parameters);
      for (Eigen::Index j = 0; j < parameters; ++j)
        row(j) = value_of(trace.column, at.sensitivities[j]) / trace.deviation;
      rows.push_back(row);
    }
  };
  observers.event = [&](const Event& event) { misfit.changes.push_back(event); };
  const Statistics done = simulate(run, system, times, observers);
  if (done.sensitivity) misfit.lost = done.sensitivity->lost;

  std::map<Kind, std::size_t> seen;
  for (const Event& measured : study.changes) {
    std::size_t skip = seen[kind(measured)]++;
    const auto same = std::ranges::find_if(
        misfit.changes, [&](const Event& event) { return kind(event) == kind(measured) && skip-- == 0; });
    Eigen::VectorXd row = Eigen::VectorXd::Zero(parameters);
    double time = 2.0 * end;
    if (same != misfit.changes.end()) {
      time = same->time;
      for (Eigen::Index j = 0; j < parameters; ++j) row(j) = same->sensitivities[j].time / study.change_deviation;
    }
    residual.push_back((time - measured.time) / study.change_deviation);
    rows.push_back(row);
  }
  misfit.residual = Eigen::Map<const Eigen::VectorXd>(residual.data(), std::ssize(residual));
  misfit.jacobian.resize(misfit.residual.size(), parameters);
  for (std::size_t i = 0; i < rows.size(); ++i)
    misfit.jacobian.row(i) = rows[i].allFinite() ? rows[i] : Eigen::VectorXd::Zero(parameters);
  misfit.sound = misfit.residual.allFinite();
  if (!misfit.sound) misfit.error = "the run is not finite";
  return misfit;
}

// Runs the model, and counts its runs. A measured contact change that the model does not have, in the order of those
// of its kind, counts as one at twice the end of the run.
Misfit measure_misfit(const FitStudy& study, const Eigen::VectorXd& values, std::size_t& runs) {
  ++runs;
  try {
    Misfit misfit = measure(study, values, !study.differences);
    if (!study.differences || !misfit.sound) return misfit;
    misfit.jacobian.resize(misfit.residual.size(), values.size());
    for (Eigen::Index k = 0; k < values.size(); ++k) {
      const FittedParameter& parameter = study.parameters[k];
      Eigen::VectorXd beside = values;
      const double step = 1e-4 * std::max(std::abs(values(k)), 1e-6);
      beside(k) += values(k) + step <= parameter.high ? step : -step;
      ++runs;
      const Misfit other = measure(study, beside, false);
      misfit.jacobian.col(k) = (other.residual - misfit.residual) / (beside(k) - values(k));
    }
    return misfit;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    Misfit failed;
    failed.error = error.what();
    return failed;
  }
}

// From here on a step changes nothing that the data tell: of a standard deviation, and of a parameter.
constexpr double small_step = 1e-3, rounding_step = 1e-9;

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

Minimum search(const FitStudy& study, const Eigen::VectorXd& start, std::size_t& runs) {
  const Eigen::Index n = std::ssize(study.parameters);
  Minimum now{start, measure_misfit(study, start, runs), 0, false, ""};
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
  const std::size_t first_run = runs;
  while (runs - first_run < study.most_runs) {
    const Eigen::MatrixXd& jacobian = now.misfit.jacobian;
    const Eigen::VectorXd gradient = jacobian.transpose() * now.misfit.residual;
    std::vector<Eigen::Index> free;
    for (Eigen::Index k = 0; k < n; ++k)
      if (!leaves(study.parameters[k], now.at(k), -gradient(k))) free.push_back(k);
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
    for (std::size_t j = 0; j < free.size(); ++j) {
      const FittedParameter& parameter = study.parameters[free[j]];
      next(free[j]) = std::clamp(now.at(free[j]) + step(j), parameter.low, parameter.high);
    }
    const Eigen::VectorXd moved = next - now.at;
    const double variance = now.misfit.variance(n);
    // Of the quadratic model: |J step|^2 in units of the variance is the step in standard deviations, squared.
    const double deviations = std::sqrt((jacobian * moved).squaredNorm() / std::max(variance, 1e-300));
    const bool still = ((moved.array().abs() <= rounding_step * now.at.array().abs().max(1e-300)).all());
    if ((damping <= 1.0 && deviations < small_step) || still)
      return converged("a step would change less than the data tell");
    Misfit trial = measure_misfit(study, next, runs);
    ++now.iterations;
    const double predicted = now.misfit.sum() - (now.misfit.residual + jacobian * moved).squaredNorm();
    const double gained = trial.sound ? now.misfit.sum() - trial.sum() : -1.0;
    if (gained > 0.0) {
      const double ratio = gained / std::max(predicted, 1e-300);
      damping *= ratio > 0.75 ? 0.1 : ratio > 0.25 ? 0.5 : 2.0;
      damping = std::max(damping, 1e-12);
      now.at = next;
      now.misfit = std::move(trial);
    } else {
      // What rounding makes of a sum is no gain to look for.
      if (trial.sound && std::abs(gained) <= 1e-12 * now.misfit.sum() && predicted <= 1e-9 * now.misfit.sum())
        return converged("the sum of squares does not fall any more");
      damping = std::max(10.0 * damping, 1e-3);
      if (damping > 1e12) return ended("no step makes the sum of squares smaller, though its derivatives say so");
    }
  }
  return ended(fmt::format("{} runs were not enough", study.most_runs));
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
  require(
      std::ranges::is_sorted(study.times, std::less_equal<>()) && (study.times.empty() || study.times.front() >= 0.0),
      "the times must increase, from 0 on");
}

void judge(const FitStudy& study, const Minimum& best, FitResult& result) {
  const Eigen::Index n = std::ssize(study.parameters);
  const Misfit& misfit = best.misfit;
  const double variance = misfit.variance(n);
  result.residual = std::sqrt(variance);
  result.measured = static_cast<std::size_t>(misfit.residual.size());
  constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
  const auto size = static_cast<std::size_t>(n);
  result.covariance.assign(size * size, nothing);
  result.correlation.assign(size * size, nothing);

  Eigen::VectorXd scale(n);
  std::vector<Eigen::Index> free;
  const Eigen::VectorXd gradient = misfit.jacobian.transpose() * misfit.residual;
  for (Eigen::Index k = 0; k < n; ++k) {
    const FittedParameter& parameter = study.parameters[k];
    const double range = parameter.high - parameter.low;
    scale(k) = best.at(k) != 0.0 ? std::abs(best.at(k)) : std::isfinite(range) ? range : 1.0;
    const bool bound = leaves(parameter, best.at(k), -gradient(k));
    result.parameters.push_back({parameter.key, best.at(k), nothing, bound});
    if (!bound) free.push_back(k);
  }
  if (free.empty()) return;
  const Eigen::MatrixXd scaled = misfit.jacobian(Eigen::all, free) * scale(free).asDiagonal();
  const Eigen::JacobiSVD<Eigen::MatrixXd> factors(scaled, Eigen::ComputeThinV);
  const Eigen::VectorXd values = factors.singularValues();
  const double largest = values.size() > 0 ? values(0) : 0.0;
  // What changes nothing: less than roundings make of it.
  const double least = 1e-8 * largest;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  std::vector<bool> known(size, true);
  for (Eigen::Index j = 0; j < values.size(); ++j) {
    result.singular_values.push_back(values(j));
    const Eigen::VectorXd direction = factors.matrixV().col(j);
    if (values(j) > least) {
      for (std::size_t a = 0; a < free.size(); ++a)
        for (std::size_t b = 0; b < free.size(); ++b)
          covariance(free[a], free[b]) +=
              variance * scale(free[a]) * scale(free[b]) * direction(a) * direction(b) / (values(j) * values(j));
      continue;
    }
    Undetermined lack{largest > 0.0 ? values(j) / largest : 0.0, std::vector<double>(size, 0.0)};
    for (std::size_t a = 0; a < free.size(); ++a) {
      lack.shares[free[a]] = direction(a);
      if (std::abs(lack.shares[free[a]]) > 1e-3) known[free[a]] = false;
    }
    result.undetermined.push_back(std::move(lack));
  }
  std::erase_if(free, [&](Eigen::Index k) { return !known[k]; });
  for (const Eigen::Index a : free) {
    result.parameters[a].standard_deviation = std::sqrt(covariance(a, a));
    for (const Eigen::Index b : free) {
      result.covariance[a * n + b] = covariance(a, b);
      result.correlation[a * n + b] = covariance(a, b) / std::sqrt(covariance(a, a) * covariance(b, b));
    }
  }
}

}  // namespace

FitResult fit(const FitStudy& study) {
  check(study);
  constexpr std::size_t primes[] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37};
  FitResult result;
  std::optional<Minimum> best;
  std::string error;
  for (std::size_t i = 0; i < std::max<std::size_t>(study.starts, 1); ++i) {
    Eigen::VectorXd start(study.parameters.size());
    for (std::size_t k = 0; k < study.parameters.size(); ++k) {
      const FittedParameter& parameter = study.parameters[k];
      start(k) = i == 0 ? parameter.start : parameter.low + (parameter.high - parameter.low) * halton(i, primes[k]);
    }
    Minimum found = search(study, start, result.runs);
    result.sums.push_back(found.misfit.sound ? found.misfit.sum() : std::numeric_limits<double>::quiet_NaN());
    if (!found.misfit.sound) {
      error = found.reason;
      continue;
    }
    if (!best || found.misfit.sum() < best->misfit.sum()) best = std::move(found);
  }
  if (!best) throw std::invalid_argument("fit: no start gives a run: " + error);
  judge(study, *best, result);
  result.iterations = best->iterations;
  result.converged = best->converged;
  result.reason = best->reason;
  result.traces = best->misfit.traces;
  result.changes = best->misfit.changes;
  result.lost = best->misfit.lost;
  return result;
}

}  // namespace viscobar
