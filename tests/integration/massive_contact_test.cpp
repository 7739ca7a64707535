// Contact nodes with mass: `rigid` with restitution, and its two neighbours, the penalty as epsilon -> 0 and scheme
// (2.8) as dt -> 0. docs/fourth-order.md derives what is claimed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "dynamics/impact.hpp"
#include "support/falling_bar.hpp"
#include "support/paper_throw.hpp"
#include "support/run_trace.hpp"
#include "viscobar/integration/integrate.hpp"
#include "viscobar/schemes/schemes.hpp"

namespace viscobar::testing_massive_contact {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr Mass massive[] = {Mass::consistent, Mass::lumped, Mass::paper, Mass::fourth_order};

double largest_difference(const RunTrace& a, const RunTrace& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.times.size(); ++k)
    for (const std::size_t i : {std::size_t{0}, a.u[k].size() - 1})
      largest = std::max(largest, std::abs(a.u[k][i] - b.u[k][i]));
  return largest;
}

class MassiveContact : public testing::TestWithParam<Mass> {};

// On the scene of docs/model.md, to T = 2.4: e = 0 meets twice at each end, e = 0.5 bounces and comes to rest.
TEST_P(MassiveContact, ThePenaltyTendsToRigidLikeTheRootOfEpsilonAndTheSchemeWithItsStep) {
  const BarSystem system(paper_throw(0.1).scene, {1.0, 27}, GetParam());
  const auto times = uniform_times(0.02, 120);
  for (const double e : {0.0, 0.5}) {
    const RunTrace rigid = record(system, times, Rigid{{1e-9, 1e-12}, e});
    const auto penalised = [&](double epsilon) {
      return largest_difference(record(system, times, Arkode{{epsilon, e}, {1e-9, 1e-12}}), rigid);
    };
    const double coarse = penalised(1e-6), fine = penalised(1e-8);
    // The root of 100, and half as much again where one bounce more of e = 0.5 is passed over.
    EXPECT_GT(coarse / fine, 10.0 / 1.5) << name(GetParam()) << " " << e << " " << coarse << " " << fine;
    const auto scheme = [&](double dt) {
      return largest_difference(record(system, times, FullyDiscrete{dt, Start::second_order, e}), rigid);
    };
    const double long_step = scheme(8e-4), short_step = scheme(1e-4);
    // Order one at least: 8; bounces of e = 0.5 fall differently into the steps.
    EXPECT_GT(long_step / short_step, e == 0.0 ? 6.0 : 3.0) << name(GetParam()) << " " << e << " " << long_step;
    EXPECT_LT(short_step, 2e-4);
  }
}

TEST_P(MassiveContact, HoldsItsNodeAtRestWithAReactionThatNeverPulls) {
  const BarSystem system(paper_throw(0.01).scene, {1.0, 27}, GetParam());
  const RunTrace trace = record(system, uniform_times(0.01, 400), Rigid{{1e-9, 1e-12}});
  bool touched = false;
  for (std::size_t k = 0; k < trace.times.size(); ++k) {
    EXPECT_GE(trace.reaction_left[k], 0.0);
    EXPECT_GE(trace.u[k].front(), -0.1 - 100 * 0.25e-9) << "what a run promises";
    if (trace.reaction_left[k] == 0.0) continue;
    touched = true;
    EXPECT_EQ(trace.u[k].front(), -0.1);
    EXPECT_EQ(trace.v[k].front(), 0.0);
  }
  EXPECT_TRUE(touched);
}

// An impact takes (1 - e^2) m w^2 / 2, m the effective mass; nothing else does here, but for what the end rows take.
TEST_P(MassiveContact, AnImpactTakesItsShareOfTheEnergyAndTheAccountCloses) {
  for (const double e : {0.0, 0.4, 1.0}) {
    Scene scene = falling_bar(0.2, 0.7, 0.0);
    const BarSystem system(scene, {1.0, 12}, GetParam());
    const double mass = system.inertia().effective_masses().front();
    const RunTrace first = record(system, std::vector<double>{0.0, 0.2 / 0.7 + 1e-4}, Rigid{{1e-10, 1e-13}, e});
    ASSERT_GE(first.events.size(), 1u);
    EXPECT_NEAR(first.events.front().velocity, -0.7, 1e-8);
    const EnergyAccount& energy = *first.statistics.energy;
    EXPECT_NEAR(energy.dissipated - energy.end_inertia, 0.5 * mass * (1 - e * e) * 0.49, 100 * 1e-10)
        << name(GetParam()) << e;
    const RunTrace all = record(system, uniform_times(0.1, 20), Rigid{{1e-10, 1e-13}, e});
    // 100 times the tolerance, of an energy of a quarter.
    EXPECT_LE(std::abs(all.statistics.energy->balance_error()), 100 * 1e-10) << name(GetParam()) << e;
  }
}

