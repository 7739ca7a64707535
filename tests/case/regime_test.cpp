#include "case/regime.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/falling_bar.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {
namespace {

constexpr std::size_t elements = 100;
constexpr double h = 1.0 / elements;

// A bar at speed 1 with its left end on the obstacle, watched until a wave has been to the free end.
Case falling(double viscosity, double epsilon, Mass mass) {
  Case run;
  run.scene = falling_bar(0.0, 1.0, viscosity);
  run.elements = elements;
  run.mass = mass;
  run.epsilon = epsilon;
  run.method = MethodName::ida;
  run.end = 1.0;
  run.output_every = 1.0;
  return run;
}

ContactRegime regime(const Case& run) { return contact_regimes(resolve(run), resolve(run).system()).front(); }

// Penetration that a run reaches over the predicted one.
double ratio(const Case& run) { return simulate(resolve(run), {}).max_penetration / regime(run).impact->penetration; }

TEST(ImpactPrediction, FollowsTheTwoThirdsLawWhereTheMeshResolvesTheLayer) {
  // epsilon > h^3/alpha^2 = 1e-6 by far; what the law leaves out is of relative order (epsilon sqrt(alpha))^(1/3).
  for (const double epsilon : {1e-2, 1e-3, 1e-4})
    EXPECT_NEAR(ratio(falling(1.0, epsilon, Mass::consistent)), 1.0, std::cbrt(epsilon));
}

TEST(ImpactPrediction, IsTheNodesOwnOscillatorOnCoarseMeshes) {
  // The neighbour slows down by a share of the order of zeta, meanwhile.
  for (const double epsilon : {1e-4, 1e-5, 1e-6}) {
    const Case run = falling(0.01, epsilon, Mass::lumped);
    EXPECT_EQ(regime(run).impact->layer, ImpactPrediction::Layer::node);
    EXPECT_NEAR(ratio(run), 1.0, *regime(run).damping_ratio);
  }
}

TEST(ImpactPrediction, HoldsWithinAFactorOfTwoEverywhere) {
  for (const Mass mass : {Mass::lumped, Mass::consistent, Mass::redistributed})
    for (const double viscosity : {0.0, 0.001, 0.01, 0.1, 1.0})
      for (const double epsilon : {1e-1, 1e-2, 1e-3, 1e-5}) {
        const double r = ratio(falling(viscosity, epsilon, mass));
        EXPECT_TRUE(r > 0.5 && r < 2.0) << name(mass) << ' ' << viscosity << ' ' << epsilon << ": " << r;
      }
}

TEST(ImpactPrediction, ScalesWithUnits) {
  // New units of length, time and mass per area: displacements scale by the first, speeds by length/time.
  const double a = 3.0, b = 0.2, c = 7.0;
  for (const double epsilon : {1e-1, 1e-3, 1e-7})
    for (const double viscosity : {0.0, 0.02, 1.0})
      for (const double mass : {0.0, h / 2}) {
        const ImpactPrediction plain = predict_impact({1.0, 1.0, 1.0, viscosity}, h, mass, epsilon, 0.5);
        const Bar scaled{a, c / a, c * a / (b * b), viscosity * c * a / b};
        const ImpactPrediction other = predict_impact(scaled, h * a, mass * c, epsilon * b * b / c, 0.5 * a / b);
        EXPECT_NEAR(other.penetration, a * plain.penetration, 1e-14 * a);
        EXPECT_EQ(other.layer, plain.layer);
      }
}

TEST(ContactRegime, TellsTheDampingRatioOfTheLumpedNode) {
  const double alpha = 0.01, epsilon = 1e-3;
  // model: alpha sqrt(epsilon) / (sqrt 2 h^(3/2)) for rho = E = 1
  EXPECT_NEAR(*regime(falling(alpha, epsilon, Mass::lumped)).damping_ratio,
              alpha * std::sqrt(epsilon) / (std::sqrt(2.0) * std::pow(h, 1.5)), 1e-12);
}

TEST(ContactRegime, ChattersUntilTheEpsilonThatItNames) {
  for (const double viscosity : {0.0, 0.01, 1.0}) {
    Case run = falling(viscosity, 1.0, Mass::consistent);
    const double quiet = regime(run).quiet_epsilon;
    run.epsilon = 0.99 * quiet;
    EXPECT_TRUE(regime(run).chatters) << viscosity;
    run.epsilon = 1.01 * quiet;
    EXPECT_FALSE(regime(run).chatters) << viscosity;
  }
}

TEST(ContactRegime, ADashpotWithoutRestitutionEndsChatter) {
  Case run = falling(0.01, 1e-6, Mass::consistent);
  ASSERT_TRUE(regime(run).chatters);
  run.restitution = 0.0;
  EXPECT_FALSE(regime(run).chatters);
}

// A mass that its stop throws off for good: no wave comes to it from its neighbour within the run.
TEST(ContactRegime, AMassThatNoWaveReachesDoesNotChatter) {
  Case run = falling(0.0, 1e-6, Mass::lumped);
  run.end = 4.0;
  ASSERT_TRUE(regime(run).chatters);
  run.scene.bar.modulus = 1e-12;
  EXPECT_FALSE(regime(run).damping_ratio.has_value());
  EXPECT_FALSE(regime(run).chatters);
}

TEST(ContactRegime, AMasslessNodeHasNoDampingRatioAndNoChatter) {
  const ContactRegime massless = regime(falling(0.01, 1e-6, Mass::redistributed));
  EXPECT_FALSE(massless.damping_ratio.has_value());
  EXPECT_FALSE(massless.chatters);
}

TEST(ContactRegime, ExistsForPenalisedContactsOnly) {
  Case run = falling(0.01, 1e-6, Mass::consistent);
  run.method = MethodName::fully_discrete;
  EXPECT_TRUE(contact_regimes(resolve(run), resolve(run).system()).empty());
  run.method = MethodName::ida;
  run.scene.left = Free{};
  EXPECT_TRUE(contact_regimes(resolve(run), resolve(run).system()).empty());
}

TEST(ContactRegime, ABarThatLeavesItsObstacleHasNoImpactToPredict) {
  Case run = falling(0.01, 1e-6, Mass::consistent);
  run.scene.velocity = [](double) { return 1.0; };
  EXPECT_FALSE(regime(run).impact.has_value());
}

TEST(ContactRegime, AFlatFallOnASpanPenetratesByTheNodesOscillator) {
  Case run = falling(0.5, 1e-4, Mass::lumped);
  run.scene.left = Free{};
  run.scene.span = Obstacle{0.0};
  // Lumped nodes fall as one, an undamped oscillator exactly: what differs is the integration, 1e-6 relative a step.
  EXPECT_NEAR(ratio(run), 1.0, 1e-4);
  EXPECT_TRUE(regime(run).chatters);
}

// A bar that falls from rest under its weight: u = -t^2/2 meets the gap at t = V = (2 gap)^(1/2).
Case dropped(MethodName method, double gap) {
  Case run = falling(0.1, 1e-4, Mass::lumped);
  run.scene.left = Obstacle{gap};
  run.scene.right = Obstacle{1.5 * gap};
  run.scene.velocity = [](double) { return 0.0; };
  run.scene.load = SteadyLoad{[](double) { return -1.0; }};
  run.method = method;
  if (!is_penalised(method)) run.mass.reset(), run.epsilon.reset();
  return run;
}

TEST(FirstImpact, IsThatOfTheRunByEachMethod) {
  for (const MethodName method : {MethodName::rigid, MethodName::cvode, MethodName::ida, MethodName::arkode,
                                  MethodName::fully_discrete, MethodName::finite_difference}) {
    Case run = dropped(method, 0.2);
    if (is_scheme(method)) run.step = 1e-3;
    std::vector<Event> closings;
    Observers observers;
    observers.event = [&](const Event& event) {
      if (event.change == Change::closing) closings.push_back(event);
    };
    const viscobar::Setup setup = resolve(run);
    simulate(setup, observers);
    const auto foreseen = foresee(setup);
    ASSERT_TRUE(foreseen) << name(method);
    ASSERT_EQ(foreseen->impacts.size(), 2u) << name(method);
    for (const FirstImpact& impact : foreseen->impacts) {
      const auto same = std::ranges::find(closings, impact.where, &Event::where);
      ASSERT_NE(same, closings.end()) << name(method);
      // The same steps of the same run: to roundings.
      EXPECT_NEAR(impact.time, same->time, 1e-12) << name(method);
      EXPECT_NEAR(impact.speed, -same->velocity, 1e-12) << name(method);
      EXPECT_EQ(impact.time_error, 0.0) << name(method);
    }
  }
}

// 3 10^6 nodal steps are 30,000 steps of 100 elements.
TEST(FirstImpact, TellsItsErrorWhereTheRunWouldTakeLong) {
  for (const double gap : {0.07, 0.15, 0.22, 0.31}) {
    Case run = dropped(MethodName::fully_discrete, gap);
    run.scene.right = EndCondition{};
    run.step = 1e-5;
    const auto foreseen = foresee(resolve(run));
    ASSERT_TRUE(foreseen);
    ASSERT_EQ(foreseen->impacts.size(), 1u);
    const FirstImpact& impact = foreseen->impacts.front();
    EXPECT_NEAR(impact.time, std::sqrt(2.0 * gap), impact.time_error) << gap;
    // Two steps in which a wave crosses an element, the coarser one's.
    EXPECT_GT(impact.time_error, 0.0);
    EXPECT_LE(impact.time_error, 2.0 * h) << gap;
  }
}

// On 50 elements v of that end runs from 0.20 to 1.81 after a step of its force, where the truth is 1.
TEST(JumpRemark, TellsForcesThatJumpWhereNoFilterOfHighModesActs) {
  const auto remark = [](const std::string& bar, const std::string& force, const std::string& parts = "50") {
    const auto setup =
        resolve(parse_scene("[bar]\nlength = 1.0\n" + bar +
                                "[left]\nkind = \"free\"\nstiffness = 1.0\n[right]\nkind = \"free\"\nforce = " + force +
                                "\n[mesh]\nelements = " + parts + "\nmass = \"fourth_order\"\n[time]\nend = 1.5\n",
                            "")
                    .run);
    return jump_remark(setup, setup.system()).value_or("");
  };
  const std::string section = "section = \"1+0*x\"\n", thin = "viscosity = 1e-5\n" + section;
  EXPECT_NE(remark(thin, "1.0").find("the right end jumps at t = 0,"), std::string::npos);
  EXPECT_NE(remark(thin, "\"t > 0.5 ? 1 : 0\"").find("at t = 0.5,"), std::string::npos);
  EXPECT_EQ(remark(thin, "\"sin(3*t)\""), "");
  EXPECT_EQ(remark("viscosity = 0.1\n" + section, "1.0"), "");
  const std::string plain = "viscosity = 1e-5\n";
  for (const char* parts : {"8", "50"}) EXPECT_EQ(remark(plain, "1.0", parts), "");  // JumpFilter acts
  EXPECT_NE(remark(plain, "1.0", "7").find("the right end jumps"), std::string::npos);
  EXPECT_NE(remark(plain + "[side]\nstiffness = 300\n", "1.0").find("the right end jumps"), std::string::npos);
  EXPECT_EQ(remark(plain + "[side]\nstiffness = 200\n", "1.0"), "");
}

// A body has two contacts, and the rows of it and the bar tell the forces of both.
TEST(JumpRemark, IsMadeOfABodyBetweenAnObstacleAndABar) {
  const auto remark = [](const std::string& force) {
    const auto setup = resolve(
        parse_scene("[[bar]]\nmass = 0.5\nvelocity = -1.0\n[[joint]]\nkind = \"contact\"\ngap = 0.1\n[[bar]]\nlength = "
                    "1.0\nviscosity = 1e-5\n[left]\nkind = \"obstacle\"\ngap = 0.1\n" +
                        force + "[mesh]\nelements = 20\nmass = \"fourth_order\"\n[time]\nend = 1.0\n",
                    "")
            .run);
    const BarSystem system = setup.system();
    integrate(system, system.initial_state(), std::vector<double>{0.0, 1.0}, Rigid{.tolerance = {1e-6, 1e-9}}, {});
    return jump_remark(setup, system).value_or("");
  };
  EXPECT_EQ(remark(""), "");
  EXPECT_NE(remark("[right]\nkind = \"free\"\nforce = 1.0\n").find("the right end jumps"), std::string::npos);
}

}  // namespace
}  // namespace viscobar
