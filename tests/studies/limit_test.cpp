#include "viscobar/studies/limit/limit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "support/paper_throw.hpp"
#include "viscobar/case/end_traces.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

LimitStudy study_of(Case scene, std::vector<double> epsilons) {
  LimitStudy study;
  study.scene = std::move(scene);
  study.epsilons = std::move(epsilons);
  return study;
}

LimitOrders only(const LimitResult& result) { return result.orders.at(0); }

TEST(Limit, AnUndampedPenaltyOnTheConsistentMassStopsAtAPlateauAgainstTheScheme) {
  Case scene = paper_throw(0.01);
  scene.step = 1e-4;
  const LimitResult result = limit_of(study_of(scene, decades(1e-2, 1e-6)));
  EXPECT_EQ(only(result).verdict, Verdict::plateau);
  // Model: 3.0e-3, and it still moves by a tenth a decade.
  EXPECT_NEAR(result.rows.back().difference_to_scheme, 3.0e-3, 0.3e-3);
  EXPECT_EQ(result.rows.front().events, 4u);
  EXPECT_GT(result.rows.back().events, 300u);
  for (std::size_t k = 0; k + 1 < result.rows.size(); ++k) EXPECT_GT(result.rows[k + 1].events, result.rows[k].events);
}

// A section of a power of two divides all epsilons by it, and changes no digit of a power.
TEST(Limit, PowersDoNotDependOnTheUnitOfArea) {
  const auto orders = [](double area) {
    Case scene = paper_throw(1.0);
    scene.scene.section = [area](double) { return area; };
    scene.mass = Mass::redistributed;
    scene.elements = 216;
    scene.step = 1e-4;
    return only(limit_of(study_of(scene, decades(1e-3 / area, 1e-5 / area, 2))));
  };
  const LimitOrders unit = orders(1.0);
  ASSERT_TRUE(unit.boundary && unit.penetration_layer);
  for (const double area : {0x1p-13, 0x1p13}) {
    const LimitOrders other = orders(area);
    ASSERT_TRUE(other.boundary && other.penetration_layer) << area;
    EXPECT_NEAR(*other.boundary * area, *unit.boundary, 1e-12 * *unit.boundary);
    EXPECT_NEAR(other.penetration_layer->order, unit.penetration_layer->order, 1e-3) << area;
  }
}

class MasslessNodes : public testing::TestWithParam<double> {
 protected:
  Case scene() const {
    Case scene = paper_throw(GetParam());
    scene.mass = Mass::redistributed;
    scene.method = MethodName::ida;  // takes them without viscosity, too
    scene.step = 1e-4;
    return scene;
  }
};

TEST_P(MasslessNodes, ShareOneLimitWithTheRigidBarAndTheScheme) {
  const LimitResult result = limit_of(study_of(scene(), decades(1e-2, 1e-8)));
  const LimitOrders orders = only(result);
  EXPECT_EQ(orders.verdict, Verdict::converges);
  ASSERT_TRUE(orders.penetration && orders.to_scheme_limit);
  EXPECT_NEAR(orders.penetration->order, 1.0, 0.03);
  EXPECT_NEAR(orders.to_scheme_limit->order, 1.0, 0.03);
  const double h = 1.0 / 27.0;
  EXPECT_EQ(orders.boundary.has_value(), GetParam() > 0.0);
  if (orders.boundary) {
    EXPECT_NEAR(*orders.boundary, h * h * h / (GetParam() * GetParam()), 1e-12 * *orders.boundary);
  }
  // Contacts do not multiply: a node without mass has nothing to bounce with.
  for (const LimitRow& row : result.rows) EXPECT_LE(row.events, 8u);
  EXPECT_EQ(result.rows.back().events, orders.scheme_events);
}

