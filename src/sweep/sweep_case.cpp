#include <algorithm>
#include <chrono>
#include <limits>
#include <string_view>

#include "case/alarm.hpp"
#include "input/described_scene.hpp"
#include "input/toml_text.hpp"
#include "studies/accuracy/plan.hpp"
#include "text/printable_text.hpp"
#include "viscobar/record/record_run.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

namespace {

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

void tell(SweepRow& row, const EndAccount& end, bool obstacle, double reached, Quantity final, Quantity closings) {
  const auto at = [&row](Quantity first, std::size_t k) -> double& {
    return row.values[static_cast<std::size_t>(first) + k];
  };
  at(final, 0) = end.displacement;
  at(final, 1) = end.lowest;
  at(final, 2) = end.highest;
  if (!obstacle) return;
  at(closings, 0) = static_cast<double>(end.closings);
  at(closings, 1) = end.contact.total(reached);
  at(closings, 2) = end.impulse;
  at(closings, 3) = end.peak_reaction;
}

void tell(SweepRow& row, const Scene& scene, const Statistics& done) {
  tell(row, done);
  if (!done.account) return;
  const RunAccount& account = *done.account;
  tell(row, account.left, is_obstacle(scene.left), done.reached_time, Quantity::u_left_final, Quantity::closings_left);
  tell(row, account.right, is_obstacle(scene.right), done.reached_time, Quantity::u_right_final,
       Quantity::closings_right);
  if (scene.span) row[Quantity::closings_span] = static_cast<double>(account.span.closings);
}

// The columns of `differentiated`, gathered while a run goes on.
struct Derivatives {
  std::size_t keys;
  std::vector<ChangeSensitivity> closing{}, opening{};  // of the first of each, for each key

  void add(const Event& event) {
    auto& first = event.change == Change::closing ? closing : opening;
    if (first.empty()) first = event.sensitivities;
  }
  std::vector<double> row(const Statistics& done) const {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    std::vector<double> values;
    for (std::size_t k = 0; k < keys; ++k) {
      const auto account = [&](const std::vector<double> SensitivityAccount::*member) {
        if (!done.sensitivity || k >= ((*done.sensitivity).*member).size()) return none;
        return ((*done.sensitivity).*member)[k];
      };
      const auto time = [&](const std::vector<ChangeSensitivity>& first) {
        return k < first.size() ? first[k].time : none;
      };
      for (const double value :
           {account(&SensitivityAccount::impulse_left), account(&SensitivityAccount::impulse_right),
            account(&SensitivityAccount::energy), time(closing), time(opening)})
        values.push_back(value);
    }
    return values;
  }
};

// Whether nothing interrupted it.
bool simulate_into(SweepRow& row, const Case& run, const std::function<bool()>& interrupted,
                   accuracy::Probe* probe = nullptr, Statistics* statistics = nullptr) {
  const BarSystem system = make_system(run);
  std::size_t steps = 0, events = 0;
  double reached = 0.0;
  Derivatives derivatives{run.directions.size()};
  Observers observers;
  observers.energy = observers.account = true;
  observers.directions = run.directions;
  observers.event = [&](const Event& event) {
    ++events;
    derivatives.add(event);
    if (probe) probe->add(event);
  };
  if (probe) observers.snapshot = [probe](const Snapshot& snapshot) { probe->add(snapshot); };
  observers.progress = [&](double time) {
    reached = time;
    ++steps;
    return interrupted && interrupted() ? RunControl::stop : RunControl::go_on;
  };
  try {
    const Statistics done = simulate(run, system, observers);
    if (!done.completed) return false;
    if (statistics) *statistics = done;
    tell(row, run.scene, done);
    row.derivatives = derivatives.row(done);
    row.completed = true;
    for (const Alarm& alarm : alarms(run, system, done)) {
      if (!alarm.ruinous) continue;
      row.completed = false;
      row.error += (row.error.empty() ? "" : "; ") + alarm.what;
    }
  } catch (const IntegrationError& error) {
    tell(row, run.scene, error.statistics);
    row.derivatives = derivatives.row(error.statistics);
    row.error = error.what();
  } catch (const std::exception& error) {
    row[Quantity::steps] = static_cast<double>(steps);
    row[Quantity::reached_time] = reached;
    row.error = error.what();
  }
  row[Quantity::events] = static_cast<double>(events);
  return true;
}

// The same of a scene that asks for an error: whose estimate does not keep it is not completed.
bool solve_into(SweepRow& row, const SceneFile& scene, const std::function<bool()>& interrupted) {
  AccuracyStudy study;
  study.scene = scene.run;
  study.request = *scene.accuracy;
  study.threads = 1;
  study.stop = interrupted;
  try {
    accuracy::Plan plan(study);
    while (true) {
      const Case run = plan.next();
      accuracy::Probe probe(run);
      Statistics done;
      row.error.clear();
      if (!simulate_into(row, run, interrupted, &probe, &done)) return false;
      if (!row.completed) return true;
      const ErrorEstimate estimate = plan.judge(probe.take(done));
      if (plan.again()) continue;
      row.completed = estimate.kept;
      if (!estimate.kept) row.error = "the error that was asked for is not kept: " + estimate.doubt;
      return true;
    }
  } catch (const accuracy::Stopped&) {
    return false;
  }
}

std::string fitting(std::string text) {
  constexpr std::string_view cut_off = "...";
  if (text.size() <= longest_error) return text;
  text.resize(longest_error - cut_off.size());
  while (!is_utf8(text)) text.pop_back();
  return text += cut_off;
}

}  // namespace

std::optional<SweepRow> run_case(const std::string& scene_text, const SweepCase& one,
                                 const std::function<bool()>& interrupted) {
  const auto started = std::chrono::steady_clock::now();
  SweepRow row;
  row.index = one.index;
  row[Quantity::steps] = row[Quantity::events] = row[Quantity::reached_time] = 0.0;
  try {
    const SceneFile scene = parse_case(scene_text, "scene", one.overrides);
    if (!(scene.accuracy ? solve_into(row, scene, interrupted) : simulate_into(row, scene.run, interrupted)))
      return std::nullopt;
  } catch (const SceneError& error) {
    for (const Diagnostic& found : error.diagnostics)
      row.error += (row.error.empty() ? "" : "; ") + found.key + ": " + found.message;
  } catch (const std::exception& error) {
    row.error = error.what();
  }
  row.error = fitting(one_line(row.error));
  row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return row;
}

}  // namespace viscobar
