// Loads that jump or have kinks, by every method: against solutions in closed form, and against runs that are cut by
// hand into pieces of steady load, which know nothing of breaks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "input/formula.hpp"
#include "support/absolute_tolerance.hpp"
#include "support/maximum_norm.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar::testing_switching_load {
namespace {

constexpr double promise = 100.0;  // multiples of the tolerance, docs/methods.md
constexpr MethodName adaptive[] = {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint};

Load history(const std::string& text) {
  const Formula formula(text, "t");
  return SeparableLoad{[](double) { return 1.0; }, formula.of_t(), formula.breaks()};
}

Case bar_under(Load load, double viscosity) {
  Case run;
  run.scene.bar = {1.0, 1.0, 1.0, viscosity};
  run.scene.displacement = run.scene.velocity = [](double) { return 0.0; };
  run.scene.load = std::move(load);
  run.elements = 8;
  run.end = 4.0;
  run.output_every = 0.05;
  return run;
}

Recording by(Case run, MethodName method) {
  run.method = method;
  return record(run);
}

double tolerance(const Case& run, const Recording& reference) {
  return promise * (run.tolerance.relative * largest(reference.u) + absolute_tolerance(run));
}

/// Piecewise constant: value[k] up to times[k], the last one from then on.
struct Steps {
  std::vector<double> times, values;

