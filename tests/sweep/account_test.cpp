// One account of a run, whoever reads it and however often outputs are told.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "results/json.hpp"
#include "support/absolute_tolerance.hpp"
#include "support/scratch.hpp"
#include "viscobar/record/record_run.hpp"
#include "viscobar/studies/compare/compare.hpp"
#include "viscobar/studies/exact/exact_solutions.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar {
namespace {

using Overrides = std::vector<std::string>;

std::string example(const std::string& name) {
  return read_text(std::string(VISCOBAR_SOURCE_DIR) + "/examples/scenes/" + name + ".toml");
}

constexpr const char* thrown = R"(
[bar]
length = 1.0
viscosity = 0.1
[left]
kind = "obstacle"
gap = 0.0
[initial]
velocity = "-1"
displacement = "0"
[time]
end = 3.0
[mesh]
elements = 40
[contact]
epsilon = 1e-4
[method]
name = "cvode"
step = 1e-3
[output]
every = 0.01
)";

struct Accounts {
  double run, compare, sweep;  // impulse of the left end
  double peak, peak_in_sweep;
  Json span;  // of the summary
};

Accounts told(const std::string& text, const Overrides& overrides) {
  const Scratch scratch;
  const SceneFile scene = parse_scene(text, "scene", overrides);
  const Json summary = Json::parse(record_run(scene, scratch / "out").summary);
  const SweepRow row = run_case(text, {.index = 0, .settings = {overrides.begin(), overrides.end()}}).value();
  const Case cases[] = {scene.run};
  const Comparison comparison = compare(cases, 1);
  double sum = 0.0;
  for (const ContactPeriod& period : comparison.runs.at(0).contacts)
    if (period.where == Where::left) sum += period.impulse.value();
  const Json& left = summary["contact"]["left"];
  return {left["impulse"],
          sum,
          row[Quantity::impulse_left],
          left["max_reaction"],
          row[Quantity::max_reaction_left],
          summary["contact"].value("span", Json())};
}

TEST(Account, RunCompareAndSweepTellOneImpulseAtEveryOutputInterval) {
  const std::pair<std::string, Overrides> scenes[] = {
      {example("chatter"), {}},
      {thrown, {}},
      {thrown, {"method.name=\"ida\""}},
      {thrown, {"method.name=\"arkode\""}},
      {thrown, {"method.name=\"odeint\"", "time.end=0.5"}},
      {thrown, {"method.name=\"exponential\""}},
      {thrown, {"method.name=\"rigid\""}},
      {thrown, {"method.name=\"fully_discrete\""}},
      {thrown, {"method.name=\"finite_difference\""}},
      {example("unit-both-ends"), {"time.end=1.5"}},
      {example("unit-span"),
       {"time.end=3", "span.gap=0.05", "left.kind=\"obstacle\"", "left.gap=0.05", "mesh.elements=40"}},
      {example("unit-span"),
       {"method.name=\"cvode\"", "time.end=3", "span.gap=0.05", "left.kind=\"obstacle\"", "left.gap=0.05"}}};
  for (const auto& [text, overrides] : scenes) {
    std::optional<Accounts> first;
    for (const char* every : {"0.01", "0.11", "0.5"}) {
      Overrides all = overrides;
      all.push_back(std::string("output.every=") + every);
      const Accounts now = told(text, all);
      if (!first) first = now;
      SCOPED_TRACE(text.substr(0, 40) + " " + (overrides.empty() ? "" : overrides.front()) + " " + every);
      EXPECT_GT(now.run, 0.0);
      EXPECT_EQ(now.run, first->run);
      EXPECT_EQ(now.sweep, now.run);
      EXPECT_NEAR(now.compare, now.run, 1e-12 * now.run);  // a sum over the periods
      EXPECT_EQ(now.peak, first->peak);
      EXPECT_EQ(now.span, first->span);
      if (now.span.is_object()) {
        EXPECT_GT(now.span["impulse"], 0.0);
      }
      EXPECT_EQ(now.peak_in_sweep, now.peak);
    }
  }
}

// The reaction is the only force on the bar.
TEST(Account, TheImpulseIsWhatTheBarsMomentumGainsByEveryMethod) {
  for (const char* method : {"cvode", "ida", "arkode", "odeint", "rigid", "exponential", "fully_discrete"}) {
    SCOPED_TRACE(method);
    const SceneFile scene = parse_scene(thrown, "scene", Overrides{std::string("method.name=\"") + method + '"'});
    const Recording recording = record(scene.run);
    const BarSystem system = resolve(scene.run).system();
    std::vector<double> weighted(system.size());
    const auto momentum = [&](std::span<const double> v) {
      system.inertia().matrix().multiply(v, weighted);
      return std::accumulate(weighted.begin(), weighted.end(), 0.0);
    };
    // The node that begins on the obstacle has met it in what is told of t = 0.
    const double gained = momentum(recording.velocity(recording.times.size() - 1)) - momentum(system.initial_state().v);
    // The promise of the velocity, 100 tolerances of 1e-6 at speed 1, over the mass 1. A scheme keeps its balance.
    const double tolerance = is_scheme(scene.run.method) ? 1e-11 : 1e-4;
    EXPECT_NEAR(recording.statistics.account->left.impulse, gained, tolerance);
    EXPECT_GT(gained, 1.0);
  }
}