TEST_P(MasslessNodes, TheSchemeTendsToTheRigidBarAtFirstOrderInItsStep) {
  Case rigid = scene();
  rigid.method = MethodName::rigid;
  rigid.tolerance = {1e-10, 1e-13};
  const std::vector<double> times = comparison_times(rigid.end, 2000, contact_changes(rigid));
  const EndTraces limit = trace_ends(rigid, times);
  // A contact of the scheme closes on its own grid, anywhere within a step of the right time: single differences
  // scatter by a factor, many steps show the power. They resolve the relaxation eta/E of the massless node.
  std::vector<double> steps, differences;
  for (int k = 0; k <= 14; ++k) {
    Case scheme = scene();
    scheme.method = MethodName::fully_discrete;
    scheme.step = 1e-4 * std::pow(10.0, -0.1 * k);
    steps.push_back(*scheme.step);
    differences.push_back(largest_difference(limit, trace_ends(scheme, times)));
  }
  EXPECT_NEAR(observed_order(steps, differences)->order, 1.0, 0.1) << differences.front() << " " << differences.back();
}

INSTANTIATE_TEST_SUITE_P(Viscosities, MasslessNodes, testing::Values(1.0, 0.1, 0.01, 0.001, 0.0));

TEST(Limit, WhereTheMeshResolvesTheLayerThePowerIsTwoThirds) {
  Case scene = paper_throw(1.0);
  scene.mass = Mass::redistributed;
  scene.elements = 216;
  scene.step = 1e-4;
  // 100 h^3 = 1e-5; the law is that of epsilon -> 0.
  const LimitOrders orders = only(limit_of(study_of(scene, decades(1e-3, 1e-5, 2))));
  ASSERT_TRUE(orders.penetration_layer && orders.to_scheme_limit_layer);
  EXPECT_NEAR(orders.penetration_layer->order, 2.0 / 3.0, 0.02);
  EXPECT_NEAR(orders.to_scheme_limit_layer->order, 2.0 / 3.0, 0.02);
}

/// The power that the difference to the scheme follows over the two decades down to the least penalty asked for,
/// whether it has settled or not.
double power_to_scheme(const LimitResult& result, const std::vector<double>& asked) {
  std::vector<double> epsilon, difference;
  for (const LimitRow& row : result.rows)
    if (row.epsilon >= 0.99 * asked.back() && row.epsilon <= 101.0 * asked.back()) {
      epsilon.push_back(row.epsilon);
      difference.push_back(row.difference_to_scheme);
    }
  return observed_order(epsilon, difference)->order;
}

class CommonRestitution : public testing::TestWithParam<std::tuple<double, double, Impact>> {};

TEST_P(CommonRestitution, GivesPenaltyAndSchemeOneLimitOnTheConsistentMassLikeTheRootOfEpsilon) {
  const auto [restitution, viscosity, impact] = GetParam();
  Case scene = paper_throw(viscosity);
  scene.restitution = restitution;
  scene.impact = impact;
  scene.step = 1e-6;
  // A bar that forgets nothing comes to the power late.
  const std::vector<double> epsilons = viscosity > 0.0 ? decades(1e-3, 1e-6) : decades(1e-5, 1e-7);
  const LimitResult result = limit_of(study_of(scene, epsilons));
  const LimitOrders orders = only(result);
  EXPECT_EQ(orders.verdict, Verdict::converges);
  EXPECT_NEAR(power_to_scheme(result, epsilons), 0.5, 0.05);
  if (orders.to_scheme) {
    EXPECT_NEAR(orders.to_scheme->order, 0.5, 0.05) << "where it is told";
  }
  EXPECT_NEAR(orders.penetration->order, 0.5, 0.01);
  for (const LimitRow& row : result.rows)
    if (restitution == 0.0) {
      EXPECT_LE(row.events, 20u) << "epsilon = " << row.epsilon;
    }
}

INSTANTIATE_TEST_SUITE_P(Throws, CommonRestitution,
                         testing::Combine(testing::Values(0.0, 0.25, 0.5, 1.0), testing::Values(0.01, 0.001),
                                          testing::Values(Impact::paoli_schatzman)));

INSTANTIATE_TEST_SUITE_P(ThrowsByMoreausImpact, CommonRestitution,
                         testing::Combine(testing::Values(0.5), testing::Values(0.001),
                                          testing::Values(Impact::moreau)));

// Without viscosity nothing is forgotten; restitutions 0 and 0.25 have not reached the power by epsilon = 1e-7
// (docs/penalty-limit.md).
INSTANTIATE_TEST_SUITE_P(UndampedThrows, CommonRestitution,
                         testing::Combine(testing::Values(0.5, 1.0), testing::Values(0.0),
                                          testing::Values(Impact::paoli_schatzman)));

