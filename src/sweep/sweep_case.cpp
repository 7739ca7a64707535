#include <algorithm>
#include <array>
#include <limits>
#include <new>
#include <string_view>

#include "case/alarm.hpp"
#include "input/described_scene.hpp"
#include "input/toml_text.hpp"
#include "run/stopwatch.hpp"
#include "studies/accuracy/plan.hpp"
#include "sweep/sweep_bars.hpp"
#include "text/printable_text.hpp"
#include "viscobar/record/record_run.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

std::size_t joints_of(const Scene& scene) { return std::max<std::size_t>(scene.chain.size(), 1) - 1; }

void tell(SweepRow& row, const Scene& scene, const Statistics& done) {
  const auto set = [&row](Quantity first, const auto&... values) {
    auto at = row.values.begin() + static_cast<std::ptrdiff_t>(first);
    ((*at++ = static_cast<double>(values)), ...);
  };
  set(Quantity::unknowns, done.unknowns, done.steps, done.rhs_evaluations, done.linear_solves);
  set(Quantity::reached_time, done.reached_time, done.max_penetration);
  row.integration_seconds = done.integration_seconds;
  if (const auto& energy = done.energy)
    set(Quantity::energy_initial, energy->initial, energy->final, energy->dissipated, energy->work,
        energy->balance_error());
  if (!done.account) return;
  const auto set_end = [&](const EndAccount& end, bool obstacle, Quantity final, Quantity closings) {
    set(final, end.displacement, end.lowest, end.highest);
    if (obstacle) set(closings, end.closings, end.contact.total(done.reached_time), end.impulse, end.peak_reaction);
  };
  set_end(done.account->left, is_obstacle(scene.left), Quantity::u_left_final, Quantity::closings_left);
  set_end(done.account->right, is_obstacle(scene.right), Quantity::u_right_final, Quantity::closings_right);
  for (std::size_t k = 0; k < joints_of(scene); ++k) {
    if (scene.chain[k].joint.kind != JointKind::contact) continue;
    const ContactAccount joint = done.account->joint(k + 1);
    const std::array<double, joint_values> values = {static_cast<double>(joint.closings),
                                                     joint.contact.total(done.reached_time), joint.impulse,
                                                     joint.peak_reaction};
    std::ranges::copy(values, &row.values[quantities + joint_values * k]);
  }
  if (scene.span) set(Quantity::closings_span, done.account->span.closings);
}

// The columns of `differentiated`, gathered while a run goes on.
struct Derivatives {
  std::size_t keys;
  std::vector<ChangeSensitivity> closing{}, opening{};  // of the first of each, for each key

  void add(const Event& event) {
    auto& first = event.change == Change::closing ? closing : opening;
    if (first.empty()) first = event.sensitivities;
  }
  void tell(SweepRow& row, const Statistics& done) const {
    const SensitivityAccount account = done.sensitivity.value_or(SensitivityAccount{});
    auto to = row.values.end() - static_cast<std::ptrdiff_t>(keys * differentiated.size());
    for (std::size_t k = 0; k < keys; ++k) {
      for (const auto* list : {&account.impulse_left, &account.impulse_right, &account.energy})
        *to++ = k < list->size() ? (*list)[k] : none;
      for (const auto* first : {&closing, &opening}) *to++ = k < first->size() ? (*first)[k].time : none;
    }
  }
};

void add_sentence(std::string& text, const std::string& sentence) { text += (text.empty() ? "" : "; ") + sentence; }