TEST(Account, TheImpulseOfASpanObstacleIsWhatTheBarsMomentumGainsBesideTheLoad) {
  const std::string text = R"toml(
[bar]
length = 1.0
[span]
gap = 0.1
[initial]
velocity = "-1 - 0.5*cos(pi*x)"
displacement = "0.05*x"
[load]
density = -0.3
[time]
end = 2.0
[mesh]
elements = 30
mass = "lumped"
[contact]
epsilon = 1e-5
[method]
name = "cvode"
step = 1e-3
)toml";
  const Overrides variants[] = {{"bar.viscosity=0.05"},
                                {"bar.viscosity=0"},
                                {"bar.viscosity=0.05", "contact.restitution=0.5"},
                                {"bar.viscosity=0.05", "span.side=\"both\"", "mesh.mass=\"consistent\""},
                                {"bar.viscosity=0.05", "span.side=\"above\"", "initial.velocity=1"}};
  for (const char* method : {"cvode", "ida", "arkode", "odeint", "exponential", "fully_discrete", "finite_difference"})
    for (Overrides overrides : variants) {
      SCOPED_TRACE(method + (" " + overrides.back()));
      overrides.push_back(std::string("method.name=\"") + method + '"');
      if (method == std::string("finite_difference") && overrides.size() > 2) continue;  // lumped, restitution 0
      const Case run = parse_scene(text, "scene", overrides).run;
      const Recording recording = record(run);
      const BarSystem system = resolve(run).system();
      std::vector<double> weighted(system.size());
      const auto momentum = [&](std::span<const double> v) {
        system.inertia().matrix().multiply(v, weighted);
        return std::accumulate(weighted.begin(), weighted.end(), 0.0);
      };
      // A start of first order leaves half a step of the load out.
      const double loaded = is_scheme(run.method) ? run.end - 0.5 * *run.step : run.end;
      const double gained =
          momentum(recording.velocity(recording.times.size() - 1)) - momentum(system.initial_state().v) + 0.3 * loaded;
      const SpanAccount& span = recording.statistics.account->span;
      // The promise of the velocity, 100 tolerances of 1e-6 at speed 1.5, over the mass 1. A scheme keeps its balance.
      EXPECT_NEAR(span.impulse, gained, is_scheme(run.method) ? 1e-11 : 1.5e-4);
      EXPECT_GT(std::abs(gained), 0.9);
      EXPECT_GT(span.peak_reaction, std::abs(span.impulse) / span.contact.total(run.end));  // its mean
    }
}

TEST(Account, ARigidFlightHasNoImpulseAndTheRangeOfItsPath) {
  const exact::RigidFlight flight{.bar = {.viscosity = 0.1}, .speed = 0.5, .gap = 0.25};
  for (const MethodName method :
       {MethodName::cvode, MethodName::arkode, MethodName::exponential, MethodName::fully_discrete}) {
    SCOPED_TRACE(name(method));
    Case run;
    run.scene = flight.scene();
    run.elements = 20;
    run.epsilon = 1e-4;
    run.step = 0.01;
    run.method = method;
    run.end = run.output_every = 0.5 * flight.closing();
    const RunAccount account = *record(run).statistics.account;
    EXPECT_EQ(account.left.impulse, 0.0);
    EXPECT_EQ(account.left.peak_reaction, 0.0);
    EXPECT_EQ(account.left.contact.total(run.end), 0.0);
    EXPECT_EQ(account.left.highest, 0.0);
    // Tolerances: rounding of some hundred steps, on the displacement -0.125.
    for (const EndAccount* end : {&account.left, &account.right}) {
      EXPECT_NEAR(end->lowest, flight.u(0.0, run.end), 1e-13);
      EXPECT_NEAR(end->displacement, end->lowest, 1e-15);
    }
  }
}

