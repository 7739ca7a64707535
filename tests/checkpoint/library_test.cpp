// A run that begins from a checkpoint is the run that the checkpoint was taken from: every number afterwards the same,
// for every method in every kind of scene that it takes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "checkpoint/scenes.hpp"
#include "viscobar/viscobar.hpp"

namespace viscobar::testing_library {
namespace {

using testing_checkpoint::kinds_of_scenes;
using testing_checkpoint::NamedCase;

/// All that a run tells, as bits.
struct Told {
  std::vector<double> snapshots, events;
  Statistics statistics;
};

/// A checkpoint, and how much had been told before it.
struct Taken {
  Checkpoint checkpoint;
  std::size_t snapshots, events;
};

Observers listening(Told& told) {
  Observers observers;
  observers.energy = true;
  observers.snapshot = [&told](const Snapshot& at) {
    told.snapshots.insert(told.snapshots.end(), {at.time, at.reaction_left, at.reaction_right});
    told.snapshots.insert(told.snapshots.end(), at.u.begin(), at.u.end());
    told.snapshots.insert(told.snapshots.end(), at.v.begin(), at.v.end());
  };
  observers.event = [&told](const Event& event) {
    told.events.insert(told.events.end(),
                       {event.time, static_cast<double>(event.where), static_cast<double>(event.node),
                        static_cast<double>(event.change), event.velocity});
  };
  return observers;
}

Told run_with(const Case& run, Checkpoints checkpoints, std::vector<Taken>& taken) {
  Told told;
  Observers observers = listening(told);
  checkpoints.take = [&](const Checkpoint& checkpoint) {
    taken.push_back({checkpoint, told.snapshots.size(), told.events.size()});
    return RunControl::go_on;
  };
  observers.checkpoints = checkpoints;
  told.statistics = simulate(resolve(run), observers);
  return told;
}

Told resumed(const Case& run, const Checkpoint& from, const Checkpoints& schedule) {
  Told told;
  Observers observers = listening(told);
  observers.checkpoints = schedule;
  observers.checkpoints->take = [](const Checkpoint&) { return RunControl::go_on; };
  told.statistics = simulate(resolve(run), resolve(run).system(), from, observers);
  return told;
}

std::vector<double> behind(const std::vector<double>& all, std::size_t first) {
  return {all.begin() + static_cast<std::ptrdiff_t>(first), all.end()};
}

void expect_same(const Statistics& a, const Statistics& b) {
  EXPECT_EQ(a.unknowns, b.unknowns);
  EXPECT_EQ(a.steps, b.steps);
  EXPECT_EQ(a.rhs_evaluations, b.rhs_evaluations);
  EXPECT_EQ(a.linear_solves, b.linear_solves);
  EXPECT_EQ(a.matrix_factorisations, b.matrix_factorisations);
  EXPECT_EQ(a.event_evaluations, b.event_evaluations);
  EXPECT_EQ(a.load_evaluations, b.load_evaluations);
  EXPECT_EQ(a.events, b.events);
  EXPECT_EQ(a.reached_time, b.reached_time);
  EXPECT_EQ(a.completed, b.completed);
  EXPECT_EQ(a.max_penetration, b.max_penetration);
  EXPECT_EQ(a.energy->initial, b.energy->initial);
  EXPECT_EQ(a.energy->final, b.energy->final);
  EXPECT_EQ(a.energy->dissipated, b.energy->dissipated);
  EXPECT_EQ(a.energy->work, b.energy->work);
  EXPECT_EQ(a.energy->growth, b.energy->growth);
  EXPECT_EQ(a.energy->growth_time, b.energy->growth_time);
}

class EveryMethod : public testing::TestWithParam<MethodName> {
 protected:
  /// The kinds of scenes that the method takes.
  static std::vector<NamedCase> scenes() {
    std::vector<NamedCase> all = kinds_of_scenes();
    for (NamedCase& scene : all) scene.run.method = GetParam();
    std::erase_if(all, [](const NamedCase& scene) { return !faults(resolve(scene.run)).empty(); });
    EXPECT_GE(all.size(), 2u);
    return all;
  }
};

TEST_P(EveryMethod, GoesOnFromACheckpointBitForBit) {
  for (const auto& [name, run] : scenes()) {
    SCOPED_TRACE(name);
    const Checkpoints schedule{.every = 0.23, .asked = {}, .take = {}};
    std::vector<Taken> taken;
    const Told whole = run_with(run, schedule, taken);
    ASSERT_GE(taken.size(), 4u);
    EXPECT_GT(whole.events.size(), 0u);
    for (const std::size_t i : {std::size_t{0}, taken.size() / 2, taken.size() - 1}) {
      const Told rest = resumed(run, taken[i].checkpoint, schedule);
      EXPECT_EQ(rest.snapshots, behind(whole.snapshots, taken[i].snapshots));
      EXPECT_EQ(rest.events, behind(whole.events, taken[i].events));
      expect_same(rest.statistics, whole.statistics);
    }
  }
}

TEST_P(EveryMethod, GoesOnFromWhereACheckpointWasAskedFor) {
  for (const auto& [name, run] : scenes()) {
    SCOPED_TRACE(name);
    std::size_t steps = 0;
    const Checkpoints whenever{.every = {}, .asked = [&] { return ++steps == 12; }, .take = {}};
    std::vector<Taken> taken;
    const Told whole = run_with(run, whenever, taken);
    ASSERT_EQ(taken.size(), 1u);
    const Told rest = resumed(run, taken[0].checkpoint, {});
    EXPECT_EQ(rest.snapshots, behind(whole.snapshots, taken[0].snapshots));
    EXPECT_EQ(rest.events, behind(whole.events, taken[0].events));
    expect_same(rest.statistics, whole.statistics);
  }
}

TEST_P(EveryMethod, CountsOutputsThatNobodyListensTo) {
  const Case run = scenes().front().run;
  std::vector<Taken> taken;
  const Told whole = run_with(run, {.every = 0.5, .asked = {}, .take = {}}, taken);
  std::vector<Checkpoint> silent;
  Observers observers;
  observers.energy = true;
  const auto keep = [&](const Checkpoint& made) {
    silent.push_back(made);
    return RunControl::go_on;
  };
  observers.checkpoints = Checkpoints{.every = 0.5, .asked = {}, .take = keep};
  simulate(resolve(run), observers);
  ASSERT_EQ(silent.size(), taken.size());
  const Told rest = resumed(run, silent[1], {.every = 0.5, .asked = {}, .take = {}});
  EXPECT_EQ(rest.snapshots, behind(whole.snapshots, taken[1].snapshots));
}

std::vector<double> before(const std::vector<double>& all, std::size_t count) {
  return {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count)};
}

TEST_P(EveryMethod, StopsAfterTheStepThatItsObserverSaysAndReturnsWhatItReached) {
  for (const auto& [name, run] : scenes()) {
    SCOPED_TRACE(name);
    std::vector<Taken> taken;
    const Told whole = run_with(run, {}, taken);
    Told told;
    Observers observers = listening(told);
    double last = 0.0;
    observers.progress = [&](double time) {
      last = time;
      return time < 1.0 ? RunControl::go_on : RunControl::stop;
    };
    told.statistics = simulate(resolve(run), observers);
    EXPECT_FALSE(told.statistics.completed);
    EXPECT_EQ(told.statistics.reached_time, last);
    EXPECT_GE(last, 1.0);
    EXPECT_LT(last, run.end);
    EXPECT_LT(told.statistics.steps, whole.statistics.steps);
    EXPECT_EQ(told.snapshots, before(whole.snapshots, told.snapshots.size()));
    EXPECT_EQ(told.events, before(whole.events, told.events.size()));
  }
}

TEST_P(EveryMethod, StopsAtACheckpointAndGoesOnFromItAsIfItNeverHad) {
  for (const auto& [name, run] : scenes()) {
    SCOPED_TRACE(name);
    const Checkpoints schedule{.every = 0.5, .asked = {}, .take = {}};
    std::vector<Taken> taken;
    const Told whole = run_with(run, schedule, taken);
    Told told;
    Observers observers = listening(told);
    observers.checkpoints = schedule;
    std::vector<Checkpoint> made;
    observers.checkpoints->take = [&](const Checkpoint& one) {
      made.push_back(one);
      return made.size() < 2 ? RunControl::go_on : RunControl::stop;
    };
    told.statistics = simulate(resolve(run), observers);
    ASSERT_EQ(made.size(), 2u);
    EXPECT_FALSE(told.statistics.completed);
    EXPECT_EQ(told.statistics.reached_time, made.back().time);
    const Told rest = resumed(run, made.back(), schedule);
    told.snapshots.insert(told.snapshots.end(), rest.snapshots.begin(), rest.snapshots.end());
    told.events.insert(told.events.end(), rest.events.begin(), rest.events.end());
    EXPECT_EQ(told.snapshots, whole.snapshots);
    EXPECT_EQ(told.events, whole.events);
    expect_same(rest.statistics, whole.statistics);
  }
}

TEST_P(EveryMethod, RefusesACheckpointOfAnotherRun) {
  Case run = scenes().front().run;
  std::vector<Taken> taken;
  run_with(run, {.every = 0.5, .asked = {}, .take = {}}, taken);
  Case finer = run;
  finer.elements += 1;
  EXPECT_THROW(resumed(finer, taken[0].checkpoint, {}), std::invalid_argument);
  Case ended = run;
  ended.end = 0.4;
  EXPECT_THROW(resumed(ended, taken[0].checkpoint, {}), std::invalid_argument);
  EXPECT_THROW(simulate(resolve(run), resolve(run).system(), taken[0].checkpoint, {}),
               std::invalid_argument);  // no energy account
  Checkpoint short_one = taken[0].checkpoint;
  short_one.state.pop_back();
  EXPECT_THROW(resumed(run, short_one, {}), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Checkpoints, EveryMethod, testing::ValuesIn(all_methods),
                         [](const auto& method) { return std::string(name(method.param)); });

TEST(Checkpoint, ComesAtMultiplesOfItsIntervalAndNeverAtTheEnd) {
  Case run = kinds_of_scenes().front().run;
  run.end = 1.0;
  run.method = MethodName::cvode;
  std::vector<Taken> taken;
  run_with(run, {.every = 0.1, .asked = {}, .take = {}}, taken);
  ASSERT_EQ(taken.size(), 9u);
  for (std::size_t k = 0; k < taken.size(); ++k) EXPECT_EQ(taken[k].checkpoint.time, static_cast<double>(k + 1) * 0.1);
  EXPECT_THROW(run_with(run, {.every = 0.0, .asked = {}, .take = {}}, taken), std::invalid_argument);
  EXPECT_THROW(run_with(run, {.every = 1e-17, .asked = {}, .take = {}}, taken), std::invalid_argument);
}

TEST(Checkpoint, LeavesTheMotionByASchemeAsItWas) {
  std::size_t compared = 0;
  for (auto [name, run] : kinds_of_scenes()) {
    run.method = MethodName::fully_discrete;
    if (!faults(resolve(run)).empty()) continue;
    ++compared;
    SCOPED_TRACE(name);
    std::vector<Taken> none, some;
    const Told without = run_with(run, {}, none), with = run_with(run, {.every = 0.05, .asked = {}, .take = {}}, some);
    EXPECT_EQ(none.size(), 0u);
    EXPECT_GT(some.size(), 20u);
    EXPECT_EQ(with.snapshots, without.snapshots);
    EXPECT_EQ(with.events, without.events);
    expect_same(with.statistics, without.statistics);
  }
  EXPECT_GE(compared, 2u);
}

// Accuracy that the docs promise of any run: 100 times the tolerance asked for, here with a new beginning every 25th of
// the bar's transit time.
TEST(Checkpoint, CostsNoAccuracy) {
  Case run = kinds_of_scenes().front().run;
  run.tolerance = {1e-8, 1e-11};
  run.method = MethodName::exponential;
  std::vector<Taken> taken;
  const Told exact = run_with(run, {}, taken);
  double largest = 0.0;
  for (const double value : exact.snapshots) largest = std::max(largest, std::abs(value));
  for (const MethodName method : {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint}) {
    run.method = method;
    const Told told = run_with(run, {.every = 0.04, .asked = {}, .take = {}}, taken);
    ASSERT_EQ(told.snapshots.size(), exact.snapshots.size());
    const std::size_t nodes = run.elements + 1, row = 3 + 2 * nodes;
    double error = 0.0;
    for (std::size_t i = 0; i < told.snapshots.size(); ++i)
      if (i % row >= 3 && i % row < 3 + nodes)
        error = std::max(error, std::abs(told.snapshots[i] - exact.snapshots[i]));
    EXPECT_LE(error, 100 * run.tolerance.relative * largest) << name(method);
  }
}

}  // namespace
}  // namespace viscobar::testing_library
