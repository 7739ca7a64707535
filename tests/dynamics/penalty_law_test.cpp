#include "viscobar/dynamics/penalty_law.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

namespace viscobar::testing_penalty_law {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

TEST(PenaltyLaw, IsLinearWhileActiveAndNothingOtherwise) {
  const PenaltyLaw law{.stiffness = 100.0, .damping = 3.0};
  EXPECT_EQ(law.reaction(0.5, 2.0), 56.0);
  for (const double open : {0.0, -0.5}) {
    EXPECT_EQ(law.reaction(open, 2.0), 0.0);
    EXPECT_EQ(law.energy(open), 0.0);
  }
}

TEST(PenaltyLaw, TangentsAreStiffnessAndDampingAndEnergyItsIntegral) {
  const PenaltyLaw law{.stiffness = 128.0, .damping = 4.0};
  const double d = 0.5, rate = 0.25, step = 0.125;  // exact in binary: differences of a linear law have no error
  EXPECT_EQ((law.reaction(d + step, rate) - law.reaction(d - step, rate)) / (2 * step), law.stiffness);
  EXPECT_EQ((law.reaction(d, rate + step) - law.reaction(d, rate - step)) / (2 * step), law.damping);
  EXPECT_EQ((law.energy(d + step) - law.energy(d - step)) / (2 * step), law.reaction(d, 0.0));
}

TEST(PenaltyLaw, DampingRatioGivesTheRestitution) {
  for (const double restitution : {0.01, 0.1, 0.5, 0.9, 0.999}) {
    const double zeta = damping_ratio(restitution);
    const double back = std::exp(-std::numbers::pi * zeta / std::sqrt((1 - zeta) * (1 + zeta)));
    // The exponent's rounding, and that of 1 - zeta, amplified.
    EXPECT_NEAR(back, restitution, 20 * eps * (1 - std::log(restitution)) / (1 - zeta));
  }
  EXPECT_EQ(damping_ratio(1.0), 0.0);
  EXPECT_EQ(damping_ratio(0.0), 1.0);
}

TEST(PenaltyLaw, IsWeightOverEpsilonWithADashpotOnlyForMassAndRestitution) {
  const PenaltyLaw undamped = penalty_law({.epsilon = 0.25, .restitution = 1.0}, 0.5, 3.0);
  EXPECT_EQ(undamped.stiffness, 2.0);
  EXPECT_EQ(undamped.damping, 0.0);
  EXPECT_EQ(penalty_law({.epsilon = 0.25, .restitution = 0.0}, 1.0, 0.0).damping, 0.0);
  EXPECT_EQ(penalty_law({.epsilon = 0.25, .restitution = 0.0}, 1.0, 4.0).damping, 8.0);  // 2 sqrt(k m)
}

}  // namespace
}  // namespace viscobar::testing_penalty_law