// E V / c for 2 L / c. Dispersion leaves strain in the bar, whose momentum is of O(h^(2/3)), and overshoots at the
// fronts, which no mesh takes away.
TEST(Account, AnElasticImpactIsReversedByItsImpulse) {
  const exact::ElasticImpact impact{.bar = {}, .speed = 0.5, .gap = 0.1};
  Case run;
  run.scene = impact.scene();
  run.elements = 50;
  run.mass = Mass::redistributed;
  run.method = MethodName::rigid;
  run.end = impact.opening() + 0.5;
  run.output_every = 1e-3;
  const Recording recording = record(run);
  const Statistics& done = recording.statistics;
  const double front = std::pow(1.0 / 50.0, 2.0 / 3.0), force = impact.reaction(impact.closing() + 1.0);
  const EndAccount& left = done.account->left;
  EXPECT_NEAR(left.impulse, 2.0 * force, 2.0 * force * front);
  EXPECT_NEAR(left.contact.total(run.end), 2.0, front);
  // Nothing is faster than omega = sqrt(12) c / h, so that a maximum is half an interval from an output at most.
  const double omega = std::sqrt(12.0) * 50.0, missed = std::pow(omega * run.output_every / 2.0, 2.0) / 2.0;
  EXPECT_NEAR(left.peak_reaction, std::ranges::max(recording.reaction_left), missed * left.peak_reaction);
  EXPECT_GE(left.peak_reaction, std::ranges::max(recording.reaction_left));
  EXPECT_NEAR(left.lowest, -impact.gap, 100.0 * run.tolerance.relative * impact.gap);
  EXPECT_NEAR(done.energy->initial, impact.energy(), 1e-13);
  EXPECT_NEAR(done.energy->final, impact.energy(), 1e-4 * impact.energy());  // the promised velocities, squared
}

// Seen between two output times only.
TEST(Account, TheRangeOfAnEndIsThatOfItsWholePath) {
  Case run;
  run.scene.displacement = [](double x) { return 0.1 * std::cos(std::numbers::pi * x); };
  run.scene.velocity = [](double) { return 0.0; };
  run.elements = 10;
  run.mass = Mass::consistent;
  // A mode of the mesh, u_j = 0.1 cos(pi j / J) cos(omega t), on the consistent mass.
  const double h = 0.1, cosine = std::cos(std::numbers::pi * h);
  const double omega = std::sqrt(6.0 * (1.0 - cosine) / (2.0 + cosine)) / h;
  run.end = run.output_every = 3.5 * 2.0 * std::numbers::pi / omega / 2.0;
  for (const MethodName method : {MethodName::cvode, MethodName::arkode, MethodName::exponential}) {
    SCOPED_TRACE(name(method));
    run.method = method;
    const RunAccount account = *record(run).statistics.account;
    for (const EndAccount* end : {&account.left, &account.right}) {
      const double promised = 100.0 * (run.tolerance.relative * 0.1 + absolute_tolerance(run));
      EXPECT_NEAR(end->lowest, -0.1, promised);
      EXPECT_NEAR(end->highest, 0.1, promised);
      EXPECT_NEAR(end->displacement, 0.0, promised);
    }
  }
}

// By rigid the node strikes and is back before a wave has crossed its element: one contact, of which the first blow is
// a part. By (2.8) bars that touch at the start have an impulse there.
TEST(Account, AContactHasTheBlowThatItBeginsWith) {
  const std::string thrown_bar =
      "[bar]\nlength = 1.0\n[left]\nkind = \"fixed\"\n[right]\nkind = \"obstacle\"\ngap = 0.1\n[initial]\nvelocity = "
      "\"-x\"\n[time]\nend = 2.0\n[mesh]\nelements = 8\nmass = \"consistent\"\n[method]\nname = \"rigid\"\n";
  const std::string pair =
      "[[bar]]\nlength = 1.0\nvelocity = 1.0\n[[bar]]\nlength = 0.8\nvelocity = 0.0\n[[joint]]\nkind = \"contact\"\n"
      "[time]\nend = 4.0\n[mesh]\nelements = 16\nmass = \"consistent\"\n[method]\nname = \"fully_discrete\"\nstep = 1e-3\n";
  for (const std::string& text : {thrown_bar, pair}) {
    const Recording run = record(parse_scene(text, "").run);
    ASSERT_EQ(run.events.size(), 2U) << text;
    const RunAccount& account = *run.statistics.account;
    const double whole = account.joints.empty() ? account.right.impulse : account.joints.front().impulse;
    EXPECT_NEAR(*run.events[1].impulse - *run.events[0].impulse, whole, 1e-9) << text;
  }
}

// The right end strikes within the step in which the left one turns round.
TEST(Account, TheRangeOfAnEndCountsAStepThatTheOtherEndCuts) {
  Case run = parse_scene(
                 "[bar]\nlength = 1.0\nviscosity = 0.3\n[left]\nkind = \"free\"\nstiffness = 3.0\n[right]\nkind = "
                 "\"obstacle\"\ngap = 0.08\n[initial]\nvelocity = \"2.1*x-1.5\"\n[time]\nend = 1.5\n[mesh]\nelements = "
                 "10\n[method]\nname = \"rigid\"\nrelative_tolerance = 1e-6\n[output]\nevery = 0.002\n",
                 "")
                 .run;
  const Recording done = record(run);
  double lowest = 0.0;
  for (std::size_t k = 0; k < done.times.size(); ++k) lowest = std::min(lowest, done.displacement(k).front());
  EXPECT_NEAR(done.statistics.account->left.lowest, lowest, 1e-5);
}

}  // namespace
}  // namespace viscobar