// Without load nothing else changes 1.M v: impacts, and what presses between them, by the rows of every mass.
TEST_P(MassiveContact, TheImpulseOfTheAccountIsTheMomentumThatTheBarGains) {
  Scene scene = falling_bar(0.2, 1.0, 0.1);
  const BarSystem system(scene, {1.0, 12}, GetParam());
  for (const double e : {0.0, 0.5}) {
    std::vector<double> product(system.size());
    double first = 0.0, last = 0.0;
    Observers observers;
    observers.account = true;
    observers.snapshot = [&](const Snapshot& now) {
      system.inertia().matrix().multiply(now.v, product);
      last = 0.0;
      for (const double entry : product) last += entry;
      if (now.time == 0.0) first = last;
    };
    const Statistics done =
        integrate(system, system.initial_state(), uniform_times(3.0, 1), Rigid{{1e-10, 1e-13}, e}, observers);
    ASSERT_GT(done.events, 1u);
    // 100 times the tolerance, of velocities of 1.
    EXPECT_NEAR(done.account->left.impulse, last - first, 100 * 1e-10) << name(GetParam()) << " " << e;
  }
}

// A load presses the bar to its obstacle and pulls it off. R'' is below (3 pi)^2 times its peak, so that samples 1e-3
// apart miss the peak by less than 9 pi^2 1e-6 / 8 of it.
TEST_P(MassiveContact, ThePeakOfTheAccountIsThatOfTheReactionAtFineTimes) {
  Scene scene;
  scene.bar.viscosity = 0.1;
  scene.left = Obstacle{0.0};
  scene.displacement = scene.velocity = [](double) { return 0.0; };
  scene.load = SeparableLoad{[](double x) { return -1.0 - x; }, [](double t) { return std::sin(3.0 * t); }};
  const BarSystem system(scene, {1.0, 12}, GetParam());
  Observers observers;
  observers.account = true;
  double peak = 0.0;
  observers.snapshot = [&](const Snapshot& now) { peak = std::max(peak, now.reaction_left); };
  const Statistics done =
      integrate(system, system.initial_state(), uniform_times(1e-3, 1000), Rigid{{1e-9, 1e-12}}, observers);
  EXPECT_GT(peak, 1.0);
  EXPECT_NEAR(done.account->left.peak_reaction, peak, 1.2e-5 * peak) << name(GetParam());
}

// Rows other than the contact's keep their momentum.
TEST_P(MassiveContact, AnImpactLeavesTheMomentumOfTheOtherRowsAlone) {
  const BarSystem system(paper_throw(0.0).scene, {1.0, 9}, GetParam());
  PenalisedSystem rigid(system, {0.0, 0.3});
  State state = system.initial_state();
  state.u.front() = -0.1;
  state.v.front() = -0.8;
  std::vector<double> before(system.size()), after(system.size());
  system.inertia().matrix().multiply(state.v, before);
  const auto collision = collide(rigid, 0, 0.0, state.u, state.v, {1e-12, 1e-12, 1e-12});
  EXPECT_FALSE(collision.rests);
  EXPECT_NEAR(state.v.front(), 0.3 * 0.8, 4 * eps);
  system.inertia().matrix().multiply(state.v, after);
  for (std::size_t i = 1; i < system.size(); ++i) EXPECT_NEAR(after[i], before[i], 10 * eps);
}

