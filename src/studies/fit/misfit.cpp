#include "studies/fit/misfit.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <new>
#include <tuple>

namespace viscobar {

std::string_view name(TraceColumn column) {
  switch (column) {
    case TraceColumn::u_left: return "u_left";
    case TraceColumn::v_left: return "v_left";
    case TraceColumn::reaction_left: return "reaction_left";
    case TraceColumn::u_right: return "u_right";
    case TraceColumn::v_right: return "v_right";
    case TraceColumn::reaction_right: return "reaction_right";
  }
  return {};
}

namespace {

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
  const auto parameters = derivatives ? static_cast<Eigen::Index>(study.parameters.size()) : 0;
  misfit.traces.assign(study.traces.size(), {});
  std::size_t told = 0;
  Observers observers;
  observers.off_the_clock = false;
  if (derivatives) observers.directions = run.directions;
  std::vector<double> residual;
  std::vector<Eigen::VectorXd> rows;
  observers.snapshot = [&](const Snapshot& at) {
    const std::size_t index = told++;
    if (index < (from_start ? 0 : 1) || index - (from_start ? 0 : 1) >= study.times.size()) return;
    const std::size_t k = index - (from_start ? 0 : 1);
    for (std::size_t i = 0; i < study.traces.size(); ++i) {
      const MeasuredTrace& trace = study.traces[i];
      const double value = value_of(trace.column, at);
      misfit.traces[i].push_back(value);
      if (std::isnan(trace.values[k])) continue;
      residual.push_back((value - trace.values[k]) / trace.deviation);
      Eigen::VectorXd row(parameters);
      for (Eigen::Index j = 0; j < parameters; ++j)
        row(j) = value_of(trace.column, at.sensitivities[static_cast<std::size_t>(j)]) / trace.deviation;
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
      for (Eigen::Index j = 0; j < parameters; ++j)
        row(j) = same->sensitivities[static_cast<std::size_t>(j)].time / study.change_deviation;
    }
    residual.push_back((time - measured.time) / study.change_deviation);
    rows.push_back(row);
  }
  misfit.residual = Eigen::Map<const Eigen::VectorXd>(residual.data(), static_cast<Eigen::Index>(residual.size()));
  misfit.jacobian.resize(misfit.residual.size(), parameters);
  for (std::size_t i = 0; i < rows.size(); ++i)
    misfit.jacobian.row(static_cast<Eigen::Index>(i)) =
        rows[i].allFinite() ? rows[i] : Eigen::VectorXd::Zero(parameters);
  misfit.sound = misfit.residual.allFinite();
  if (!misfit.sound) misfit.error = "the run is not finite";
  return misfit;
}

}  // namespace

Misfit measure_misfit(const FitStudy& study, const Eigen::VectorXd& values, std::size_t& runs) {
  ++runs;
  try {
    Misfit misfit = measure(study, values, !study.differences);
    if (!study.differences || !misfit.sound) return misfit;
    misfit.jacobian.resize(misfit.residual.size(), values.size());
    for (Eigen::Index k = 0; k < values.size(); ++k) {
      const FittedParameter& parameter = study.parameters[static_cast<std::size_t>(k)];
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

}  // namespace viscobar