// Runs a case into a row. False if interrupted. A probe is told the motion at `times`.
bool simulate_into(SweepRow& row, const Case& run, const std::function<bool()>& interrupted,
                   accuracy::Probe* probe = nullptr, std::span<const double> times = {},
                   Statistics* statistics = nullptr) {
  const Setup setup = resolve(run);
  const BarSystem system = setup.system();
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
    const Statistics done = probe ? simulate(setup, system, times, observers) : simulate(setup, system, observers);
    if (!done.completed) return false;
    if (statistics) *statistics = done;
    tell(row, run.scene, done);
    derivatives.tell(row, done);
    for (const Alarm& alarm : alarms(setup, system, done))
      if (alarm.ruinous) add_sentence(row.error, alarm.what);
    row.completed = row.error.empty();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const IntegrationError& error) {
    if (error.failure == Failure::memory) throw std::bad_alloc();
    tell(row, run.scene, error.statistics);
    derivatives.tell(row, error.statistics);
    row.error = error.what();
  } catch (const std::exception& error) {
    row[Quantity::steps] = static_cast<double>(steps);
    row[Quantity::reached_time] = reached;
    row.error = error.what();
  }
  row[Quantity::events] = static_cast<double>(events);
  return true;
}

void tell_chosen(SweepRow& row, const Case& run) {
  const AccuracyStart settings = start_at(run);
  if (settings.elements == 0) return;
  const std::array<double, chosen_values> chosen = {
      static_cast<double>(settings.elements), settings.tolerance.value_or(none),
      is_scheme(run.method) ? run.step.value_or(none) : none, settings.epsilon.value_or(none)};
  std::ranges::copy(chosen, &row.values[quantities + joint_values * joints_of(run.scene)]);
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
      tell_chosen(row, run);
      accuracy::Probe probe(run, plan.times().size());
      Statistics done;
      row.error.clear();
      if (!simulate_into(row, run, interrupted, &probe, plan.times(), &done)) return false;
      if (!row.completed) return true;
      const ErrorEstimate estimate = plan.judge(probe.take(done));
      if (plan.again()) continue;
      row.completed = estimate.kept;
      if (!estimate.kept) row.error = "the error that was asked for is not kept: " + estimate.doubt;
      return true;
    }
  } catch (const StudyStopped&) {
    return false;
  }
}

}  // namespace

std::string fitting(std::string text) {
  constexpr std::string_view cut_off = "...";
  if (text.size() <= longest_error) return text;
  text.resize(longest_error - cut_off.size());
  while (!is_utf8(text)) text.pop_back();
  return text += cut_off;
}

std::vector<SweepRow> run_cases(const SweepFile& sweep, std::span<const std::size_t> indices,
                                const std::function<bool()>& interrupted) {
  if (!sweep.ensemble.outputs.empty()) return run_bars(sweep, indices, interrupted);
  std::vector<SweepRow> rows;
  for (const std::size_t i : indices)
    if (auto row = run_case(sweep.scene_text, case_of(sweep, i), interrupted)) rows.push_back(*std::move(row));
  return rows;
}

std::optional<SweepRow> run_case(const std::string& scene_text, const SweepCase& one,
                                 const std::function<bool()>& interrupted) {
  const WallClock clock;
  SweepRow row;
  row.index = one.index;
  row[Quantity::steps] = row[Quantity::events] = row[Quantity::reached_time] = 0.0;
  try {
    const SceneFile scene = parse_scene_with(scene_text, "scene", one.settings, {}, Telling::nothing);
    row.values.resize(quantities + joint_values * joints_of(scene.run.scene) + (scene.accuracy ? chosen_values : 0) +
                          scene.run.directions.size() * differentiated.size(),
                      none);
    if (!(scene.accuracy ? solve_into(row, scene, interrupted) : simulate_into(row, scene.run, interrupted)))
      return std::nullopt;
  } catch (const std::bad_alloc&) {
    throw;  // the machine's failure, not the case's: it has no row, and the sweep goes on later
  } catch (const SceneError& error) {
    for (const Diagnostic& found : error.diagnostics) add_sentence(row.error, found.key + ": " + found.message);
  } catch (const std::exception& error) {
    row.error = error.what();
  }
  row.error = fitting(one_line(row.error));
  row.seconds = clock.seconds();
  return row;
}

}  // namespace viscobar
