#include "viscobar/studies/judge/judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "run/stopwatch.hpp"
#include "studies/column_reader.hpp"
#include "studies/judge/contacts.hpp"
#include "studies/run_limits.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"
#include "viscobar/studies/fit/fit.hpp"

namespace viscobar {

namespace {

constexpr double smallest_request = 1e-10;  // of the largest value
constexpr double better = 10.0;             // from one of our solutions to the next, and than theirs
constexpr double file_digits = 1e-6;        // of the largest value, that a file may not have
constexpr std::size_t finer_nodes = 4;      // times as many from one run to the next, of an exact solution
constexpr std::size_t runs_of_exact = 3;    // at most

using Column = std::pair<TraceColumn, double>;

Column column_of(const std::string& text, const Scene& scene) {
  const auto column = trace_column(text);
  if (!column)
    throw std::invalid_argument(fmt::format(
        "{}: no column of ends.csv, nor of gauges.csv, u, v, strain and stress at a place, such as u@0.25, nor of "
        "joints.csv, such as force:1",
        text));
  if (const auto why = place_refusal(column, scene)) throw std::invalid_argument(fmt::format("{}: {}", text, *why));
  return *column;
}

// The bar's motion at given times: a row of all columns for each.
struct Motion {
  std::vector<std::vector<double>> columns;
  std::vector<Event> events;
};

Motion motion_of(const Case& run, std::span<const double> times, std::span<const Column> columns,
                 const std::function<bool()>& stop) {
  const Setup setup = resolve(run);
  const BarSystem system = setup.system();
  std::vector<ColumnReader> readers;
  for (const auto& [column, place] : columns) readers.emplace_back(column, place, system, run.scene);
  Motion motion;
  motion.columns.resize(readers.size());
  Observers observers;
  observers.snapshot = [&](const Snapshot& at) {
    for (std::size_t k = 0; k < readers.size(); ++k) motion.columns[k].push_back(readers[k](at));
  };
  observers.event = [&](const Event& event) { motion.events.push_back(event); };
  simulate_within({.stop = stop}, setup, system, times, observers);
  return motion;
}

std::vector<double> at_times(const std::vector<double>& values, const std::vector<std::size_t>& rows) {
  std::vector<double> some;
  for (const std::size_t row : rows) some.push_back(values[row]);
  return some;
}

// How large a difference is over some times, those left out at which it is not finite.
struct Distance {
  double largest = 0.0, at = 0.0, root_mean_square = 0.0, mean = 0.0;
  std::size_t count = 0;
};

Distance distance_over(const std::vector<double>& times, auto&& difference) {
  Distance all;
  double squares = 0.0, integral = 0.0, first = 0.0, last = 0.0, before = 0.0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double size = std::abs(difference(k));
    if (!std::isfinite(size)) continue;
    if (all.count++ == 0)
      first = times[k];
    else
      integral += 0.5 * (before + size) * (times[k] - last);
    squares += size * size;
    if (size > all.largest) all.largest = size, all.at = times[k];
    last = times[k], before = size;
  }
  if (all.count == 0) return all;
  all.root_mean_square = std::sqrt(squares / static_cast<double>(all.count));
  all.mean = last > first ? integral / (last - first) : before;
  return all;
}

void judge_energy(JudgedSolution& judged, const TheirSolution& theirs, const Scene& scene) {
  struct Station {
    double x;
    const JudgedColumn *u, *v;
  };
  if (!scene.chain.empty()) return;
  const Bar& bar = scene.bar;
  std::vector<Station> places;
  for (const JudgedColumn& column : judged.columns) {
    const auto [of, place] = column_of(column.name, scene);
    const double x = of == TraceColumn::u_right ? bar.length : place;
    const auto v = std::ranges::find(judged.columns, "v" + column.name.substr(1), &JudgedColumn::name);
    if (!column.jumps() && v != judged.columns.end() && std::ranges::find(places, x, &Station::x) == places.end())
      places.push_back({x, &column, &*v});
  }
  if (places.size() < 3) return;
  std::ranges::sort(places, {}, &Station::x);
  // Kinetic and elastic energy of the P1 function through the places, and of what is on the ends among them.
  const auto energy_at = [&](std::size_t k, auto whose) {
    const auto u = [&](const Station& place) { return (place.u->*whose)[k]; };
    const auto v = [&](const Station& place) { return (place.v->*whose)[k]; };
    double energy = 0.0;
    for (std::size_t i = 1; i < places.size(); ++i) {
      const Station &one = places[i - 1], &other = places[i];
      const double h = other.x - one.x;
      energy += bar.density * h / 6.0 * (v(one) * v(one) + v(one) * v(other) + v(other) * v(other)) +
                0.5 * bar.modulus / h * (u(other) - u(one)) * (u(other) - u(one));
    }
    for (const Station& place : places)
      for (const auto& [x, input] : {std::pair(0.0, &scene.left_input), std::pair(bar.length, &scene.right_input)})
        if (place.x == x) energy += 0.5 * (input->mass * v(place) * v(place) + input->stiffness * u(place) * u(place));
    return energy;
  };
  double largest = 0.0;
  judged.energy_drift = 0.0;
  for (std::size_t k = 0; k < theirs.times.size(); ++k) {
    const double ours = energy_at(k, &JudgedColumn::ours), drift = energy_at(k, &JudgedColumn::theirs) - ours;
    largest = std::max(largest, ours);
    if (std::isfinite(drift) && std::abs(drift) > std::abs(*judged.energy_drift)) judged.energy_drift = drift;
  }
  if (largest > 0.0) judged.energy_share = *judged.energy_drift / largest;
}

void check(const JudgeStudy& study) {
  if (study.solutions.empty()) throw std::invalid_argument("there is no solution to judge");
  for (const TheirSolution& theirs : study.solutions) {
    const auto refuse = [&](const std::string& why) { throw std::invalid_argument(theirs.label + ": " + why); };
    const Scene& scene = study.scene.scene;
    const double rounding = 1e-9 * study.scene.end;
    const auto check_times = [&](double first, double last) {
      if (!(first >= -rounding && last <= study.scene.end + rounding))
        refuse(fmt::format("has times from {} to {}, and the scene ends at {}", first, last, study.scene.end));
    };
    if (theirs.columns.empty() && !theirs.changes) refuse("has no column but the time");
    if (theirs.times.size() < 2 && !theirs.columns.empty()) refuse("has fewer than two times");
    if (!std::ranges::is_sorted(theirs.times, std::less_equal<>())) refuse("has a time twice");
    if (!theirs.times.empty()) check_times(theirs.times.front(), theirs.times.back());
    if (theirs.changes && !theirs.changes->empty())
      check_times(theirs.changes->front().time, theirs.changes->back().time);
    constexpr const char* places[] = {"at the left end", "at the right end", "along the span", "at a joint"};
    const bool obstacles[] = {is_obstacle(scene.left), is_obstacle(scene.right), scene.span.has_value(),
                              has_contact_joint(scene)};
    for (const Event& event : theirs.changes.value_or(std::vector<Event>()))
      if (const auto at = static_cast<std::size_t>(event.where); !obstacles[at])
        refuse(fmt::format("has contact changes {}, where the scene has no obstacle", places[at]));
    if (theirs.step && !(*theirs.step > 0.0)) refuse("has a step that is not positive");
    for (const auto& column : theirs.columns)
      if (column.values.size() != theirs.times.size()) refuse(column.name + " has not a value for each time");
  }
}

// Powers of the step, of solutions of a scheme with steps, from each to the next finer one.
void find_orders(const JudgeStudy& study, JudgeResult& judgement) {
  std::vector<std::size_t> order;
  for (std::size_t s = 0; s < study.solutions.size(); ++s)
    if (study.solutions[s].step) order.push_back(s);
  std::ranges::stable_sort(
      order, {}, [&](std::size_t s) { return std::pair(study.solutions[s].scheme, -*study.solutions[s].step); });
  for (std::size_t k = 1; k < order.size(); ++k) {
    const TheirSolution &coarse = study.solutions[order[k - 1]], &fine = study.solutions[order[k]];
    const double ratio = *coarse.step / *fine.step;
    if (coarse.scheme != fine.scheme || !(ratio > 1.0)) continue;
    for (JudgedColumn& column : judgement.solutions[order[k]].columns) {
      const auto& before = judgement.solutions[order[k - 1]].columns;
      const auto coarser = std::ranges::find(before, column.name, &JudgedColumn::name);
      if (coarser == before.end() || !coarser->told_apart() || !column.told_apart() || !(column.distance() > 0.0))
        continue;
      column.order = std::log(coarser->distance() / column.distance()) / std::log(ratio);
    }
  }
}

}  // namespace