  std::string formula() const {
    std::string text;
    char piece[100];
    for (std::size_t k = 0; k < times.size(); ++k) {
      std::snprintf(piece, sizeof piece, "t < %.17g ? %.17g : ", times[k], values[k]);
      text += piece;
    }
    std::snprintf(piece, sizeof piece, "%.17g", values.back());
    return text + piece;
  }
};

/// The motion under steps of a uniform load, cut by hand: a run with a steady load for each.
Recording cut(const Case& run, const Steps& steps) {
  Recording whole;
  const std::vector<double> outputs = run.output_times();
  double begin = 0.0;
  std::optional<State> state;
  std::set<std::size_t> closed;  // contacts, by their nodes
  for (std::size_t k = 0; k < steps.values.size(); ++k) {
    const double end = k < steps.times.size() ? steps.times[k] : run.end;
    Case piece = run;
    piece.scene.load = SteadyLoad{[value = steps.values[k]](double) { return value; }};
    const BarSystem system = resolve(piece).system();
    std::vector<double> times = {begin};
    for (const double t : outputs)
      if (t > begin && t < end) times.push_back(t);
    times.push_back(end);
    Observers observers;
    State reached;
    std::set<std::size_t> still_closed, now_closed;
    observers.snapshot = [&](const Snapshot& at) {
      // An output at a cut is that of the piece before.
      const bool output = std::ranges::find(outputs, at.time) != outputs.end() && (at.time > begin || begin == 0.0);
      if (output) whole.u.insert(whole.u.end(), at.u.begin(), at.u.end());
      reached.u.assign(at.u.begin(), at.u.end());
      reached.v.assign(at.v.begin(), at.v.end());
    };
    observers.event = [&](const Event& event) {
      if (event.time == begin) still_closed.insert(event.node);
      // A contact that was closed before is told again.
      if (event.time > begin || !closed.contains(event.node)) whole.events.push_back(event);
      event.change == Change::closing ? (void)now_closed.insert(event.node) : (void)now_closed.erase(event.node);
    };
    integrate(system, state.value_or(system.initial_state()), times, Exponential{{piece.epsilon}}, observers);
    for (const std::size_t node : closed)
      if (!still_closed.contains(node)) whole.events.push_back({begin, {}, node, Change::opening, 0.0});
    closed = now_closed;
    state = reached;
    begin = end;
  }
  return whole;
}

TEST(SwitchingLoad, OfABlowAndItsOppositeKeepsThePromise) {
  // A free bar moves as one: u(T) = sum of the impulses times the time left from their middle.
  const Case run = bar_under(history("5.794*((t>1.8226)*(t<1.89)-(t>1.89)*(t<1.9574))"), 0.1);
  const double impulse = 5.794 * (1.89 - 1.8226), back = 5.794 * (1.9574 - 1.89);
  const double u = impulse * (4.0 - (1.8226 + 1.89) / 2) - back * (4.0 - (1.89 + 1.9574) / 2);
  for (const MethodName method : adaptive) {
    const Recording found = by(run, method);
    EXPECT_NEAR(found.u.back(), u, promise * (1e-6 * u + 1e-9)) << name(method);
  }
  EXPECT_NEAR(by(run, MethodName::exponential).u.back(), u, 1e-13);
}

TEST(SwitchingLoad, OfASquareWaveOnMasslessNodesWithLittleViscosityKeepsEnergyAndChanges) {
  for (const char* wave : {"cos(9*t) > 0 ? 3 : -4", "sin(7.3*t) < 0.2 ? 1.5 : -1.2", "sin(3*t) > 0 ? 2 : -3"}) {
    Case run = bar_under(history(wave), 2.2e-6);
    run.scene.left = Obstacle{0.1};
    run.scene.velocity = [](double) { return -0.3; };
    run.mass = Mass::redistributed;
    run.epsilon = 1e-3;
    Case finer = run;  // the exponential method takes half a million steps
    finer.tolerance = {1e-10, 1e-13};
    const Recording reference = by(finer, MethodName::arkode);
    for (const MethodName method : adaptive) {
      const Recording found = by(run, method);
      EXPECT_LE(distance(found.u, reference.u), tolerance(run, reference) + tolerance(finer, reference))
          << wave << ", " << name(method);
      EXPECT_EQ(found.events.size(), reference.events.size()) << wave << ", " << name(method);
      // Bound: error of the kinetic energy by the promised one of the velocities.
      const double v = largest(reference.v);
      EXPECT_LE(std::abs(found.statistics.energy->balance_error()), v * promise * (1e-6 * v + 1e-9))
          << wave << ", " << name(method);
    }
  }
}

// Random bars, obstacles and steps of the load, some of which press a contact open or closed.
TEST(SwitchingLoad, OfRandomStepsIsWhatRunsCutByHandGive) {
  std::mt19937 random(3);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  std::size_t compared = 0;
  for (int trial = 0; trial < 24; ++trial) {
    Steps steps;
    for (double t = uniform(0.0, 0.6); t < 3.0; t += uniform(0.0, 0.6) * uniform(0.0, 1.0)) steps.times.push_back(t);
    for (std::size_t k = 0; k <= steps.times.size(); ++k) steps.values.push_back(uniform(-3.0, 2.0));
    const double viscosity = trial % 3 == 0 ? 0.0 : uniform(0.005, 0.5);
    Case run = bar_under(history(steps.formula()), viscosity);
    run.end = 3.0;
    run.mass = trial % 2 ? Mass::redistributed : Mass::consistent;
    if (trial % 4 < 3) run.scene.left = Obstacle{uniform(0.0, 0.2)};
    if (trial % 5 < 2) run.scene.right = Obstacle{uniform(0.0, 0.2)};
    run.epsilon = trial % 2 ? 1e-4 : 1e-2;
    const double speed = uniform(-0.5, 0.5);
    run.scene.velocity = [speed](double x) { return speed * (1 - x); };
    const Recording reference = cut(run, steps);
    SCOPED_TRACE(testing::Message() << "trial " << trial << ", viscosity " << viscosity << ": " << steps.formula());
    const Recording exponential = by(run, MethodName::exponential);
    EXPECT_LE(distance(exponential.u, reference.u), 1e-10 * (1 + largest(reference.u)));
    EXPECT_EQ(exponential.events.size(), reference.events.size());
    for (const MethodName method : adaptive) {
      run.method = method;
      if (!faults(resolve(run)).empty()) continue;  // massless nodes without viscosity are not for all
      ++compared;
      const Recording found = by(run, method);
      EXPECT_LE(distance(found.u, reference.u), tolerance(run, reference)) << name(method);
    }
  }
  EXPECT_EQ(compared, 24u * 4 - 3 * 2);  // cvode and odeint do not take three that are massless and undamped
}

TEST(SwitchingLoad, OfAFrontThatMovesThroughTheMeshKeepsThePromise) {
  for (const char* front : {"x < 0.4*t ? -2 : 0.5", "-3*max(0, 1 - abs(x - 0.3*t)/0.1)", "x > 0.5 + 0.4*sin(5*t)"}) {
    const Formula formula(front, "xt");
    Case run = bar_under(GeneralLoad{formula.of_x_t(), formula.breaks(), formula.breaks_at()}, 0.05);
    run.scene.left = Obstacle{0.05};
    run.epsilon = 1e-3;
    const Recording reference = by(run, MethodName::exponential);
    for (const MethodName method : adaptive) {
      const Recording found = by(run, method);
      EXPECT_LE(distance(found.u, reference.u), tolerance(run, reference)) << front << ", " << name(method);
    }
  }
}

// Neither the surface nor the displacement gives roundings a scale there, and a step of a 64th of the run would miss
// all of it. What lifts the bar has the impulse (height times half the width) at its middle.
TEST(SwitchingLoad, OfAShortBlowLiftsABarOffTheObstacleThatItRestsOn) {
  const double middle = 1.03605, half_width = 0.0210916, height = 13.8374;
  const Formula formula("13.8374*max(0, 1 - abs(t - 1.03605)/0.0210916)", "t");
  for (const double gap : {0.0, 1e-3}) {
    Case run = bar_under(SeparableLoad{[](double) { return 1.0; }, formula.of_t(), formula.breaks()}, 0.5);
    run.scene.left = Obstacle{gap};
    run.epsilon = 1e-4;
    run.mass = Mass::consistent;
    const double u = height * half_width * (run.end - middle);
    for (const MethodName method :
         {MethodName::exponential, MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint}) {
      const Recording found = by(run, method);
      const double allowed = method == MethodName::exponential ? 1e-12 : promise * (1e-6 * u + 1e-9);
      EXPECT_NEAR(found.u.back(), u, allowed) << name(method) << ", gap " << gap;
      EXPECT_TRUE(found.events.empty()) << name(method) << ", gap " << gap;
    }
  }
}

// The mean displacement of a free bar answers to the sum of the load's entries alone: each node, of weight h (h/2 at
// the ends), is loaded by -2.5 more from the time on at which the front is there.
TEST(SwitchingLoad, OfAFrontMovesTheMeanOfAFreeBarByItsImpulse) {
  const Formula formula("x < 0.4*t ? -2 : 0.5", "xt");
  Case run = bar_under(GeneralLoad{formula.of_x_t(), formula.breaks(), formula.breaks_at()}, 0.05);
  run.mass = Mass::consistent;
  double expected = 0.5 * 16 / 2;
  const auto weight = [](std::size_t j) { return j % 8 == 0 ? 0.0625 : 0.125; };
  for (std::size_t j = 0; j <= 8; ++j)
    expected -= 2.5 * weight(j) * std::pow(4.0 - 0.3125 * static_cast<double>(j), 2) / 2;
  for (const MethodName method :
       {MethodName::exponential, MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint}) {
    const Recording found = by(run, method);
    double mean = 0.0;
    for (std::size_t j = 0; j <= 8; ++j) mean += weight(j) * found.u[found.u.size() - 9 + j];
    const double rounding = 1e-12 * std::abs(expected);
    EXPECT_NEAR(mean, expected, method == MethodName::exponential ? rounding : tolerance(run, found)) << name(method);
  }
}

// An undamped massless node is displaced by h/E times its share of the load at once: 0.03 here, where the bar has come
// to 2e-4.
TEST(SwitchingLoad, ThatJumpsOpensAndClosesAContactOfAMasslessNodeThere) {
  Case run = bar_under(history("t < 0.01 ? -4 : t < 0.02 ? 4 : -4"), 0.0);
  run.scene.left = Obstacle{0.0};
  run.mass = Mass::redistributed;
  run.epsilon = 1e-4;
  run.end = 0.1;
  run.output_every = 0.01;
  const Recording reference = cut(run, {{0.01, 0.02}, {-4.0, 4.0, -4.0}});
  for (const MethodName method : {MethodName::ida, MethodName::arkode, MethodName::exponential}) {
    const Recording found = by(run, method);
    EXPECT_LE(distance(found.u, reference.u), tolerance(run, reference)) << name(method);
    ASSERT_EQ(found.events.size(), 3u) << name(method);
    EXPECT_EQ(found.events[1].time, 0.01) << name(method);
    EXPECT_EQ(found.events[1].change, Change::opening) << name(method);
    EXPECT_EQ(found.events[2].time, 0.02) << name(method);
    EXPECT_EQ(found.events[2].change, Change::closing) << name(method);
    // The jumps strain the element beside the node: the energy of that, F^2 h / (2 E) = 0.002 with F = 8 / 16, is their
    // work.
    const EnergyAccount& energy = *found.statistics.energy;
    EXPECT_NEAR(energy.balance_error(), 0.0, 200 * run.tolerance.relative * energy.work) << name(method);
  }
}

// The pull at the opening is that of the force since it has jumped, which is no pull that the contact held out.
TEST(SwitchingLoad, ThatLetsGoOfAContactAtRestIsNoLateOpening) {
  for (const MethodName method : adaptive)
    for (const double epsilon : {1e-5, 1e-7, 1e-9}) {
      Case run = parse_scene(R"(
[bar]
length = 1.0
viscosity = 0.1
[left]
kind = "obstacle"
gap = 0.0
force = "t < 3 ? -1 : 1"
[time]
end = 3.5
[mesh]
elements = 20
mass = "lumped"
[contact]
restitution = 0.5
epsilon = 1e-7
[method]
name = "arkode"
[output]
every = 3.5
)",
                             "let-go.toml")
                     .run;
      run.method = method;
      run.epsilon = epsilon;
      EXPECT_LT(record(run).statistics.late_opening.ratio, 1.0) << name(method) << " " << epsilon;
    }
}