TEST(Limit, IsTheSameStudyByEveryPenalisedMethod) {
  for (const Mass mass : {Mass::consistent, Mass::redistributed}) {
    Case scene = paper_throw(0.01);
    scene.mass = mass;
    scene.step = 1e-3;
    scene.end = 2.4;
    const std::vector<double> epsilons = decades(1e-2, 1e-6, 1);
    std::vector<LimitResult> results;
    for (const MethodName method :
         {MethodName::exponential, MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint}) {
      // Explicit, it would make millions of steps on stiff rows.
      if (method == MethodName::odeint && mass == Mass::redistributed) continue;
      scene.method = method;
      results.push_back(limit_of(study_of(scene, epsilons)));
    }
    const double tolerance = only(results[0]).tolerance_error;
    for (const LimitResult& result : results) {
      ASSERT_EQ(result.rows.size(), epsilons.size());
      EXPECT_EQ(only(result).verdict, only(results[0]).verdict);
      for (std::size_t k = 0; k < epsilons.size(); ++k) {
        const LimitRow &row = result.rows[k], &reference = results[0].rows[k];
        EXPECT_EQ(row.events, reference.events);
        // The largest of a dozen values a step, not of the interpolant: 1 - cos(1/100) of it may be missed.
        EXPECT_NEAR(row.max_penetration, reference.max_penetration, 2 * tolerance + 5e-5 * reference.max_penetration);
        // The comparison times differ by the last digits of the contact times.
        EXPECT_NEAR(row.difference_to_scheme, reference.difference_to_scheme,
                    2 * tolerance + 0.01 * reference.difference_to_scheme);
      }
    }
  }
}

TEST(Limit, APathToTheBarExistsOnThePapersMassOfOrderTwoInH) {
  // A node's bounce is over after rho h^2 / eta, having gone V rho h^2 / eta far: along epsilon ~ h^3, dt ~ h^2 all
  // differences are O(h^2), chatter or not.
  const auto difference = [](double viscosity, std::size_t elements) {
    Case scene = paper_throw(viscosity);
    scene.end = 2.4;
    scene.elements = elements;
    const double h = scene.mesh().spacing();
    scene.step = 0.2 * h * h;
    LimitStudy study = study_of(scene, {0.1 * h * h * h});
    study.budget = 0.0;
    return limit_of(study).rows.at(0).difference_to_scheme;
  };
  for (const double viscosity : {1.0, 0.1})
    EXPECT_NEAR(std::log2(difference(viscosity, 27) / difference(viscosity, 54)), 2.0, 0.1) << viscosity;
  // h must be well below eta first.
  EXPECT_NEAR(std::log2(difference(0.01, 108) / difference(0.01, 216)), 2.0, 0.1);
}

// The paper's bar over a distributed obstacle (examples/scenes/paper-span.toml) on a coarse mesh: it arrives unevenly,
// node by node.
Case paper_span(Mass mass) {
  Case run;
  run.scene.bar = {26.0, 1.0, 1.0, 1.0};
  run.scene.span = Obstacle{650.0};
  run.scene.displacement = run.scene.velocity = [](double x) { return x * (1.0 - x); };
  run.elements = 26;
  run.mass = mass;
  run.restitution = 0.0;
  run.step = 2e-4;
  run.end = 40.0;
  return run;
}

TEST(Limit, UnderASpanOneRestitutionGivesOneLimitWhereTheMassDoesNotTieNeighboursTogether) {
  // Below epsilon = rho h^4 / eta^2 = 1 a node is at rest before its neighbours drag it along.
  const LimitResult lumped = limit_of(study_of(paper_span(Mass::lumped), decades(1e-5, 1e-7)));
  EXPECT_EQ(only(lumped).verdict, Verdict::converges);
  EXPECT_NEAR(*only(lumped).boundary, 1.0, 1e-12);
  EXPECT_NEAR(power_to_scheme(lumped, decades(1e-5, 1e-7)), 0.5, 0.05);
  EXPECT_FALSE(only(lumped).penetration_layer);
  // On the consistent mass the impact of a node is an impulse on its neighbours, which share it between them by a law
  // of their own: a plateau, small beside the 650 that the bar falls.
  const LimitResult consistent = limit_of(study_of(paper_span(Mass::consistent), decades(1e-5, 1e-7)));
  EXPECT_EQ(only(consistent).verdict, Verdict::plateau);
  EXPECT_LT(consistent.rows.back().difference_to_scheme, 0.01 * 650.0);
}

