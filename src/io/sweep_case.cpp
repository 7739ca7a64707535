#include <algorithm>
#include <chrono>
#include <limits>
#include <optional>
#include <string_view>

#include "io/printable_text.hpp"
#include "io/summary.hpp"
#include "io/text_check.hpp"
#include "viscobar/analysis/alarm.hpp"
#include "viscobar/analysis/impulse.hpp"
#include "viscobar/io/record_run.hpp"
#include "viscobar/io/sweep_file.hpp"

namespace viscobar {

namespace {

/// Displacement of an end over a run.
struct EndRange {
  double last = 0.0, smallest = std::numeric_limits<double>::infinity(), largest = -smallest;
  bool seen = false;
  void add(double u) {
    last = u;
    smallest = std::min(smallest, u);
    largest = std::max(largest, u);
    seen = true;
  }
};

void tell(SweepRow& row, const EndRange& end, Quantity final, Quantity smallest, Quantity largest) {
  if (!end.seen) return;
  row[final] = end.last;
  row[smallest] = end.smallest;
  row[largest] = end.largest;
}

void tell(SweepRow& row, const Statistics& done) {
  row[Quantity::unknowns] = static_cast<double>(done.unknowns);
  row[Quantity::steps] = static_cast<double>(done.steps);
  row[Quantity::rhs_evaluations] = static_cast<double>(done.rhs_evaluations);
  row[Quantity::linear_solves] = static_cast<double>(done.linear_solves);
  row[Quantity::reached_time] = done.reached_time;
  row[Quantity::max_penetration] = done.max_penetration;
  row.integration_seconds = done.integration_seconds;
  if (!done.energy) return;
  row[Quantity::energy_initial] = done.energy->initial;
  row[Quantity::energy_final] = done.energy->final;
  row[Quantity::energy_dissipated] = done.energy->dissipated;
  row[Quantity::energy_work] = done.energy->work;
  row[Quantity::energy_balance_error] = done.energy->balance_error();
}

void tell(SweepRow& row, const ContactAccount& contact, double reached, double impulse, Quantity first) {
  const auto at = [&](std::size_t k) -> double& { return row.values[static_cast<std::size_t>(first) + k]; };
  at(0) = static_cast<double>(contact.closings());
  at(1) = contact.duration(reached);
  at(2) = impulse;
  at(3) = contact.max_reaction();
}

void simulate_into(SweepRow& row, const Case& run, const std::function<bool()>& interrupted) {
  const BarSystem system = make_system(run);
  ContactSummary contact(run.scene);
  EndRange left, right;
  std::optional<EndImpulse> impulse;
  if (contact.left || contact.right) impulse.emplace(system);
  bool exact = false;  // whether the method knows impulses without output times
  std::size_t steps = 0, events = 0;
  double reached = 0.0;
  Observers observers;
  observers.energy = true;
  observers.snapshot = [&](const Snapshot& snapshot) {
    left.add(snapshot.u.front());
    right.add(snapshot.u.back());
    contact.add(snapshot);
    if (impulse) impulse->add(snapshot);
  };
  observers.event = [&](const Event& event) {
    ++events;
    contact.add(event);
  };
  observers.progress = [&](double time) {
    reached = time;
    ++steps;
    if (interrupted && interrupted()) throw Interrupted();
  };
  try {
    const Statistics done = simulate(run, system, observers);
    tell(row, done);
    contact.know(done);
    exact = done.left.has_value() || done.right.has_value();
    row.completed = true;
    for (const Alarm& alarm : alarms(run, system, done)) {
      if (!alarm.ruinous) continue;
      row.completed = false;
      row.error += (row.error.empty() ? "" : "; ") + alarm.what;
    }
  } catch (const Interrupted&) {
    throw;
  } catch (const IntegrationError& error) {
    tell(row, error.statistics);
    row.error = error.what();
  } catch (const std::exception& error) {
    row[Quantity::steps] = static_cast<double>(steps);
    row[Quantity::reached_time] = reached;
    row.error = error.what();
  }
  row[Quantity::events] = static_cast<double>(events);
  tell(row, left, Quantity::u_left_final, Quantity::u_left_min, Quantity::u_left_max);
  tell(row, right, Quantity::u_right_final, Quantity::u_right_min, Quantity::u_right_max);
  const double until = row[Quantity::reached_time];
  if (contact.left)
    tell(row, *contact.left, until, exact ? contact.left->impulse() : impulse->left(), Quantity::closings_left);
  if (contact.right)
    tell(row, *contact.right, until, exact ? contact.right->impulse() : impulse->right(), Quantity::closings_right);
  if (contact.span) row[Quantity::closings_span] = static_cast<double>(contact.span->closings);
}

std::string fitting(std::string text) {
  constexpr std::string_view cut_off = "...";
  if (text.size() <= longest_error) return text;
  text.resize(longest_error - cut_off.size());
  while (!is_utf8(text)) text.pop_back();
  return text += cut_off;
}

}  // namespace

SweepRow run_case(const std::string& scene_text, const SweepCase& one, const std::function<bool()>& interrupted) {
  const auto started = std::chrono::steady_clock::now();
  SweepRow row;
  row.index = one.index;
  row[Quantity::steps] = row[Quantity::events] = row[Quantity::reached_time] = 0.0;
  try {
    simulate_into(row, parse_scene(scene_text, "scene", one.overrides).run, interrupted);
  } catch (const SceneError& error) {
    for (const Diagnostic& found : error.diagnostics)
      row.error += (row.error.empty() ? "" : "; ") + found.key + ": " + found.message;
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    row.error = error.what();
  }
  row.error = fitting(one_line(row.error));
  row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return row;
}

}  // namespace viscobar