// Steps do not pile up where the load jumps.
TEST(SwitchingLoad, IsCrossedWithoutStepsThatShrinkToNothing) {
  const Case jump = bar_under(history("t < 1.37 ? 1 : 3"), 0.1), smooth = bar_under(history("1 + t/4"), 0.1);
  for (const MethodName method : adaptive)
    EXPECT_LE(by(jump, method).statistics.steps, 2 * by(smooth, method).statistics.steps + 64) << name(method);
}

// A pulse of impulse 1 that no step of 0.01 looks at, one that it looks at once, a jump within a step, and a value at
// one instant, of impulse 0. The bar moves as a whole: v is the impulse so far. What the steps and sums round is below
// 1e-10 of it; the start of first order loses nothing here, because nothing acts then.
TEST(SwitchingLoad, GivesItsImpulseToTheSchemesHoweverShortItIs) {
  const struct {
    const char* text;
    double impulse;
  } loads[] = {{"t > 0.1 && t < 0.1001 ? 10000 : 0", 1.0},
               {"t > 0.10003 && t < 0.10013 ? 10000 : 0", 1.0},
               {"t > 0.1234567 ? 1 : 0", 2.0 - 0.1234567},
               {"t > 0.5 && t < 0.9 ? 1 : 0", 0.4},
               {"t == 1 ? 1e9 : 0", 0.0}};
  for (const auto& [text, impulse] : loads)
    for (const MethodName method : {MethodName::fully_discrete, MethodName::finite_difference}) {
      Case run = bar_under(history(text), 0.0);
      run.end = 2.0;
      run.step = 0.01;
      const Recording recording = by(run, method);
      EXPECT_NEAR(recording.v.back(), impulse, 1e-10) << text;
    }
}

}  // namespace
}  // namespace viscobar::testing_switching_load
