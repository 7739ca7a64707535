// A run with sensitivities beside one without, and runs that have none.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "support/falling_bar.hpp"
#include "viscobar/case/case.hpp"
#include "viscobar/case/recording.hpp"

namespace {

using namespace viscobar;

Case thrown(MethodName method) {
  Case run;
  run.scene.bar.viscosity = 0.05;
  run.scene.left = Obstacle{0.1};
  run.scene.right = Obstacle{0.2};
  run.scene.displacement = [](double x) { return 0.05 * x * (1.0 - x); };
  run.scene.velocity = [](double x) { return -1.0 + 0.3 * x; };
  run.elements = 25;
  run.method = method;
  run.epsilon = 1e-3;
  if (is_penalised(method)) run.mass = Mass::redistributed;
  run.end = 3.0;
  run.output_every = 0.1;
  return run;
}

std::vector<Direction> directions(const Case& run, std::initializer_list<const char*> keys) {
  std::vector<Direction> all;
  for (const char* key : keys) all.push_back(direction(run, key));
  return all;
}

constexpr MethodName with_sensitivities[] = {MethodName::rigid, MethodName::cvode, MethodName::ida, MethodName::arkode};

// Where the motion stirs them, as it does here.
TEST(Sensitivities, LeaveEveryDigitOfARunWhoseStepsAreRightForThem) {
  for (const MethodName method : {MethodName::cvode, MethodName::ida}) {
    Case run = thrown(method);
    const Recording without = record(run);
    run.directions = directions(run, {"bar.viscosity", "bar.length"});
    const Recording with = record(run);
    EXPECT_EQ(with.u, without.u) << name(method);
    EXPECT_EQ(with.v, without.v) << name(method);
    EXPECT_EQ(with.statistics.steps, without.statistics.steps) << name(method);
    EXPECT_EQ(with.statistics.matrix_factorisations, without.statistics.matrix_factorisations) << name(method);
    EXPECT_EQ(with.statistics.account->left.impulse, without.statistics.account->left.impulse) << name(method);
    ASSERT_EQ(with.events.size(), without.events.size()) << name(method);
    for (std::size_t i = 0; i < with.events.size(); ++i) EXPECT_EQ(with.events[i].time, without.events[i].time);
  }
}

// The error test sees the same parameter three times as it sees it once.
TEST(Sensitivities, CostASolveAStepAndNoFactorisation) {
  for (const MethodName method : with_sensitivities) {
    Case run = thrown(method);
    const std::size_t without = record(run).statistics.steps;
    run.directions = directions(run, {"bar.viscosity"});
    const Recording once = record(run);
    run.directions = directions(run, {"bar.viscosity", "bar.viscosity", "bar.viscosity"});
    const Recording thrice = record(run);
    EXPECT_LT(once.statistics.steps, without + without / 10) << name(method);
    EXPECT_EQ(thrice.u, once.u) << name(method);
    EXPECT_EQ(thrice.statistics.steps, once.statistics.steps) << name(method);
    EXPECT_EQ(thrice.statistics.matrix_factorisations, once.statistics.matrix_factorisations) << name(method);
    // One for the motion and one for each parameter.
    EXPECT_EQ(thrice.statistics.linear_solves, 2 * once.statistics.linear_solves) << name(method);
    for (std::size_t k = 1; k < 3; ++k) EXPECT_EQ(thrice.sensitivities[k].u, once.sensitivities[0].u) << name(method);
  }
}

// A flat flight is passed over in a few steps, which say nothing of what waves through it would do.
TEST(Sensitivities, ShortenTheStepsOfAMotionThatDoesNotStirThem) {
  for (const MethodName method : with_sensitivities) {
    Case run = thrown(method);
    run.scene.displacement = [](double) { return 0.0; };
    run.scene.velocity = [](double) { return -1.0; };
    run.scene.left = run.scene.right = EndCondition{};
    run.mass = Mass::consistent;
    const std::size_t without = record(run).statistics.steps;
    Direction kick = direction(run, "bar.density");
    kick.bar.density = 0.0;
    kick.data.velocity = [](double x) { return std::cos(std::numbers::pi * x); };
    run.directions = {kick};
    run.tolerance = {1e-8};
    const Recording with = record(run);
    EXPECT_GT(with.statistics.steps, 2 * without) << name(method);
    // The first mode of the free bar, sampled at its nodes, is one of the elements, too: z'' + eta omega^2 z' + omega^2
    // z = 0, omega^2 = 6 (1 - cos) / (h^2 (2 + cos)) of the consistent mass.
    const double h = 1.0 / 25.0, cosine = std::cos(std::numbers::pi * h);
    const double square = 6.0 * (1.0 - cosine) / (h * h * (2.0 + cosine));
    const double decay = 0.5 * run.scene.bar.viscosity * square, frequency = std::sqrt(square - decay * decay);
    for (std::size_t k = 0; k < with.times.size(); ++k) {
      const double t = with.times[k];
      EXPECT_NEAR(with.sensitivities[0].u[k * with.mesh.nodes()],
                  std::exp(-decay * t) * std::sin(frequency * t) / frequency, 100.0 * run.tolerance.relative)
          << name(method) << " " << t;
    }
  }
}

// Central differences of runs: their error is that of the runs, 100 tolerances over the step, and the step squared.
TEST(Sensitivities, AreTheSlopesOfRunsOnMasslessContactNodesToo) {
  for (const MethodName method : {MethodName::rigid, MethodName::cvode, MethodName::ida, MethodName::arkode})
    for (const double viscosity : {0.05, 0.0}) {
      if (viscosity == 0.0 && method == MethodName::cvode) continue;  // takes no algebraic rows
      Case run = thrown(method);
      run.mass = Mass::redistributed;
      run.scene.bar.viscosity = viscosity;
      run.end = viscosity > 0.0 ? 3.0 : 0.9;
      run.elements = 8;
      run.tolerance = {1e-10};
      run.directions = directions(run, {"bar.modulus", "left.gap"});
      const Recording with = record(run);
      run.directions.clear();
      for (const std::size_t k : {0, 1}) {
        constexpr double step = 1e-4;
        const auto moved = [&](double by) {
          Case other = run;
          if (k == 0) other.scene.bar.modulus += by;
          if (k == 1) std::get<Obstacle>(other.scene.left).gap += by;
          return record(other);
        };
        const Recording more = moved(step), less = moved(-step);
        ASSERT_EQ(more.events.size(), with.events.size());
        double largest = 0.0, worst = 0.0;
        for (std::size_t i = 0; i < with.u.size(); ++i) {
          const double slope = (more.u[i] - less.u[i]) / (2.0 * step);
          largest = std::max(largest, std::abs(slope));
          worst = std::max(worst, std::abs(with.sensitivities[k].u[i] - slope));
        }
        EXPECT_LT(worst, 2e-5 * largest) << name(method) << " " << viscosity << " " << k;
        for (std::size_t i = 0; i < with.events.size(); ++i) {
          const double slope = (more.events[i].time - less.events[i].time) / (2.0 * step);
          EXPECT_NEAR(with.events[i].sensitivities[k].time, slope, 1e-4 * std::max(1.0, std::abs(slope)))
              << name(method) << " " << viscosity << " " << k;
        }
        const double impulse =
            (more.statistics.account->left.impulse - less.statistics.account->left.impulse) / (2.0 * step);
        EXPECT_NEAR(with.statistics.sensitivity->impulse_left[k], impulse, 1e-4 * std::max(1.0, std::abs(impulse)))
            << name(method) << " " << viscosity << " " << k;
      }
    }
}

// A rigid flight against a load that turns it back: u = -t + t^2 / 2 comes to -1/2 at t = 1.
Case turned_back(double gap) {
  Case run;
  run.scene = falling_bar(gap, 1.0, 0.1);
  run.scene.load = SteadyLoad{[](double) { return 1.0; }};
  run.elements = 10;
  run.method = MethodName::rigid;
  run.mass = Mass::consistent;
  run.tolerance = {1e-11};
  run.epsilon = 1e-3;
  run.end = 2.0;
  run.output_every = 0.25;
  return run;
}

TEST(Sensitivities, EndWhereARigidContactGrazes) {
  Case run = turned_back(0.5 - 2e-11);
  run.directions = directions(run, {"left.gap"});
  const Recording found = record(run);
  EXPECT_TRUE(found.events.empty()) << "a contact of no length is none";
  ASSERT_TRUE(found.statistics.sensitivity->lost.has_value());
  EXPECT_NEAR(*found.statistics.sensitivity->lost, 1.0, 1e-5);
  EXPECT_TRUE(std::isnan(found.statistics.sensitivity->impulse_left[0]));
  const std::size_t nodes = found.mesh.nodes();
  for (std::size_t k = 0; k < found.times.size(); ++k)
    EXPECT_EQ(std::isnan(found.sensitivities[0].u[k * nodes]), found.times[k] > *found.statistics.sensitivity->lost);
}

// A bar at rest that is pressed on a rigid obstacle, and pulled off it for a moment.
Case pulled(double pull) {
  Case run;
  run.scene.left = Obstacle{0.0};
  run.scene.displacement = run.scene.velocity = [](double) { return 0.0; };
  run.scene.load =
      GeneralLoad{[pull](double, double t) { return -1.0 + pull * std::exp(-25.0 * (t - 1.0) * (t - 1.0)); }};
  run.scene.bar.viscosity = 0.3;
  run.elements = 8;
  run.method = MethodName::rigid;
  run.mass = Mass::consistent;
  run.tolerance = {1e-10};
  run.end = 2.0;
  run.output_every = 0.1;
  Direction more = direction(run, "bar.density");
  more.bar.density = 0.0;
  more.data.load = GeneralLoad{[](double, double t) { return std::exp(-25.0 * (t - 1.0) * (t - 1.0)); }};
  run.directions = {more};
  return run;
}

// The first pull that opens it, to rounding, opens it where its reaction has a minimum of zero.
TEST(Sensitivities, EndWhereARigidContactOpensByAGraze) {
  double stays = 0.0, opens = 10.0;
  ASSERT_EQ(record(pulled(stays)).events.size(), 1u);
  ASSERT_GT(record(pulled(opens)).events.size(), 1u);
  while (opens - stays > 1e-13) {
    const double middle = 0.5 * (stays + opens);
    (record(pulled(middle)).events.size() > 1 ? opens : stays) = middle;
  }
  const Recording grazes = record(pulled(opens));
  ASSERT_TRUE(grazes.statistics.sensitivity->lost.has_value());
  EXPECT_EQ(*grazes.statistics.sensitivity->lost, grazes.events[1].time);
  EXPECT_EQ(grazes.events[1].change, Change::opening);
  EXPECT_TRUE(std::isnan(grazes.events[1].sensitivities[0].time));
  EXPECT_TRUE(std::isnan(grazes.sensitivities[0].u.back()));
  EXPECT_TRUE(std::isfinite(grazes.sensitivities[0].u[5 * grazes.mesh.nodes()]));
  EXPECT_FALSE(record(pulled(stays)).statistics.sensitivity->lost.has_value());
  // A pull that opens it for good has derivatives: the error of the differences is 1e-8 and 100 tolerances over 1e-4.
  const double pull = 1.5 * opens;
  const Recording found = record(pulled(pull)), more = record(pulled(pull + 1e-4)), less = record(pulled(pull - 1e-4));
  ASSERT_FALSE(found.statistics.sensitivity->lost.has_value());
  ASSERT_GE(found.events.size(), 2u);
  ASSERT_EQ(more.events.size(), found.events.size());
  ASSERT_EQ(less.events.size(), found.events.size());
  for (std::size_t i = 1; i < found.events.size(); ++i) {
    const double slope = (more.events[i].time - less.events[i].time) / 2e-4;
    EXPECT_NEAR(found.events[i].sensitivities[0].time, slope, 2e-4 * std::max(1.0, std::abs(slope))) << i;
  }
}

TEST(Sensitivities, GoOnWhereASpringGrazesButForItsTime) {
  Case run = turned_back(0.5 - 1e-13);
  run.method = MethodName::cvode;
  run.directions = directions(run, {"left.gap"});
  const Recording found = record(run);
  EXPECT_FALSE(found.statistics.sensitivity->lost.has_value());
  ASSERT_FALSE(found.events.empty());
  for (const Event& event : found.events) EXPECT_TRUE(std::isnan(event.sensitivities[0].time));
  for (const double s : found.sensitivities[0].u) EXPECT_TRUE(std::isfinite(s));
}

TEST(Sensitivities, AreThoseBeforeAChangeAtAnOutputTime) {
  Case run = turned_back(0.5);
  run.scene.load.reset();
  run.end = 1.0;
  run.directions = directions(run, {"left.gap", "left.gap"});
  run.directions[1] = direction(run, "bar.density");
  run.directions[1].bar.density = 0.0;
  run.directions[1].data.velocity = [](double) { return 1.0; };
  const Recording found = record(run);
  ASSERT_EQ(found.events.size(), 1u);
  EXPECT_NEAR(found.events[0].time, 0.5, 1e-12);
  EXPECT_NEAR(found.events[0].sensitivities[0].time, 1.0, 1e-10);
  const std::size_t at = 2 * found.mesh.nodes();
  EXPECT_NEAR(found.sensitivities[0].u[at], 0.0, 1e-10);
  EXPECT_NEAR(found.sensitivities[1].u[at], 0.5, 1e-10) << "the flight before the change";
  EXPECT_NEAR(found.sensitivities[0].u[at + found.mesh.nodes()], -1.0, 1e-10);
}

TEST(Sensitivities, OfTwoContactsAtOnceAreMirrorImages) {
  for (const MethodName method : with_sensitivities) {
    Case run = thrown(method);
    run.scene.left = Obstacle{0.1, Side::below};
    run.scene.right = Obstacle{0.1, Side::above};
    run.scene.displacement = [](double) { return 0.0; };
    run.scene.velocity = [](double x) { return 2.0 * x - 1.0; };
    run.directions = directions(run, {"left.gap", "right.gap"});
    const Recording found = record(run);
    ASSERT_GE(found.events.size(), 2u);
    EXPECT_NEAR(found.events[0].time, found.events[1].time, 1e-9);
    ASSERT_FALSE(found.statistics.sensitivity->lost.has_value()) << name(method);
    const std::size_t nodes = found.mesh.nodes();
    double largest = 0.0, worst = 0.0;
    for (std::size_t k = 0; k < found.times.size(); ++k)
      for (std::size_t j = 0; j < nodes; ++j) {
        const double left = found.sensitivities[0].u[k * nodes + j];
        largest = std::max(largest, std::abs(left));
        worst = std::max(worst, std::abs(left + found.sensitivities[1].u[k * nodes + nodes - 1 - j]));
      }
    EXPECT_LT(worst, 1e-4 * largest) << name(method);
  }
}

TEST(Sensitivities, GoOnFromACheckpointBitForBit) {
  for (const MethodName method : with_sensitivities) {
    const Case run = thrown(method);
    const std::vector<Direction> along = directions(run, {"bar.viscosity", "left.gap"});
    const BarSystem system = resolve(run).system();
    const auto go = [&](const std::optional<Checkpoint>& from, std::vector<double>& told,
                        std::optional<Checkpoint>& at) {
      Observers observers;
      observers.directions = along;
      observers.energy = observers.account = true;
      observers.snapshot = [&](const Snapshot& now) {
        for (const FieldSensitivity& s : now.sensitivities) told.push_back(s.u.front());
      };
      Checkpoints& checkpoints = observers.checkpoints.emplace();
      checkpoints.every = 1.0;
      checkpoints.take = [&](const Checkpoint& taken) {
        if (!at) at = taken;
        return RunControl::go_on;
      };
      return from ? simulate(resolve(run), system, *from, observers) : simulate(resolve(run), system, observers);
    };
    std::vector<double> whole, rest;
    std::optional<Checkpoint> first, other;
    const Statistics one = go({}, whole, first);
    const Statistics two = go(first, rest, other);
    ASSERT_LT(rest.size(), whole.size());
    EXPECT_TRUE(std::equal(rest.rbegin(), rest.rend(), whole.rbegin())) << name(method);
    EXPECT_EQ(one.sensitivity->impulse_left, two.sensitivity->impulse_left) << name(method);
  }
}

TEST(Sensitivities, AreRefusedByMethodsThatHaveNone) {
  for (const MethodName method :
       {MethodName::odeint, MethodName::exponential, MethodName::fully_discrete, MethodName::characteristics}) {
    Case run = thrown(method);
    run.mass.reset();
    if (method == MethodName::characteristics) run.scene.bar.viscosity = 0.0;
    run.directions = directions(run, {"bar.modulus"});
    try {
      record(run);
      ADD_FAILURE() << name(method);
    } catch (const Unfit& refused) {
      EXPECT_EQ(refused.finding.key, "sensitivity.of") << name(method);
    }
  }
}

}  // namespace