const TheirSolution::Column* TheirSolution::column(const std::string& name) const {
  const auto found = std::ranges::find(columns, name, &Column::name);
  return found == columns.end() ? nullptr : &*found;
}

std::string_view name(ContactVerdict verdict) {
  constexpr std::string_view names[] = {"found", "missed", "made up", "cannot be told"};
  return names[static_cast<std::size_t>(verdict)];
}

std::size_t JudgedSolution::count(ContactVerdict verdict) const {
  return static_cast<std::size_t>(std::ranges::count(contacts, verdict, &JudgedContact::verdict));
}

JudgeResult judge(const JudgeStudy& study) {
  check(study);
  const Scene& scene = study.scene.scene;
  const WallClock clock;
  // Places of all solutions, one behind the other, behind the ends and joints, which contacts need.
  std::vector<Column> columns = {{TraceColumn::u_left, 0.0}, {TraceColumn::u_right, 0.0}};
  for (std::size_t k = 0; k + 1 < scene.chain.size(); ++k)
    if (scene.chain[k].joint.kind == JointKind::contact)
      for (const TraceColumn side : {TraceColumn::u_left_of, TraceColumn::u_right_of})
        columns.emplace_back(side, static_cast<double>(k + 1));
  const std::size_t of_contacts = columns.size();
  std::vector<double> times = {0.0};
  for (const TheirSolution& theirs : study.solutions) {
    if (theirs.times.empty()) times.push_back(study.scene.end);
    for (const auto& column : theirs.columns) columns.push_back(column_of(column.name, scene));
    for (const double t : theirs.times) times.push_back(std::clamp(t, 0.0, study.scene.end));
  }
  std::ranges::sort(times);
  times.erase(std::ranges::unique(times).begin(), times.end());
  std::vector<std::vector<std::size_t>> rows;  // of each solution's times
  for (const TheirSolution& theirs : study.solutions) {
    std::vector<std::size_t>& of = rows.emplace_back();
    for (const double t : theirs.times)
      of.push_back(static_cast<std::size_t>(std::ranges::lower_bound(times, std::clamp(t, 0.0, study.scene.end)) -
                                            times.begin()));
  }

  JudgeResult judgement;
  AccuracyStudy own;
  own.scene = study.scene;
  own.request = study.request;
  own.threads = study.threads;
  own.stop = [&] {
    return (study.stop && study.stop()) || (judgement.runs > 0 && clock.seconds() > study.most_seconds);
  };
  std::optional<Motion> coarser;
  std::vector<double> errors_before(columns.size(), std::numeric_limits<double>::infinity());
  for (double error = study.request.error;; error /= better) {
    own.request.error = error;
    own.request.relative = true;
    own.most_seconds = study.most_seconds - clock.seconds();
    if (judgement.runs > 0 && (own.most_seconds <= 0.0 || error < smallest_request)) {
      judgement.reason = error < smallest_request ? "a smaller error is rounding" : "the time is up";
      break;
    }
    AccuracyResult solved;
    Motion motion;
    try {
      solved = solve(own);
      // Exact, but gauges between the nodes read it across its kinks: other nodes show what they are off by.
      if (solved.run.method == MethodName::characteristics && judgement.runs > 0)
        solved.run.elements = finer_nodes * judgement.run.elements;
      motion = motion_of(solved.run, times, columns, own.stop);
    } catch (const StudyStopped&) {
      if (judgement.runs == 0 || (study.stop && study.stop())) throw;
      judgement.reason = "the time is up";
      break;
    } catch (const IntegrationError& failed) {
      if (judgement.runs == 0) throw;
      judgement.reason = failed.what();
      break;
    }
    // One that keeps nothing more is no better than the one before.
    if (judgement.runs > 0 && !solved.estimate.kept) {
      judgement.reason = solved.estimate.doubt.empty() ? "the error cannot be kept" : solved.estimate.doubt;
      break;
    }
    // Two requests that the same settings keep show nothing of each other's error.
    const Case &now = solved.run, &last = judgement.run;
    const bool finer = now.elements >= last.elements * 5 / 4 || (is_scheme(now.method) && now.step < last.step);
    if (judgement.runs > 0 && now.method != MethodName::characteristics && !finer) continue;
    ++judgement.runs;
    judgement.run = solved.run;
    judgement.estimate = solved.estimate;
    judgement.solutions.clear();
    bool settled = coarser.has_value();
    std::size_t at = of_contacts;
    for (std::size_t s = 0; s < study.solutions.size(); ++s) {
      const TheirSolution& theirs = study.solutions[s];
      JudgedSolution& judged = judgement.solutions.emplace_back();
      for (const auto& column : theirs.columns) {
        JudgedColumn& one = judged.columns.emplace_back();
        one.name = column.name;
        one.theirs = column.values;
        one.ours = at_times(motion.columns[at], rows[s]);
        const bool fixed = (one.name.ends_with("_left") && is_fixed(scene.left)) ||
                           (one.name.ends_with("_right") && is_fixed(scene.right));
        const bool force = one.name.starts_with("reaction");
        // The force of a fixed end that stops a viscous bar at the start has no limit there.
        const auto difference = [&](std::size_t k) {
          const bool counts = !(fixed && force) || theirs.times[k] > 0.0;
          return counts ? one.theirs[k] - one.ours[k] : std::numeric_limits<double>::quiet_NaN();
        };
        const Distance distance = distance_over(theirs.times, difference);
        if (distance.count == 0) throw std::invalid_argument(theirs.label + ": " + column.name + " has no value");
        one.largest = distance.largest, one.at = distance.at;
        one.root_mean_square = distance.root_mean_square, one.mean = distance.mean;
        Distance own_distance;
        if (coarser)
          own_distance = distance_over(theirs.times, [&](std::size_t k) {
            return std::isfinite(difference(k)) ? coarser->columns[at][rows[s][k]] - one.ours[k] : difference(k);
          });
        for (std::size_t k = 0; k < theirs.times.size(); ++k)
          if (std::isfinite(difference(k))) one.size = std::max(one.size, std::abs(one.ours[k]));
        // Exact solutions of an elastic bar are one: their difference shows no error.
        const double share = one.jumps() ? one.size / solved.estimate.largest : 1.0;
        const double least = solved.estimate.largest > 0.0 ? share * solved.estimate.total : 0.0;
        if (coarser || !one.jumps()) {
          one.own_error = std::max(own_distance.largest, least);
          one.own_mean = std::max(own_distance.mean, least);
        }
        // The force on a viscous bar at its touch has no limit. An error of ours that does not fall is not waited for,
        // nor one of what is given: the motion of a fixed end.
        const double own_now = one.own_distance().value_or(0.0);
        settled =
            settled && ((fixed && !force) || own_now * better <= one.distance() || 2.0 * own_now > errors_before[at]);
        if (coarser) errors_before[at] = own_now;
        ++at;
      }
      OwnContacts ours{motion.events, {}, {}, std::max(solved.estimate.total, file_digits * solved.estimate.largest)};
      for (std::size_t k = 0; k < of_contacts; ++k) ours.ends.push_back(at_times(motion.columns[k], rows[s]));
      if (coarser) ours.coarser = coarser->events;
      judge_contacts(judged, theirs, solved.run, ours);
      judge_energy(judged, theirs, scene);
    }
    if (settled) {
      judgement.reason = "its error is a tenth of every difference, or falls no more";
      break;
    }
    if (now.method == MethodName::characteristics && judgement.runs == runs_of_exact) {
      judgement.reason = "it is exact but at kinks that a gauge sees between its nodes";
      break;
    }
    coarser = std::move(motion);
  }
  find_orders(study, judgement);
  return judgement;
}

}  // namespace viscobar