// A closing is found late, at a depth d below the surface, up to which the bar presses the node with m A: thrown back
// is the speed that it had at the surface, sqrt(v^2 - 2 A d), or bounces lower than what a closing is uncertain by keep
// up for ever where e^2 > 1/2.
TEST_P(MassiveContact, DoesNotThrowBackWhatItsNodeGainsByFallingBelowTheSurface) {
  Scene scene;
  scene.left = Obstacle{0.1};
  scene.displacement = [](double) { return -0.1; };
  scene.velocity = [](double) { return -0.3; };
  scene.load = SteadyLoad{[](double) { return -2.0; }};
  const BarSystem system(scene, {1.0, 9}, GetParam());
  const auto leaves_with = [&](double depth) {
    PenalisedSystem rigid(system, {0.0, 0.5});
    State state = system.initial_state();
    state.u.front() = -0.1 - depth;
    collide(rigid, 0, 0.0, state.u, state.v, {0.0, 0.0, 0.0});
    return state.v.front();
  };
  EXPECT_NEAR(leaves_with(0.0), 0.5 * 0.3, 4 * eps);
  // A at the surface; the depth adds its strain, of second order.
  std::vector<double> pressed(9 + 1, 0.0);
  State state = system.initial_state();
  PenalisedSystem open(system, {0.0, 0.5});
  open.force(0.0, state.u, std::vector<double>(system.size(), 0.0), pressed);
  open.accelerate(pressed);
  const double depth = 1e-7;
  EXPECT_NEAR(leaves_with(depth), 0.5 * std::sqrt(0.09 + 2.0 * pressed.front() * depth), 1e-3 * depth);
  EXPECT_LT(leaves_with(depth), leaves_with(0.0) - depth);
}

// The paper's bar with an obstacle at its left end: the other end flies thousands away, so that a tolerance of u is
// higher than the end's first bounce. The bounce is the node's own, and resolved; what is far away does not matter.
TEST_P(MassiveContact, ABounceBesideALargeDisplacementIsTheOneOfThePenaltyAndOfTheScheme) {
  const auto highest = [](double length, const auto& method) {
    Scene scene;
    scene.bar = {length, 1.0, 1.0, 1.0};
    scene.left = Obstacle{1.0};
    scene.displacement = scene.velocity = [](double x) { return x * (1.0 - x); };
    const BarSystem system(scene, {length, static_cast<std::size_t>(9.0 * length)}, GetParam());
    std::vector<double> times = uniform_times(1e-4, 1200, 1.05);  // from before the impact on
    times.insert(times.begin(), 0.0);
    const RunTrace run = record(system, times, method, false);
    double largest = 0.0;
    bool touched = false;
    for (std::size_t k = 1; k < times.size(); ++k) {
      touched |= !run.events.empty() && times[k] > run.events.front().time;
      if (touched) largest = std::max(largest, run.u[k].front() + 1.0);
    }
    return largest;
  };
  for (const double e : {0.5, 1.0}) {
    const double soft = highest(26.0, Arkode{{1e-6, e}, {1e-10}}), stiff = highest(26.0, Arkode{{1e-8, e}, {1e-10}});
    const double coarse = highest(26.0, FullyDiscrete{1e-5, Start::second_order, e}),
                 fine = highest(26.0, FullyDiscrete{2e-6, Start::second_order, e});
    for (const double length : {26.0, 60.0})
      for (const double tolerance : {1e-6, 1e-11}) {
        const double rigid = highest(length, Rigid{{tolerance}, e});
        // The penalty tends there like the root of epsilon, and half as much again for what is not yet of that power.
        EXPECT_NEAR(rigid, stiff, 1.5 * std::abs(stiff - soft) / 9.0) << name(GetParam()) << e << " " << tolerance;
        // The scheme at first order: of a fifth of the step the error is less than its change.
        EXPECT_NEAR(rigid, fine, std::abs(fine - coarse)) << name(GetParam()) << e << " " << tolerance;
      }
  }
}

// A bar that falls on its end and stays there: its bounces accumulate, and are not counted out.
TEST_P(MassiveContact, BouncesThatAccumulateEndInRest) {
  Scene scene = falling_bar(0.1, 0.3, 0.5);
  scene.load = SteadyLoad{[](double) { return -2.0; }};
  const BarSystem system(scene, {1.0, 12}, GetParam());
  for (const ErrorControl control : {ErrorControl::global, ErrorControl::local})
    for (const double e : {0.3, 0.8, 0.95}) {
      const RunTrace trace = record(system, std::vector<double>{0.0, 30.0}, Rigid{{1e-8, 1e-11, control}, e});
      ASSERT_FALSE(trace.events.empty());
      EXPECT_EQ(trace.events.back().change, Change::closing);
      EXPECT_LT(trace.events.size(), 600u) << name(GetParam()) << " " << e;
      // It stands on its load, once its slowest mode has died out: e^(-0.6 t).
      const double weight = GetParam() == Mass::paper ? 2.0 * (1.0 + 1.0 / 12) : 2.0;
      EXPECT_NEAR(trace.reaction_left.back(), weight, 1e-5) << name(GetParam()) << " " << e;
    }
}

