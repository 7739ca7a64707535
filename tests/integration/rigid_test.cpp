#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include "support/falling_bar.hpp"
#include "support/paper_throw.hpp"
#include "support/run_trace.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/integration/integrate.hpp"
#include "viscobar/studies/exact/exact_solutions.hpp"

namespace viscobar::testing_rigid {
namespace {

const Tolerance tight{1e-9, 1e-12};

RunTrace run(const Scene& scene, std::size_t elements, std::span<const double> times, Tolerance tolerance = tight) {
  const BarSystem system(scene, {scene.bar.length, elements}, Mass::redistributed);
  return record(system, times, Rigid{tolerance});
}

// Unstrained, at rest on its obstacles or in flight, under a uniform load.
Scene under_load(double viscosity, double gap, double speed, double load) {
  Scene scene = falling_bar(gap, speed, viscosity);
  scene.load = SteadyLoad{[load](double) { return load; }};
  return scene;
}

class RigidByViscosity : public testing::TestWithParam<double> {};

TEST_P(RigidByViscosity, HoldsAClosedNodeAtItsObstacleWithAReactionThatNeverPulls) {
  const std::vector<double> times = uniform_times(6.0 / 997, 997);
  const RunTrace trace = run(paper_throw(GetParam()).scene, 27, times);
  ASSERT_GE(trace.events.size(), 2u);
  for (std::size_t k = 0; k < times.size(); ++k) {
    for (const auto& [u, reaction] : {std::pair{trace.u[k].front(), trace.reaction_left[k]},
                                      std::pair{trace.u[k].back(), trace.reaction_right[k]}}) {
      EXPECT_GE(reaction, 0.0);
      // 100 times the tolerance is what a run keeps; a held node is held exactly.
      EXPECT_GE(u, -0.1 - 100 * 0.25e-9);
      if (reaction > 0.0) {
        EXPECT_EQ(u, -0.1);
      }
    }
  }
}

TEST_P(RigidByViscosity, MovesAMirrorSymmetricBarSymmetricallyWithBothEndsAtTheSameInstants) {
  const std::vector<double> times = uniform_times(0.05, 120);
  const RunTrace trace = run(paper_throw(GetParam()).scene, 27, times);
  ASSERT_EQ(trace.events.size() % 2, 0u);
  for (std::size_t i = 0; i < trace.events.size(); i += 2) {
    const Event &one = trace.events[i], &other = trace.events[i + 1];
    EXPECT_NE(one.where, other.where);
    EXPECT_EQ(one.change, other.change);
    EXPECT_NEAR(one.time, other.time, 100 * 1e-9) << "the shift of an event by the error of a run";
  }
  for (const auto& u : trace.u)
    for (std::size_t i = 0; i < u.size(); ++i) EXPECT_NEAR(u[i], u[u.size() - 1 - i], 100 * 0.25e-9);
}

TEST_P(RigidByViscosity, TheImpulseOfTheReactionsIsTheGainOfMomentum) {
  constexpr std::size_t intervals = 24000;
  constexpr double every = 6.0 / intervals;
  const Scene scene = paper_throw(GetParam()).scene;
  const BarSystem system(scene, {1.0, 27}, Mass::redistributed);
  const RunTrace trace = run(scene, 27, uniform_times(every, intervals));
  const auto momentum = [&](const std::vector<double>& v) {
    std::vector<double> inertia(v.size());
    system.inertia().matrix().multiply(v, inertia);
    return std::accumulate(inertia.begin(), inertia.end(), 0.0);
  };
  double impulse = 0.0, strongest = 0.0;
  for (std::size_t k = 0; k < intervals; ++k) {
    const double before = trace.reaction_left[k] + trace.reaction_right[k];
    const double after = trace.reaction_left[k + 1] + trace.reaction_right[k + 1];
    impulse += every / 2 * (before + after);
    strongest = std::max(strongest, after);
    // The trapezoidal rule may be wrong by half the jump times the interval at each change, and by O(every^2) between.
    EXPECT_NEAR(impulse, momentum(trace.v[k + 1]) - momentum(trace.v[0]),
                static_cast<double>(trace.events.size()) * every * std::max(strongest, 0.1));
  }
  EXPECT_GT(impulse, 0.1);
}

TEST_P(RigidByViscosity, ABarAtRestOnItsObstacleStaysAndCarriesItsWeight) {
  const std::vector<double> times = uniform_times(0.5, 100);
  // Compressed by its own weight 1, the solution of E u'' = 1 with u(0) = -gap and a free end.
  Scene scene = under_load(GetParam(), 0.1, 0.0, -1.0);
  scene.displacement = [](double x) { return -0.1 - x + x * x / 2; };
  const RunTrace trace = run(scene, 16, times);
  ASSERT_EQ(trace.events.size(), 1u);
  EXPECT_EQ(trace.events[0].change, Change::closing);
  for (std::size_t k = 0; k < times.size(); ++k) {
    EXPECT_NEAR(trace.reaction_left[k], 1.0, 1e-6) << times[k];
    for (std::size_t i = 0; i < trace.u[k].size(); ++i) EXPECT_NEAR(trace.u[k][i], trace.u[0][i], 100e-9);
  }
}

// One end keeps its mass, by what is fixed to it, and has impacts; the other one has none.
// A penalty of 1e-9 is off by its depth, epsilon R, R some 100 as an end strikes.
TEST_P(RigidByViscosity, AnEndWithMassStrikesBesideOneWithout) {
  const std::vector<double> times = uniform_times(0.05, 60);
  for (const bool right : {false, true})
    for (const EndInput& own : {EndInput{.stiffness = 1.0}, EndInput{.dashpot = 0.5}, EndInput{.mass = 0.3}})
      for (const Mass mass : {Mass::redistributed, Mass::paper}) {
        Scene scene = under_load(GetParam(), 0.1, 1.0, 0.0);
        scene.left = scene.right = Obstacle{0.1};
        (right ? scene.right_input : scene.left_input) = own;
        const BarSystem system(scene, {1.0, 16}, mass);
        const RunTrace rigid = record(system, times, Rigid{tight});
        const RunTrace truth = record(system, times, Exponential{Penalty{1e-9, 0.0}});
        ASSERT_GE(rigid.events.size(), 3u);
        for (std::size_t k = 0; k < times.size(); ++k)
          for (std::size_t i = 0; i < rigid.u[k].size(); ++i)
            EXPECT_NEAR(rigid.u[k][i], truth.u[k][i], 1e-6) << right << name(mass) << times[k];
      }
}

TEST_P(RigidByViscosity, AFlightThatOnlyTouchesGoesOnAsIfNothingWereThere) {
  // About u = -t + t^2, with what the massless node does to it; the far obstacle shows how deep the end dips.
  const std::vector<double> times = uniform_times(1e-3, 1000);
  const RunTrace far = run(under_load(GetParam(), 10.0, 1.0, 2.0), 8, times);
  const auto deepest =
      std::min_element(far.u.begin(), far.u.end(), [](const auto& a, const auto& b) { return a.front() < b.front(); });
  ASSERT_EQ(far.events.size(), 0u);
  // The vertex of the parabola through the three lowest values.
  const double before = (deepest - 1)->front(), at = deepest->front(), after = (deepest + 1)->front();
  const double dip = at - (after - before) * (after - before) / (8 * (after - 2 * at + before));
  for (const double clearance : {1e-6, 1e-9, 0.0, -1e-9, -1e-8}) {
    const RunTrace trace = run(under_load(GetParam(), -dip + clearance, 1.0, 2.0), 8, times);
    EXPECT_TRUE(trace.statistics.completed);
    EXPECT_EQ(trace.events.size() % 2, 0u) << "what closes opens";
    EXPECT_LE(trace.events.size(), clearance > 1e-7 ? 0u : 2u);
    for (std::size_t k = 0; k < times.size(); ++k)
      EXPECT_NEAR(trace.u[k].front(), far.u[k].front(), 100e-9 + 10 * std::max(0.0, -clearance))
          << clearance << " " << times[k];
  }
}

TEST_P(RigidByViscosity, TheSmallestMeshesRun) {
  const std::vector<double> times = uniform_times(0.1, 60);
  const RunTrace two_ends = run(paper_throw(GetParam()).scene, 3, times);
  EXPECT_TRUE(two_ends.statistics.completed);
  Scene one_end = paper_throw(GetParam()).scene;
  one_end.right = Free{};
  for (const std::size_t elements : {std::size_t{2}, std::size_t{3}})
    EXPECT_TRUE(run(one_end, elements, times).statistics.completed);
}

TEST_P(RigidByViscosity, KeepsTheBalanceOfEnergy) {
  const RunTrace trace = run(paper_throw(GetParam()).scene, 27, uniform_times(1.0, 6));
  const EnergyAccount& energy = trace.statistics.energy.value();
  // An impact of a massless node costs no energy: only what viscosity takes is missing.
  EXPECT_NEAR(energy.balance_error(), 0.0, 1000 * 1e-9 * energy.initial);
  EXPECT_EQ(energy.dissipated > 0.0, GetParam() > 0.0);
}

INSTANTIATE_TEST_SUITE_P(Viscosities, RigidByViscosity, testing::Values(0.0, 0.01, 1.0));

// A bar that its load presses on the obstacle and then draws off it: R falls by about 0.01 a unit of time.
class RigidOpening : public testing::TestWithParam<Mass> {};

TEST_P(RigidOpening, IsInTimeOnAnyMeshAtALooseTolerance) {
  Scene scene = under_load(0.1, 0.0, 0.0, 0.0);
  scene.load = SeparableLoad{[](double) { return 0.01; }, [](double t) { return t - 1.0; }};
  constexpr double loose = 1e-4;
  for (const std::size_t elements : {std::size_t{10}, std::size_t{100}, std::size_t{1000}}) {
    SCOPED_TRACE(elements);
    const BarSystem system(scene, {1.0, elements}, GetParam());
    const auto opening = [&](double tolerance) {
      const RunTrace trace = record(system, std::vector{0.0, 2.5}, Rigid{{tolerance, 1e-3 * tolerance}});
      EXPECT_EQ(trace.events.size(), 2u) << "closed at the start, opened once";
      return trace.events.back().time;
    };
    // A reaction that is wrong by R is a displacement that is wrong by R L/E, which may be 100 tolerances of u = 0.005.
    EXPECT_NEAR(opening(loose), opening(tight.relative), 100.0 * loose * 0.005 / 0.01);
  }
}

INSTANTIATE_TEST_SUITE_P(Masses, RigidOpening,
                         testing::Values(Mass::redistributed, Mass::lumped, Mass::consistent, Mass::fourth_order),
                         [](const auto& mass) { return std::string(name(mass.param)); });

TEST(Rigid, ABarThatComesToRestDoesNotToggleItsContacts) {
  // With eta = 1 the throw dies out against both obstacles, the reactions with it.
  const RunTrace trace = run(paper_throw(1.0).scene, 27, uniform_times(10.0, 20));
  EXPECT_LE(trace.events.size(), 4u);
  EXPECT_LT(trace.statistics.steps, 20000u);
}

// A node that the strained element behind it pulls off at once, until the wave of the impact is through that: the bar
// itself, whose end moves by -t + t^2 / 10, stays where it touches.
TEST(Rigid, AContactBeginsWithTheFirstStrikeOfItsNode) {
  Scene stretched;
  stretched.left = Obstacle{0.1};
  stretched.displacement = [](double) { return 0.0; };
  stretched.velocity = [](double x) { return -1.0 + 0.2 * x; };
  const double touches = 5.0 - std::sqrt(24.0);
  double errors[2];
  for (const std::size_t level : {std::size_t{0}, std::size_t{1}}) {
    const RunTrace trace = record(BarSystem(stretched, {1.0, std::size_t{40} << level}, Mass::fourth_order),
                                  std::vector{0.0, 0.4}, Rigid{{1e-9, 1e-12}});
    ASSERT_EQ(trace.events.size(), 1u);
    errors[level] = std::abs(trace.events[0].time - touches);
    EXPECT_NEAR(trace.events[0].velocity, -1.0 + 0.2 * touches, 1e-3);
  }
  EXPECT_LT(errors[0], 1e-5);  // 1.5e-6
  EXPECT_LT(errors[1], 0.25 * errors[0]);
}

// The bar pulls its node off the obstacle at once: a closing and an opening of one time, where the bar itself comes no
// nearer than 1.6e-4, or stays.
TEST(Rigid, HasNoContactOfZeroLength) {
  Scene graze;
  graze.bar.viscosity = 0.0244;
  graze.left = Obstacle{0.2249};
  graze.displacement = [](double x) { return 0.256 * std::abs(x - 0.569); };
  graze.velocity = [](double) { return -0.73; };
  graze.load = SteadyLoad{[](double) { return 1.05; }};
  const auto run_on = [](const Scene& scene, std::size_t elements, double end) {
    return record(BarSystem(scene, {1.0, elements}, Mass::fourth_order), std::vector{0.0, end}, Rigid{{1e-6, 1e-9}});
  };
  EXPECT_TRUE(run_on(graze, 16, 1.112).events.empty());

  const Case shaken = parse_scene(R"toml(
[bar]
length = 1.0
viscosity = 1e-4
[left]
kind = "fixed"
motion = "0.1*sin(3*t)"
[right]
kind = "obstacle"
gap = 0.05
side = "above"
[time]
end = 6.0
[mesh]
elements = 100
[output]
every = 6.0
)toml",
                                  "shaken.toml")
                          .run;
  const Recording trace = record(shaken);
  EXPECT_EQ(std::ranges::count(trace.events, Change::closing, &Event::change), 3);
  EXPECT_NEAR(trace.statistics.energy->balance_error(), 0.0, 200 * 1e-6 * trace.statistics.energy->work);
}

// In one step the reaction pulls from t = 1.2 on and pushes again before the end of the step, more than it has pulled.
TEST(Rigid, APullThatTurnsWithinALongStepOpensTheContact) {
  Scene scene = under_load(0.1, 0.02, 0.0, -0.5);
  scene.right = Fixed{};
  scene.velocity = [](double x) { return -std::cos(std::numbers::pi * x / 2.0); };
  for (const double tolerance : {1e-2, 1e-3, tight.relative}) {
    SCOPED_TRACE(tolerance);
    const RunTrace trace = run(scene, 20, std::vector{0.0, 4.0}, {tolerance, 1e-3 * tolerance});
    ASSERT_EQ(trace.events.size(), 3u);
    EXPECT_NEAR(trace.events[1].time, 1.2, 0.05);
  }
}

// A step as long as the run would leave its matrix no digit of the inertia; one of 1e6 ways of a wave does.
TEST(Rigid, RunsAsLongAsItIsAskedTo) {
  Scene scene;
  scene.bar.viscosity = 0.01;
  scene.left = Obstacle{0.1};
  scene.displacement = [](double x) { return x * (1.0 - x); };
  scene.velocity = [](double) { return 0.0; };
  const RunTrace run = record(BarSystem(scene, {1.0, 27}, Mass::fourth_order), std::vector{0.0, 1e9}, Rigid{});
  EXPECT_EQ(run.statistics.reached_time, 1e9);
  EXPECT_LT(run.statistics.steps, 2000u);
}

// The front of the kink, which stops the left end, arrives at t = 2.6.
TEST(Rigid, AKinkOfWhatMovesTheOtherEndOpensNoContact) {
  for (const double viscosity : {0.0, 0.2}) {
    const Recording trace =
        record(parse_scene(fmt::format("bar.length = 1.0\nbar.viscosity = {}\nleft.kind = \"fixed\"\n"
                                       "left.motion = \"0.02*min(t, 1.6)\"\nright.kind = \"obstacle\"\n"
                                       "right.side = \"above\"\nright.gap = 0.0\nload.density = 0.5\ntime.end = 2.5\n"
                                       "method.name = \"rigid\"\n",
                                       viscosity),
                           "scene")
                   .run);
    EXPECT_EQ(trace.events.size(), 1u) << viscosity;
  }
}

TEST(Rigid, FollowsTheGrazingContactsOfTheManufacturedSolutionOneByOne) {
  for (const bool both : {false, true}) {
    exact::ManufacturedContact contact;
    if (both) contact.right = contact.left;
    const RunTrace trace = run(contact.scene(), 200, uniform_times(0.01, 250));
    const std::vector<Event> changes = contact.changes(2.5);
    ASSERT_EQ(trace.events.size(), changes.size()) << both;
    for (std::size_t i = 0; i < changes.size(); ++i) {
      EXPECT_EQ(trace.events[i].change, changes[i].change);
      // The opening s_+^3 is cubic at a change and the reaction quadratic: an error O(h^2) moves it by at most its
      // cube root.
      EXPECT_NEAR(trace.events[i].time, changes[i].time, std::cbrt(1.0 / (200.0 * 200.0))) << i;
    }
  }
}

TEST(Rigid, AnElasticImpactLastsTheTransitThereAndBackAndGivesTheSpeedBack) {
  exact::ElasticImpact impact;
  for (const std::size_t elements : {std::size_t{50}, std::size_t{400}}) {
    const RunTrace trace = run(impact.scene(), elements, uniform_times(0.05, 60));
    // Dispersion smears a front over h^(2/3) and lets the reaction touch zero before it is back for good.
    const double smear = std::pow(1.0 / static_cast<double>(elements), 2.0 / 3.0);
    ASSERT_GE(trace.events.size(), 2u);
    EXPECT_NEAR(trace.events.front().time, impact.closing(), 1e-7);
    EXPECT_NEAR(trace.events.back().time, impact.opening(), 4 * smear);
    const auto& v = trace.v.back();
    EXPECT_NEAR(std::accumulate(v.begin() + 1, v.end() - 1, 0.0) / static_cast<double>(v.size() - 2), impact.speed,
                2 * smear);
  }
}

}  // namespace
}  // namespace viscobar::testing_rigid
