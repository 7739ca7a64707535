#include "viscobar/studies/judge/judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "studies/accuracy/runs.hpp"
#include "studies/column_reader.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"
#include "viscobar/studies/compare/difference.hpp"
#include "viscobar/studies/fit/fit.hpp"

namespace viscobar {

namespace {

constexpr double smallest_request = 1e-10;  // of the largest value
constexpr double better = 10.0;             // from one of our solutions to the next, and than theirs

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

using Column = std::pair<TraceColumn, double>;

Column column_of(const std::string& text, double length) {
  const auto column = trace_column(text);
  if (!column)
    throw std::invalid_argument(fmt::format(
        "{}: no column of ends.csv, nor of gauges.csv, u, v, strain and stress at a place, such as u@0.25", text));
  if (!(column->second >= 0.0 && column->second <= length))
    throw std::invalid_argument(fmt::format("{}: is not on the bar, whose length is {}", text, length));
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
  for (const auto& [column, place] : columns) readers.emplace_back(column, place, system.mesh(), system.bar());
  Motion motion;
  motion.columns.resize(readers.size());
  Observers observers;
  observers.snapshot = [&](const Snapshot& at) {
    for (std::size_t k = 0; k < readers.size(); ++k) motion.columns[k].push_back(readers[k](at));
  };
  observers.event = [&](const Event& event) { motion.events.push_back(event); };
  observers.progress = [&](double) { return stop && stop() ? RunControl::stop : RunControl::go_on; };
  if (!simulate(setup, system, times, observers).completed) throw accuracy::Stopped();
  return motion;
}

// Times in contact at an end, flights shorter than `merge` left out.
std::vector<ContactPeriod> periods_of(const Motion& motion, Where where, double end, double merge) {
  Recording recording;
  recording.times = {0.0, end};
  recording.events = motion.events;
  std::vector<ContactPeriod> periods = contact_periods(recording, merge);
  std::erase_if(periods, [where](const ContactPeriod& period) { return period.where != where; });
  return periods;
}

// The same of samples: where there is a reaction, or else where the end is at its obstacle, to `touch`.
std::vector<ContactPeriod> periods_of(const TheirSolution& theirs, const Scene& scene, Where where, double touch) {
  const bool left = where == Where::left;
  const Obstacle& obstacle = std::get<Obstacle>(left ? scene.left : scene.right);
  const EndInput& input = left ? scene.left_input : scene.right_input;
  const auto* reaction = theirs.column(left ? "reaction_left" : "reaction_right");
  const auto* u = theirs.column(left ? "u_left" : "u_right");
  std::vector<ContactPeriod> periods;
  if (!reaction && (!u || input.motion)) return periods;
  double largest = 0.0;
  if (reaction)
    for (const double value : reaction->values)
      if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  bool closed = false;
  for (std::size_t k = 0; k < theirs.times.size(); ++k) {
    const double value = reaction ? reaction->values[k] : u->values[k];
    if (!std::isfinite(value)) continue;
    const bool now = reaction ? std::abs(value) > 1e-9 * largest : obstacle.depth(value) >= -touch;
    if (now && !closed) periods.push_back({where, 0, theirs.times[k], theirs.times[k]});
    if (now) periods.back().end = theirs.times[k];
    closed = now;
  }
  return periods;
}

double spacing_of(const std::vector<double>& times) {
  return times.size() < 2 ? 0.0 : (times.back() - times.front()) / static_cast<double>(times.size() - 1);
}

void judge_contacts(JudgedSolution& judged, const TheirSolution& theirs, const Motion& ours, const Case& run,
                    double touch) {
  const double sample = spacing_of(theirs.times);
  for (const Where where : {Where::left, Where::right}) {
    if (!is_obstacle(where == Where::left ? run.scene.left : run.scene.right)) continue;
    const bool left = where == Where::left;
    const EndInput& input = left ? run.scene.left_input : run.scene.right_input;
    if (!theirs.column(left ? "reaction_left" : "reaction_right") &&
        (!theirs.column(left ? "u_left" : "u_right") || input.motion))
      continue;
    const std::vector<ContactPeriod> own = periods_of(ours, where, theirs.times.back(), 2.0 * sample);
    const std::vector<ContactPeriod> other = periods_of(theirs, run.scene, where, touch);
    std::vector<bool> met(other.size(), false);
    for (const ContactPeriod& period : own) {
      JudgedContact contact{where, period.begin, period.end, {}, {}};
      for (std::size_t k = 0; k < other.size(); ++k) {
        if (other[k].end < period.begin - sample || other[k].begin > period.end + sample) continue;
        met[k] = true;
        contact.their_begin = std::min(contact.their_begin.value_or(other[k].begin), other[k].begin);
        contact.their_end = std::max(contact.their_end.value_or(other[k].end), other[k].end);
      }
      if (!contact.their_begin && period.end - period.begin > sample) ++judged.missed;
      judged.contacts.push_back(contact);
    }
    for (std::size_t k = 0; k < other.size(); ++k) {
      if (met[k]) continue;
      ++judged.made_up;
      judged.contacts.push_back({where, {}, {}, other[k].begin, other[k].end});
    }
  }
  std::ranges::stable_sort(judged.contacts, {},
                           [](const JudgedContact& one) { return one.begin.value_or(*one.their_begin); });
}

// Kinetic and elastic energy of the P1 function through some places.
double energy_at(const Bar& bar, const std::vector<double>& x, const auto& u, const auto& v) {
  double energy = 0.0;
  for (std::size_t k = 0; k + 1 < x.size(); ++k) {
    const double h = x[k + 1] - x[k], slope = (u(k + 1) - u(k)) / h;
    energy += 0.5 * bar.density * h / 3.0 * (v(k) * v(k) + v(k) * v(k + 1) + v(k + 1) * v(k + 1));
    energy += 0.5 * bar.modulus * h * slope * slope;
  }
  return energy;
}

void judge_energy(JudgedSolution& judged, const TheirSolution& theirs, const Bar& bar) {
  struct Place {
    double x;
    const JudgedColumn *u, *v;
  };
  std::vector<Place> places;
  const auto find = [&](const std::string& name) -> const JudgedColumn* {
    const auto found = std::ranges::find(judged.columns, name, &JudgedColumn::name);
    return found == judged.columns.end() ? nullptr : &*found;
  };
  for (const JudgedColumn& column : judged.columns) {
    const auto [of, place] = column_of(column.name, bar.length);
    if (!column.name.starts_with("u")) continue;
    const JudgedColumn* v = find("v" + column.name.substr(1));
    const double x = of == TraceColumn::u_right ? bar.length : place;
    if (v && std::ranges::find(places, x, &Place::x) == places.end()) places.push_back({x, &column, v});
  }
  if (places.size() < 3) return;
  std::ranges::sort(places, {}, &Place::x);
  std::vector<double> x;
  for (const Place& place : places) x.push_back(place.x);
  double largest = 0.0;
  judged.energy_drift = 0.0;
  for (std::size_t k = 0; k < theirs.times.size(); ++k) {
    const auto value = [&](auto of, auto whose) {
      return [&, of, whose, k](std::size_t i) { return ((*(places[i].*of)).*whose)[k]; };
    };
    const double ours = energy_at(bar, x, value(&Place::u, &JudgedColumn::ours), value(&Place::v, &JudgedColumn::ours));
    const double other =
        energy_at(bar, x, value(&Place::u, &JudgedColumn::theirs), value(&Place::v, &JudgedColumn::theirs));
    largest = std::max(largest, ours);
    if (const double drift = other - ours; std::isfinite(drift) && std::abs(drift) > std::abs(*judged.energy_drift))
      judged.energy_drift = drift;
  }
  if (largest > 0.0) judged.energy_share = *judged.energy_drift / largest;
}

void check(const JudgeStudy& study) {
  if (study.solutions.empty()) throw std::invalid_argument("there is no solution to judge");
  for (const TheirSolution& theirs : study.solutions) {
    const auto refuse = [&](const std::string& why) { throw std::invalid_argument(theirs.label + ": " + why); };
    if (theirs.columns.empty()) refuse("has no column but the time");
    if (theirs.times.size() < 2) refuse("has fewer than two times");
    if (!std::ranges::is_sorted(theirs.times, std::less_equal<>())) refuse("has a time twice");
    const double rounding = 1e-9 * study.scene.end;
    if (!(theirs.times.front() >= -rounding && theirs.times.back() <= study.scene.end + rounding))
      refuse(fmt::format("has times from {} to {}, and the scene ends at {}", theirs.times.front(), theirs.times.back(),
                         study.scene.end));
    if (theirs.step && !(*theirs.step > 0.0)) refuse("has a step that is not positive");
    for (const auto& column : theirs.columns)
      if (column.values.size() != theirs.times.size()) refuse(column.name + " has not a value for each time");
  }
}

// Powers of the step, of solutions with steps, from each to the next finer one.
void find_orders(const JudgeStudy& study, JudgeResult& judgement) {
  std::vector<std::size_t> order;
  for (std::size_t s = 0; s < study.solutions.size(); ++s)
    if (study.solutions[s].step) order.push_back(s);
  std::ranges::stable_sort(order, std::greater<>(), [&](std::size_t s) { return *study.solutions[s].step; });
  for (std::size_t k = 1; k < order.size(); ++k) {
    const double ratio = *study.solutions[order[k - 1]].step / *study.solutions[order[k]].step;
    if (!(ratio > 1.0)) continue;
    for (JudgedColumn& column : judgement.solutions[order[k]].columns) {
      const auto& before = judgement.solutions[order[k - 1]].columns;
      const auto coarser = std::ranges::find(before, column.name, &JudgedColumn::name);
      if (coarser == before.end() || !coarser->told_apart() || !column.told_apart() || !(column.largest > 0.0))
        continue;
      column.order = std::log(coarser->largest / column.largest) / std::log(ratio);
    }
  }
}

}  // namespace

const TheirSolution::Column* TheirSolution::column(const std::string& name) const {
  const auto found = std::ranges::find(columns, name, &Column::name);
  return found == columns.end() ? nullptr : &*found;
}

JudgeResult judge(const JudgeStudy& study) {
  check(study);
  const auto started = std::chrono::steady_clock::now();
  const double length = study.scene.scene.bar.length;
  std::vector<Column> columns;  // of all solutions, one behind the other
  std::vector<double> times = {0.0};
  for (const TheirSolution& theirs : study.solutions) {
    for (const auto& column : theirs.columns) columns.push_back(column_of(column.name, length));
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
    return (study.stop && study.stop()) || (judgement.runs > 0 && seconds_since(started) > study.most_seconds);
  };
  std::optional<Motion> coarser;
  std::vector<double> errors_before(columns.size(), std::numeric_limits<double>::infinity());
  for (double error = study.request.error;; error /= better) {
    own.request.error = error;
    own.request.relative = true;
    own.most_seconds = study.most_seconds - seconds_since(started);
    if (judgement.runs > 0 && (own.most_seconds <= 0.0 || error < smallest_request)) {
      judgement.reason = error < smallest_request ? "a smaller error is rounding" : "the time is up";
      break;
    }
    AccuracyResult solved;
    Motion motion;
    try {
      solved = solve(own);
      motion = motion_of(solved.run, times, columns, own.stop);
    } catch (const accuracy::Stopped&) {
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
    std::size_t at = 0;
    for (std::size_t s = 0; s < study.solutions.size(); ++s) {
      const TheirSolution& theirs = study.solutions[s];
      JudgedSolution& judged = judgement.solutions.emplace_back();
      for (const auto& column : theirs.columns) {
        JudgedColumn& one = judged.columns.emplace_back();
        one.name = column.name;
        one.theirs = column.values;
        double sum = 0.0, own_error = 0.0;
        std::size_t count = 0;
        for (std::size_t k = 0; k < theirs.times.size(); ++k) {
          const double ours = motion.columns[at][rows[s][k]], difference = column.values[k] - ours;
          one.ours.push_back(ours);
          if (!std::isfinite(difference)) continue;
          one.size = std::max(one.size, std::abs(ours));
          if (coarser) own_error = std::max(own_error, std::abs(coarser->columns[at][rows[s][k]] - ours));
          sum += difference * difference;
          ++count;
          if (std::abs(difference) > one.largest) one.largest = std::abs(difference), one.at = theirs.times[k];
        }
        if (count == 0) throw std::invalid_argument(theirs.label + ": " + column.name + " has no value");
        one.root_mean_square = std::sqrt(sum / static_cast<double>(count));
        // Exact solutions of an elastic bar are one: their difference shows no error.
        const double share = column.name.starts_with("u") ? 1.0 : one.size / solved.estimate.largest;
        if (solved.estimate.largest > 0.0) own_error = std::max(own_error, share * solved.estimate.total);
        if (coarser || column.name.starts_with("u")) one.own_error = own_error;
        // The force on a viscous bar at its touch has no limit. An error of ours that does not fall is not waited for.
        settled = settled && (own_error * better <= one.largest || 2.0 * own_error > errors_before[at]);
        if (coarser) errors_before[at] = own_error;
        ++at;
      }
      judge_contacts(judged, theirs, motion, solved.run,
                     std::max(solved.estimate.total, 1e-9 * solved.estimate.largest));
      judge_energy(judged, theirs, study.scene.scene.bar);
    }
    if (settled) {
      judgement.reason = "our own error is a tenth of every difference, or does not fall";
      break;
    }
    coarser = std::move(motion);
  }
  find_orders(study, judgement);
  return judgement;
}

}  // namespace viscobar