TEST(Limit, OneEpsilonAloneHasNoVerdictAndTheStudyGoesOnByItself) {
  Case scene = paper_throw(0.01);
  scene.step = 1e-4;
  LimitStudy study = study_of(scene, {1e-3});
  study.budget = 0.0;
  const LimitOrders massive = only(limit_of(study));
  EXPECT_EQ(massive.verdict, Verdict::undecided);
  EXPECT_EQ(massive.evidence.missing, Missing::smaller_epsilon);
  study.budget = 60.0;
  const LimitResult result = limit_of(study);
  EXPECT_EQ(only(result).verdict, Verdict::plateau);
  EXPECT_GT(result.rows.size(), 1u);
  scene.mass = Mass::redistributed;
  EXPECT_EQ(only(limit_of(study_of(scene, {1e-8}))).verdict, Verdict::converges);
}

// `redistributed` leaves a mass on an end its own, which an undamped penalty throws back and the scheme stops.
TEST(Limit, AMassOnAnEndHasTwoLimitsThoughTheOtherContactNodeIsMassless) {
  const Case scene =
      parse_scene(
          "[bar]\nlength = 1.0\nviscosity = 0.06\n[left]\nkind = \"obstacle\"\ngap = 0.2\nside = \"above\"\n"
          "[right]\nkind = \"obstacle\"\ngap = 0.06\nmass = 0.4\nstiffness = 7.0\n[initial]\nvelocity = -1.2\n"
          "[time]\nend = 2.0\n[mesh]\nelements = 4\nmass = \"redistributed\"\n[method]\nname = \"arkode\"\n",
          "")
          .run;
  const LimitResult result = limit_of(study_of(scene, decades(1e-2, 1e-8)));
  EXPECT_EQ(only(result).verdict, Verdict::plateau);
  ASSERT_TRUE(only(result).evidence.apart);
  EXPECT_NEAR(result.rows.back().difference_to_scheme, *only(result).evidence.apart,
              0.02 * *only(result).evidence.apart);
  EXPECT_LT(*result.rows.back().difference_to_own_limit, 0.02 * *only(result).evidence.apart);
}

TEST(Limit, TheLimitsOfThePapersPairAreApartByWhatTwoRunsOfRigidAre) {
  // Restitution 1 and 0 of `rigid`; every row of both sequences lies within its distance to its own limit of that.
  Case scene = paper_throw(0.01);
  scene.step = 1e-4;
  const LimitResult result = limit_of(study_of(scene, decades(1e-2, 1e-7)));
  const LimitOrders orders = only(result);
  ASSERT_TRUE(orders.evidence.apart);
  // A hundredth, which the times of comparison may miss of a maximum.
  EXPECT_LT(orders.evidence.apart_error, 0.011 * *orders.evidence.apart);
  for (const LimitRow& row : result.rows) {
    ASSERT_TRUE(row.difference_to_own_limit && row.difference_to_scheme_limit);
    // The triangle's inequality, to the rounding of three maxima.
    EXPECT_LE(std::abs(*row.difference_to_scheme_limit - *orders.evidence.apart), *row.difference_to_own_limit + 1e-9);
  }
  EXPECT_LT(*result.rows.back().difference_to_own_limit, 0.1 * *orders.evidence.apart);
}

TEST(Limit, ABudgetIsOne) {
  // Contact changes grow like epsilon^(-1/2): six decades of them take minutes.
  Case scene = paper_throw(1.0);
  scene.elements = 200;
  scene.step = 1e-3;
  LimitStudy study = study_of(scene, decades(1e-4, 1e-12));
  study.budget = 0.5;
  std::size_t told = 0;
  study.row = [&](const LimitRow&) { ++told; };
  const LimitResult result = limit_of(study);
  EXPECT_GT(result.rows.size(), 0u);
  EXPECT_EQ(told, result.rows.size());
  EXPECT_EQ(result.rows.size() + result.left_out.size(), study.epsilons.size());
  // A run looks at the clock every 128 steps, some milliseconds, and what is judged after the last is not counted.
  EXPECT_LT(only(result).seconds, 1.0);
}