INSTANTIATE_TEST_SUITE_P(Masses, MassiveContact, testing::ValuesIn(massive),
                         [](const auto& test) { return std::string(name(test.param)); });

// At loose tolerances a step passes over the spring: the reaction that is left of an impact in it could have either
// sign, and a contact that then toggled was held for ever. Without rebound the penalty has the contacts of `rigid`.
struct LooseThrow {
  double viscosity, gap;
  bool right;
  std::size_t elements;
  Mass mass;
  SpaceFunction displacement, velocity;
  std::function<double(double)> load;
  double end, tolerance;
};

std::vector<LooseThrow> loose_throws() {
  const auto rest = [](double) { return 0.0; };
  const auto cosine = [](double x) { return -0.7 * std::cos(2.0 * x); };
  const auto pushes = [](double t) { return std::sin(3.0 * t); };
  const auto falls = [](double t) { return -0.4 * std::cos(t); };
  return {{0.0, 0.1262, false, 5, Mass::consistent, rest, cosine, pushes, 3.685, 1e-2},
          {0.20671, 0.023, true, 13, Mass::consistent, rest, cosine, pushes, 2.083, 5e-3},
          {0.0049711, 0.1331, true, 3, Mass::fourth_order, [](double x) { return 0.2 * x * (1.0 - x); },
           [](double x) { return -0.5 - 0.4 * x; }, rest, 4.544, 1e-2},
          {17.396, 0.03, true, 3, Mass::fourth_order, [](double x) { return 0.015 * std::cos(3.0 * x); },
           [](double x) { return -1.0 + 0.6 * x; }, rest, 3.927, 1e-2},
          {0.0023536, 0.045, true, 8, Mass::fourth_order, rest, [](double) { return -1.0; }, falls, 2.269, 1e-2}};
}

void expect_contacts_that_last(const RunTrace& trace, const char* method) {
  double last = -1.0;
  for (const Event& event : trace.events) {
    EXPECT_GT(event.time, last) << method << ": a contact of no length";
    last = event.time;
    const double outwards = event.change == Change::opening ? event.velocity : -event.velocity;
    EXPECT_GE(outwards, -1e-15) << method << " at t = " << event.time;
  }
}

TEST(LooseTolerance, NeitherHoldsAPenalisedContactNorTellsContactsOfNoLength) {
  for (const LooseThrow& one : loose_throws()) {
    SCOPED_TRACE(one.viscosity);
    Scene scene;
    scene.bar.viscosity = one.viscosity;
    (one.right ? scene.right : scene.left) = Obstacle{one.gap};
    scene.displacement = one.displacement;
    scene.velocity = one.velocity;
    scene.load = SeparableLoad{[](double) { return 1.0; }, one.load};
    const BarSystem system(scene, {1.0, one.elements}, one.mass);
    const auto times = uniform_times(one.end / 50.0, 50);
    const RunTrace rigid = record(system, times, Rigid{{1e-9}, 0.0});
    double size = 0.0;
    for (const auto& u : rigid.u) size = std::max({size, std::abs(u.front()), std::abs(u.back())});
    const RunTrace arkode = record(system, times, Arkode{{1e-8, 0.0}, {one.tolerance}});
    const RunTrace cvode = record(system, times, Cvode{{1e-8, 0.0}, {one.tolerance}});
    // Ten times what was asked for; a contact that is held is off by 0.7 and more.
    EXPECT_LT(largest_difference(arkode, rigid), 10.0 * one.tolerance * size) << one.gap;
    EXPECT_LT(largest_difference(cvode, rigid), 10.0 * one.tolerance * size) << one.gap;
    expect_contacts_that_last(arkode, "arkode");
    expect_contacts_that_last(cvode, "cvode");
  }
}

TEST(RigidWithMass, RefusesASpanObstacle) {
  Scene scene = paper_throw(0.0).scene;
  scene.span = Obstacle{0.2};
  const BarSystem system(scene, {1.0, 9}, Mass::consistent);
  EXPECT_THROW(record(system, uniform_times(0.1, 2), Rigid{}), std::invalid_argument);
}

}  // namespace
}  // namespace viscobar::testing_massive_contact
