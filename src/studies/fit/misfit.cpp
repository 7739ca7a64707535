#include "studies/fit/misfit.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "studies/column_reader.hpp"
#include "studies/run_limits.hpp"

namespace viscobar::fitting {

namespace {

// A number and, behind it, its derivatives by the parameters.
using Traced = Eigen::VectorXd;
double number(const Traced& traced) { return traced(0); }
Traced product(const Traced& a, const Traced& b) {
  Traced both = number(a) * b + number(b) * a;
  both(0) = number(a) * number(b);
  return both;
}

// A contact change, and how far from it samples are beside it, if no other one is nearer.
struct Beside {
  const Event& change;
  double within;
};

// How close a contact change is to t_k, from 0 at the samples beside it to 1.
Traced closeness(const std::vector<double>& t, std::size_t k, const std::vector<Beside>& changes, Eigen::Index size) {
  Traced close = Traced::Zero(size);
  for (const auto& [at, within] : changes) {
    const bool earlier = at.time < t[k];
    const double interval = earlier ? t[k] - t[k > 0 ? k - 1 : 0] : t[std::min(k + 1, t.size() - 1)] - t[k];
    const double side = std::min(interval, within);
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
                     const std::vector<Beside>& changes, Misfit& misfit, std::vector<Traced>& rows) {
  for (std::size_t k = 0; k < t.size(); ++k) {
    const double datum = trace.values[k];
    if (std::isnan(datum)) continue;
    Traced row = model[k];
    if (const Traced close = closeness(t, k, changes, row.size()); number(close) > 0.0) {
      const auto towards = [&](std::size_t other) { return Traced(row + product(close, model[other] - row)); };
      const Traced about[] = {row, towards(k > 0 ? k - 1 : 0), towards(std::min(k + 1, t.size() - 1))};
      const auto [low, high] = std::ranges::minmax_element(about, {}, number);
      const bool met = number(*low) <= datum && datum <= number(*high);
      row = met ? Traced(Traced::Unit(row.size(), 0) * datum) : datum < number(*low) ? *low : *high;
      misfit.forgiven += met;
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
std::vector<Traced> impulses(Where where, std::size_t joint, const std::vector<double>& t,
                             const std::vector<Traced>& reaction, const std::vector<Event>& changes) {
  const Eigen::Index n = reaction.front().size();
  std::vector<Traced> sums = {Traced::Zero(n)};
  std::size_t next = 0;
  for (std::size_t k = 1; k < t.size(); ++k) {
    double share = 0.5;
    Traced length = Traced::Unit(n, 0) * (t[k] - t[k - 1]);
    for (; next < changes.size() && changes[next].time <= t[k]; ++next) {
      const Event& change = changes[next];
      if (change.where != where || (joint > 0 && change.node != joint) || change.time < t[k - 1]) continue;
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

// By the measured changes, how many of their contact are within a deviation of the first of them: the opening of an
// impact, or bounces that come to rest. No run could meet one and miss the other, so that together they tell one time.
std::vector<std::size_t> together(const FitStudy& study) {
  std::vector<std::size_t> counts;
  std::map<std::pair<Where, std::size_t>, std::vector<std::size_t>> groups;
  const auto end = [&](std::vector<std::size_t>& group) {
    for (const std::size_t k : group) counts[k] = group.size();
    group.clear();
  };
  for (std::size_t k = 0; k < study.changes.size(); ++k) {
    const auto [where, node, change] = kind_of(study.changes[k]);
    std::vector<std::size_t>& group = groups[{where, node}];
    counts.push_back(1);
    if (!group.empty() && study.changes[k].time - study.changes[group.front()].time > study.change_deviation)
      end(group);
    group.push_back(k);
  }
  for (auto& [contact, group] : groups) end(group);
  return counts;
}

}  // namespace

Kind kind_of(const Event& event) {
  return {event.where, event.where == Where::span || event.where == Where::joint ? event.node : 0, event.change};
}

Misfit measure(const FitStudy& study, Case run, Compared compared, bool derivatives, std::size_t most_steps,
               const TimeErrors& errors) {
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

  const Setup setup = resolve(run);
  const Eigen::Index parameters = derivatives ? std::ssize(study.parameters) : 0;
  if (derivatives && std::ssize(run.directions) != parameters)
    throw std::invalid_argument(
        "fit: the model has not a direction for each parameter, and no differences are asked for");
  std::vector<std::vector<Traced>> model(study.traces.size());
  std::vector<ColumnReader> readers, of_rates;  // the latter of the stress by E' and eta', a row of parameters each
  const BarSystem system = setup.system();
  // The scene whose material is its derivative.
  const auto rates_of = [&](const Direction& direction) {
    Scene rates = run.scene;
    rates.bar = direction.bar;
    for (std::size_t m = 0; m < rates.chain.size(); ++m)
      rates.chain[m].bar.modulus = direction.members[m].bar.modulus,
      rates.chain[m].bar.viscosity = direction.members[m].bar.viscosity;
    return rates;
  };
  for (const MeasuredTrace& trace : study.traces) {
    TraceColumn column = trace.column;
    if (compared == Compared::integrals && is_velocity(column))
      column = column == TraceColumn::v_left    ? TraceColumn::u_left
               : column == TraceColumn::v_right ? TraceColumn::u_right
                                                : TraceColumn::u_at;
    readers.emplace_back(column, trace.place, system, run.scene);
    for (Eigen::Index j = 0; j < parameters; ++j)
      if (trace.column == TraceColumn::stress_at)
        of_rates.emplace_back(TraceColumn::stress_at, trace.place, system, rates_of(run.directions[j]));
  }
  Observers observers;
  observers.off_the_clock = false;
  if (derivatives) observers.directions = run.directions;
  observers.snapshot = [&, told = std::size_t{0}](const Snapshot& at) mutable {
    for (; told < study.times.size() && study.times[told] == at.time; ++told)
      for (std::size_t i = 0, stress = 0; i < model.size(); ++i) {
        model[i].emplace_back(1 + parameters);
        model[i].back()(0) = readers[i](at);
        for (Eigen::Index j = 0; j < parameters; ++j) {
          double& rate = model[i].back()(1 + j) = readers[i](at.sensitivities[j]);
          if (study.traces[i].column == TraceColumn::stress_at) rate += of_rates[stress++](at);
        }
      }
  };
  observers.event = [&](const Event& event) { misfit.changes.push_back(event); };
  const Statistics done = simulate_within({.stop = study.stop, .steps = most_steps}, setup, system, times, observers);
  misfit.steps = done.steps;
  if (done.sensitivity) misfit.lost = done.sensitivity->lost;

  std::vector<Beside> changes;
  std::map<Kind, std::size_t> seen;
  for (const Event& change : misfit.changes) {
    const auto own = errors.find(kind_of(change));
    const std::size_t k = seen[kind_of(change)]++;
    changes.push_back({change, compared != Compared::exact                     ? INFINITY
                               : own != errors.end() && k < own->second.size() ? own->second[k]
                                                                               : 0.0});
  }
  std::vector<Traced> rows;
  for (std::size_t i = 0; i < model.size(); ++i) {
    const MeasuredTrace& trace = study.traces[i];
    const bool smooth = !is_velocity(trace.column) && !is_reaction(trace.column);
    misfit.traces.emplace_back();
    std::ranges::transform(model[i], std::back_inserter(misfit.traces.back()), number);
    if (smooth || compared != Compared::integrals)
      compare_samples(trace, study.times, model[i], smooth ? std::vector<Beside>() : changes, misfit, rows);
    else if (is_velocity(trace.column))
      compare_integrals(trace, study.times, model[i], rows);
    else
      compare_integrals(trace, study.times,
                        impulses(trace.column == TraceColumn::reaction_left    ? Where::left
                                 : trace.column == TraceColumn::reaction_right ? Where::right
                                                                               : Where::joint,
                                 static_cast<std::size_t>(trace.place), study.times, model[i], misfit.changes),
                        rows);
  }
  seen.clear();
  const std::vector<std::size_t> counts = together(study);
  double alone = 0.0;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    const Event& measured = study.changes[k];
    const auto count = static_cast<double>(counts[k]);
    alone += 1.0 / count;
    std::size_t skip = seen[kind_of(measured)]++;
    const auto same = std::ranges::find_if(
        misfit.changes, [&](const Event& event) { return kind_of(event) == kind_of(measured) && skip-- == 0; });
    Traced row = Traced::Zero(1 + parameters);
    row(0) = (same == misfit.changes.end() ? 2.0 * end : same->time) - measured.time;
    if (same != misfit.changes.end())
      for (Eigen::Index j = 0; j < parameters; ++j) row(1 + j) = same->sensitivities[j].time;
    rows.push_back(row / (std::sqrt(count) * study.change_deviation));
  }
  misfit.repeated = std::ssize(counts) - std::lround(alone);
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

}  // namespace viscobar::fitting