TEST(Limit, AnInterruptKeepsWhatIsThereAndJudgesIt) {
  Case scene = paper_throw(0.01);
  scene.step = 1e-4;
  LimitStudy study = study_of(scene, decades(1e-2, 1e-8));
  study.threads = 1;
  std::size_t rows = 0;
  study.row = [&](const LimitRow&) { ++rows; };
  study.interrupted = [&] { return rows >= 3; };
  const LimitResult result = limit_of(study);
  EXPECT_EQ(result.rows.size(), 3u);
  EXPECT_TRUE(only(result).interrupted);
}

TEST(Limit, ABarThatIsPressedOnItsObstacleHasOneLimitOnAnyMassAndLaw) {
  // Nothing meets at a speed that stays as epsilon -> 0, so the law of impact does not matter: u -> 0 at the left end
  // in both.
  Case scene = paper_throw(0.1);
  scene.scene.left = Obstacle{0.0};
  scene.scene.right = Free{};
  scene.scene.displacement = scene.scene.velocity = [](double) { return 0.0; };
  scene.scene.load = SteadyLoad{[](double) { return -1.0; }};
  scene.end = 3.0;
  scene.step = 1e-2;
  EXPECT_EQ(only(limit_of(study_of(scene, decades(1e-3, 1e-8)))).verdict, Verdict::converges);
}

TEST(Limit, MorePenaltiesADecadeDoNotChangeTheVerdict) {
  Case scene = paper_throw(0.01);
  scene.step = 1e-4;
  const LimitOrders one = only(limit_of(study_of(scene, decades(1e-2, 1e-8)))),
                    four = only(limit_of(study_of(scene, decades(1e-2, 1e-8, 4))));
  EXPECT_EQ(four.verdict, Verdict::plateau);
  // The times at which traces are compared follow the contact changes of all runs: a maximum moves by a percent.
  EXPECT_NEAR(*four.evidence.lower(), *one.evidence.lower(), 0.02 * *one.evidence.lower());
}

TEST(Limit, WithoutBudgetTheSchemeRunsThreeTimes) {
  Case scene = paper_throw(0.01);
  scene.step = 1e-1;
  LimitStudy study = study_of(scene, decades(1e-2, 1e-5));
  study.budget = 0.0;
  const LimitOrders orders = only(limit_of(study));
  EXPECT_EQ(orders.verdict, Verdict::undecided);
  EXPECT_EQ(orders.evidence.missing, Missing::smaller_step);
  ASSERT_EQ(orders.scheme.size(), 3u);
  EXPECT_DOUBLE_EQ(orders.scheme_step, 1e-1);
}

TEST(Limit, TellsItsProgressRunByRun) {
  Case scene = paper_throw(0.1);
  scene.step = 1e-2;
  LimitStudy study = study_of(scene, {1e-2, 1e-3});
  std::size_t calls = 0, all = 0;
  study.progress = [&](std::size_t done, std::size_t of) {
    EXPECT_EQ(done, ++calls);
    all = of;
  };
  limit_of(study);
  EXPECT_EQ(calls, all);
}

TEST(ComparisonTimes, RunFromZeroToTheEndAndCrowdAfterAContactChange) {
  const std::vector<Event> changes = {{.time = 0.3}};
  const std::vector<double> times = comparison_times(2.0, 10, changes);
  EXPECT_EQ(times.front(), 0.0);
  EXPECT_EQ(times.back(), 2.0);
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end(), std::less_equal<>()));
  // Within 1e-6 of an interval after the change, and from there to an interval at most 15 % apart.
  const auto after = std::upper_bound(times.begin(), times.end(), 0.3);
  EXPECT_NEAR(*after - 0.3, 0.2e-6 * std::pow(10.0, 0.06), 1e-9);
  for (auto t = after; *t < 0.5 - 1e-9; ++t) EXPECT_LT(*(t + 1) - 0.3, 1.16 * (*t - 0.3));
}

}  // namespace
}  // namespace viscobar
