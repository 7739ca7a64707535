// Cost of a stiff contact: the steps follow the motion, not the penalty or the mesh.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/absolute_tolerance.hpp"
#include "support/falling_bar.hpp"
#include "support/paper_throw.hpp"
#include "support/run_trace.hpp"
#include "viscobar/case/end_traces.hpp"
#include "viscobar/case/recording.hpp"

namespace viscobar::testing_stiff_contact {
namespace {

std::size_t steps(MethodName method, std::size_t elements, double epsilon, Tolerance tolerance) {
  Case run = paper_throw(1.0);
  run.mass = Mass::redistributed;
  run.method = method;
  run.elements = elements;
  run.epsilon = epsilon;
  run.tolerance = tolerance;
  const Statistics statistics = trace_ends(run, std::vector{0.0, run.end}).statistics;
  EXPECT_EQ(statistics.events, 2u) << elements << " " << epsilon;
  return statistics.steps;
}

class StiffContact : public testing::TestWithParam<MethodName> {};

TEST_P(StiffContact, CostsNoMoreStepsAtAStifferPenalty) {
  for (const double relative : {1e-6, 1e-8}) {
    const Tolerance tolerance{relative, 1e-3 * relative};
    const std::size_t soft = steps(GetParam(), 54, 1e-3, tolerance);
    for (const double epsilon : {1e-5, 1e-8, 1e-11})
      EXPECT_LT(steps(GetParam(), 54, epsilon, tolerance), 2 * soft) << relative << " " << epsilon;
  }
}

// A unit of rounding of u at the contact is, through viscosity, a velocity of eta / (rho h^2) units beside it: far more
// than 1e-10 on the finer mesh. An error test that saw it would shrink the step to that of the rounding.
TEST_P(StiffContact, DoesNotChaseTheRoundingOfAClosedContactOnAFineMesh) {
  const Tolerance tolerance{1e-10, 1e-13};
  EXPECT_LT(steps(GetParam(), 432, 1e-10, tolerance), 10 * steps(GetParam(), 27, 1e-10, tolerance));
}

// A bar pressed on its obstacle by a steady load, from its equilibrium but for the penetration.
Case pressed(double epsilon, Mass mass, MethodName method) {
  Case run;
  run.scene.bar = {1.0, 1.0, 1.0, 0.3};
  run.scene.left = Obstacle{0.0};
  run.scene.displacement = run.scene.velocity = [](double) { return 0.0; };
  run.scene.load = SteadyLoad{[](double) { return -1.0; }};
  run.elements = 8;
  run.mass = mass;
  run.epsilon = epsilon;
  run.end = 2.0;
  run.output_every = 0.025;
  run.method = method;
  run.tolerance.absolute = 1e-9;
  return run;
}

// The oscillation of a contact that comes to rest has to be followed until it is smaller than what is promised, and is
// passed over from then on: here a tenth of the run. Following it to the end takes a dozen steps a period.
TEST_P(StiffContact, AMassiveContactThatComesToRestIsFollowedOnlyWhileItsOscillationIsLargerThanTheTolerance) {
  for (const double epsilon : {1e-8, 1e-10, 1e-12}) {
    const Case run = pressed(epsilon, Mass::consistent, GetParam());
    const double mass = resolve(run).system().inertia().matrix().diagonal[0];
    const double periods = run.end / (2.0 * std::numbers::pi * std::sqrt(epsilon * mass));
    EXPECT_LT(static_cast<double>(record(run).statistics.steps), 12.0 * periods / 5.0) << epsilon;
  }
}

TEST(StiffContactAtRest, IsFollowedToTheEndByFormulasThatWereAskedFor) {
  Case run = pressed(1e-8, Mass::consistent, MethodName::cvode);
  const std::size_t steps = record(run).statistics.steps;
  for (const Formulas formulas : {Formulas::adams, Formulas::bdf}) {
    run.formulas = formulas;
    EXPECT_GT(record(run).statistics.steps, 4 * steps);
  }
}

// After an impact the multistep method begins again with short steps, which says nothing of the leg.
TEST(StiffContactOnAFineMesh, IsLeftToBackwardDifferentiationWhereALegTakesLessThanAThousandSteps) {
  Case run = pressed(1e-4, Mass::lumped, MethodName::cvode);
  run.scene.left = Obstacle{0.1};
  run.scene.velocity = [](double) { return -1.0; };
  run.elements = 1000;
  const Recording automatic = record(run);
  ASSERT_EQ(automatic.events.size(), 1u);
  ASSERT_LT(automatic.statistics.steps, 1000u);
  run.formulas = Formulas::bdf;  // and no other
  EXPECT_EQ(automatic.u, record(run).u);
}

// The steps of backward differentiation at a tight tolerance are no longer than the time in which the fastest modes of
// the mesh die out, for which Adams' formulas are stable; of a stiff contact's spring in less tight ones, too.
TEST(OverdampedMesh, IsLeftToAdamsFormulasWhereTheToleranceAsksForShortSteps) {
  struct Kind {
    double viscosity, epsilon, tolerance;
    std::size_t elements;
    Mass mass;
    bool adams;
  };
  for (const Kind& kind :
       {Kind{0.03, 1e-2, 1e-10, 27, Mass::fourth_order, true}, Kind{0.1, 1e-4, 1e-8, 27, Mass::fourth_order, true},
        Kind{0.1, 1e-4, 1e-8, 10, Mass::consistent, true}, Kind{0.03, 1e-4, 1e-10, 54, Mass::fourth_order, true},
        Kind{1.0, 1e-4, 1e-8, 27, Mass::lumped, false}, Kind{0.3, 1e-2, 1e-6, 54, Mass::consistent, false}}) {
    Case run = paper_throw(kind.viscosity);
    run.method = MethodName::cvode;
    run.elements = kind.elements, run.mass = kind.mass, run.epsilon = kind.epsilon, run.tolerance = {kind.tolerance};
    const auto automatic = static_cast<double>(record(run).statistics.steps);
    run.formulas = Formulas::bdf;
    const auto of_bdf = static_cast<double>(record(run).statistics.steps);
    if (kind.adams)
      EXPECT_LT(automatic, 0.85 * of_bdf) << kind.viscosity << " " << kind.elements;
    else
      EXPECT_EQ(automatic, of_bdf) << kind.viscosity << " " << kind.elements;
  }
}

// The massless node is drawn to its equilibrium within 1e-8 units of time, in which the bar does not move; the
// acceleration with which the leg begins belongs to those.
TEST(StiffContactStart, IsInterpolatedLikeAnyOtherStepByOneStepMethods) {
  Case run = pressed(1e-8, Mass::redistributed, MethodName::exponential);
  run.scene.displacement = [](double x) { return -x + x * x / 2; };
  const Recording reference = record(run);
  for (const MethodName method : {MethodName::arkode, MethodName::odeint}) {
    run.method = method;
    const Recording result = record(run);
    ASSERT_EQ(result.u.size(), reference.u.size());
    for (std::size_t i = 0; i < result.u.size(); ++i)  // max|u| = 1/2
      ASSERT_NEAR(result.u[i], reference.u[i], 100 * (0.5 * run.tolerance.relative + absolute_tolerance(run)))
          << name(method) << " at t = " << result.times[i / result.mesh.nodes()];
  }
}

// The reaction of so stiff a contact is not what rounding leaves of the penetration: a unit of rounding of u = 0.1 is a
// force of 0.001 at epsilon = 1e-14, and an opening that waits for the clearance to pass its rounding is held back by
// a hundred times as much. From 1e-18 on the spring is rigid to rounding.
class StiffMasslessContact : public testing::TestWithParam<MethodName> {};

TEST_P(StiffMasslessContact, TendsToTheRigidObstacleDownToEveryEpsilon) {
  for (const double viscosity : {0.01, 30.0, 1000.0}) {
    Case run = paper_throw(viscosity);
    run.mass = Mass::redistributed;
    run.tolerance = {1e-7, 1e-10};
    run.method = MethodName::rigid;
    const std::vector<double> times = comparison_times(run.end, 600, contact_changes(run));
    const EndTraces rigid = trace_ends(run, times);
    run.method = GetParam();
    for (const double epsilon : {1e-10, 1e-12, 1e-14, 1e-30}) {
      run.epsilon = epsilon;
      const EndTraces spring = trace_ends(run, times);
      // Odeint's velocity of the node is the rounding of its penetration times the spring: it may open and close again.
      if (GetParam() != MethodName::odeint) {
        EXPECT_EQ(spring.events.size(), rigid.events.size()) << viscosity << " " << epsilon;
      }
      // The promise of both, for displacements up to 0.3; a gap that is wrong by d moves the bar by d, each change by
      // twice that.
      const double changes = static_cast<double>(rigid.events.size());
      const double bound = 2 * 100 * (0.3 * 1e-7 + 1e-10) + (1 + 2 * changes) * spring.statistics.max_penetration;
      EXPECT_LT(largest_difference(spring, rigid), bound) << viscosity << " " << epsilon;
    }
  }
}

// A pull of (h/E) R = eta/E times the tolerance of the velocities never came, and the bar clung to its obstacle for
// ever: at viscosity 12 and 1e-6 u_left stayed at -0.1 instead of -0.0908. `rigid` on the same mass is the truth: a
// spring of kappa = k h / E follows its row by eta / (E kappa), below 1e-8 here.
TEST_P(StiffMasslessContact, OpensInTimeAtEveryViscosityAndTolerance) {
  for (const double viscosity : {0.1, 2.0, 12.0, 50.0}) {
    const double scale = std::max(1.0, viscosity);  // of time: a transit, or eta / E
    Case run;
    run.scene = falling_bar(0.1, 1.0, viscosity);
    run.elements = 40;
    run.mass = Mass::redistributed;
    run.end = 3.0 * scale;
    run.output_every = run.end;
    run.method = MethodName::rigid;
    run.tolerance = {1e-9, 1e-12};
    const Recording truth = record(run);
    ASSERT_EQ(truth.events.size(), 2u) << viscosity;
    run.epsilon = 1e-10;
    run.method = GetParam();
    for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
      run.tolerance = {tolerance, 1e-3 * tolerance};
      const Recording spring = record(run);
      const Event& last = spring.events.back();
      EXPECT_EQ(last.change, Change::opening) << viscosity << " " << tolerance;
      EXPECT_GT(last.velocity, 0.0) << viscosity << " " << tolerance;
      // The promise, 100 tolerances of the time scale and of what is moved.
      EXPECT_NEAR(last.time, truth.events.back().time, 100.0 * tolerance * scale) << viscosity << " " << tolerance;
      const double largest = std::max(0.1, std::abs(truth.displacement(1).front()));
      EXPECT_NEAR(spring.displacement(1).front(), truth.displacement(1).front(), 100.0 * tolerance * largest)
          << viscosity << " " << tolerance;
      if (tolerance <= 1e-4) {
        EXPECT_EQ(spring.events.size(), 2u) << viscosity << " " << tolerance;
      }
    }
  }
}

// It was found where the depth's own error had a zero, at a velocity into the obstacle, and closed again at once: 36
// changes at a tolerance of 1e-5.
TEST(StiffMasslessContact, DoesNotOpenWhileItsRowPushes) {
  Case run;
  run.scene = falling_bar(0.1, 1.0, 0.1);
  run.elements = 100;
  run.mass = Mass::redistributed;
  run.end = 3.0;
  run.epsilon = 1e-6;
  run.method = MethodName::odeint;
  for (const double tolerance : {1e-4, 1e-5, 1e-6}) {
    run.tolerance = {tolerance, 1e-3 * tolerance};
    EXPECT_EQ(contact_changes(run).size(), 2u) << tolerance;
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, StiffMasslessContact,
                         testing::Values(MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint),
                         [](const auto& method) { return std::string(name(method.param)); });

TEST(StiffMasslessContact, HasTheDigitsOfTheRigidReaction) {
  Case run = paper_throw(0.01);
  run.mass = Mass::redistributed;
  run.output_every = 0.01;
  run.tolerance = {1e-9, 1e-12};
  run.method = MethodName::rigid;
  const Recording rigid = record(run);
  run.method = MethodName::arkode;
  run.epsilon = 1e-14;
  const Recording spring = record(run);
  double error = 0.0, largest = 0.0;
  for (std::size_t k = 0; k < rigid.times.size(); ++k) {
    largest = std::max(largest, rigid.reaction_left[k]);
    error = std::max(error, std::abs(spring.reaction_left[k] - rigid.reaction_left[k]));
  }
  // The promise of both for u and w, up to 0.3, times E/h and eta/h. From the penetration, 8e-15 beside u = -0.1, it
  // would be known to 0.001.
  EXPECT_GT(largest, 0.5);
  EXPECT_LT(error, 2 * 100 * (0.3 * 1e-9 + 1e-12) * 27 * (1.0 + 0.01));
}

TEST(StiffMasslessContact, IsTheRigidOneBitForBitWhereItGivesWayByLessThanRounding) {
  Case run = paper_throw(0.01);
  run.mass = Mass::redistributed;
  const BarSystem system = resolve(run).system();
  const auto times = uniform_times(0.01, 600);
  const RunTrace rigid = record(system, times, Arkode{{0.0}, run.tolerance});
  const RunTrace spring = record(system, times, Arkode{{1e-20}, run.tolerance});
  EXPECT_EQ(spring.u, rigid.u);
  EXPECT_EQ(spring.v, rigid.v);
  EXPECT_EQ(spring.reaction_left, rigid.reaction_left);
  EXPECT_GT(rigid.statistics.events, 0u);
  // Known from the reaction all the same.
  EXPECT_NEAR(spring.statistics.max_penetration, 1e-20 * *std::ranges::max_element(rigid.reaction_left), 0.1e-20);
}

INSTANTIATE_TEST_SUITE_P(Methods, StiffContact, testing::Values(MethodName::cvode, MethodName::ida),
                         [](const auto& method) { return std::string(name(method.param)); });

}  // namespace
}  // namespace viscobar::testing_stiff_contact
