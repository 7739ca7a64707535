#include "viscobar/studies/exact/exact_solutions.hpp"

#include <gtest/gtest.h>

#include <complex>
#include <limits>

#include "viscobar/case/recorder.hpp"

namespace viscobar::exact {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr double pi = std::numbers::pi;

// The same Laplace transform inverted another way: the fixed Talbot contour [Abate and Valko 2004]. With m points it is
// exact to about 10^(-0.6 m) and rounds to 10^(0.17 m) eps; m = 24 balances the two near 1e-12.
double talbot(const ImpactLaw& law, double t) {
  using Complex = std::complex<double>;
  constexpr int m = 24;
  const double r = 2.0 * m / (5.0 * t);
  const auto transform = [&](Complex s) {
    const Complex z = std::sqrt(law.bar.density * (law.bar.modulus + law.bar.viscosity * s));
    return law.speed * law.epsilon * z / (s * (1.0 + law.epsilon * s * z));
  };
  double sum = 0.5 * (std::exp(r * t) * transform(r)).real();
  for (int k = 1; k < m; ++k) {
    const double angle = k * pi / m, cot = 1 / std::tan(angle);
    const Complex s = r * angle * Complex(cot, 1.0);
    const double slope = angle + (angle * cot - 1.0) * cot;
    sum += (std::exp(s * t) * transform(s) * Complex(1.0, slope)).real();
  }
  return r / m * sum;
}

TEST(ImpactLaw, WithoutViscosityIsAnExponentialRise) {
  const ImpactLaw law{{5.0, 2.0, 8.0, 0.0}, 1.5, 0.01};
  for (const double t : {0.001, 0.03, 0.4})
    EXPECT_NEAR(law.penetration(t), 1.5 * 0.04 * (1 - std::exp(-t / 0.04)), 10 * eps);
  EXPECT_FALSE(law.peak());
}

TEST(ImpactLaw, TendsToTheUndampedOneAsTheViscosityVanishes) {
  const ImpactLaw undamped{{5.0, 2.0, 8.0, 0.0}, 1.5, 0.01};
  for (const double eta : {1e-4, 1e-6}) {
    ImpactLaw law = undamped;
    law.bar.viscosity = eta;
    // Z grows by the factor sqrt(1 + eta s / E), s up to 1 / epsilon'.
    for (const double t : {0.02, 0.1})
      EXPECT_NEAR(law.penetration(t), undamped.penetration(t), 1.5 * 0.04 * eta / 8.0 / 0.04);
  }
}

TEST(ImpactLaw, IsTheInverseOfItsTransformInEveryRegime) {
  for (const Bar& bar : {Bar{1, 1, 1, 1}, Bar{1, 1, 1, 0.01}, Bar{3, 2.5, 0.4, 0.07}, Bar{1, 0.3, 7.0, 20.0}})
    for (const double epsilon : {10.0, 0.1, 1e-3, 1e-6}) {
      const ImpactLaw law{bar, 0.7, epsilon};
      const double tau = std::cbrt(epsilon * epsilon * bar.density * bar.viscosity);
      for (const double share : {0.01, 0.3, 1.0, 3.0, 8.0}) {
        const double t = share * tau;
        EXPECT_NEAR(law.penetration(t), talbot(law, t), 1e-10 * law.speed * tau) << epsilon << " " << share;
      }
    }
}

TEST(ImpactLaw, BeginsWithTheSpeedAndItsRateIsItsDerivative) {
  for (const double epsilon : {1.0, 1e-3}) {
    const ImpactLaw law{{1.0, 1.0, 1.0, 0.3}, 0.7, epsilon};
    const double tau = std::cbrt(epsilon * epsilon * 0.3);
    EXPECT_NEAR(law.rate(1e-14 * tau), 0.7, 1e-6);  // the next term is sqrt(1e-14)^3 or t / epsilon'
    EXPECT_NEAR(law.penetration(1e-4 * tau), 0.7e-4 * tau, 0.7e-4 * tau * 1e-4);
    for (const double t : {0.5 * tau, 2 * tau}) {
      const double step = 1e-4 * tau;  // error step^2 d''' / 6, and eps d / step of rounding
      const double slope = (law.penetration(t + step) - law.penetration(t - step)) / (2 * step);
      EXPECT_NEAR(law.rate(t), slope, 1e-8 * law.speed + 1e-11 / 1e-4);
    }
  }
}

TEST(ImpactLaw, PeaksAsThePowerTwoThirdsOfThePenalty) {
  for (const Bar& bar : {Bar{1, 1, 1, 1}, Bar{1, 2, 3, 0.1}}) {
    for (const double epsilon : {1e-8, 1e-10}) {
      const ImpactLaw law{bar, 2.0, epsilon};
      const double tau = std::cbrt(epsilon * epsilon * bar.density * bar.viscosity);
      const auto peak = law.peak();
      ASSERT_TRUE(peak);
      // Relative corrections of order E tau / eta, printed to four digits.
      EXPECT_NEAR(peak->penetration / (2.0 * tau), 0.8580, 5e-5 + bar.modulus * tau / bar.viscosity);
      EXPECT_NEAR(peak->time / tau, 1.6452, 5e-5 + bar.modulus * tau / bar.viscosity);
    }
  }
}

TEST(ImpactLaw, NeverPullsAndEndsAtTheStressOfTheWave) {
  for (const double eta : {0.0, 0.001, 0.1, 1.0, 30.0})
    for (const double epsilon : {1e-1, 1e-4}) {
      const ImpactLaw law{{1.0, 2.0, 3.0, eta}, 0.4, epsilon};
      double t = 1e-6;
      for (; t < 1e6; t *= 1.1) EXPECT_GT(law.penetration(t), 0.0) << eta << " " << epsilon << " " << t;
      const double rest = 0.4 * epsilon * std::sqrt(6.0);
      EXPECT_NEAR(law.penetration(t), rest, 1e-12 * rest);
    }
}

// Both sides of the equation, by central differences of step d: their error is d^2 / 6 times the third derivative, and
// the k-th one of sin^3 is at most (3 omega)^k.
TEST(ManufacturedContact, SolvesTheEquation) {
  for (const int ends : {1, 2, 3}) {
    ManufacturedContact contact{{1.3, 2.0, 0.7, 0.4}, {}, {}};
    if (ends & 1) contact.left = ManufacturedContact::End{0.2, 5.0};
    if (ends & 2) contact.right = ManufacturedContact::End{0.3, 3.0};
    const double d = 1e-3;
    const Bar& bar = contact.bar;
    for (const double x : {0.2, 0.65, 1.1})
      for (const double t : {0.3, 0.9, 1.57, 2.4, 7.7}) {
        const auto second = [&](auto f) { return (f(1) - 2 * f(0) + f(-1)) / (d * d); };
        const double u_tt = (contact.v(x, t + d) - contact.v(x, t - d)) / (2 * d);
        const double u_xx = second([&](int k) { return contact.u(x + k * d, t); });
        const double v_xx = second([&](int k) { return contact.v(x + k * d, t); });
        EXPECT_NEAR(bar.density * u_tt - bar.modulus * u_xx - bar.viscosity * v_xx, contact.f(x, t),
                    d * d / 6 * bar.density * std::pow(3 * 5.0, 4) + 100 * eps / (d * d))
            << ends << " " << x << " " << t;
        EXPECT_NEAR(contact.v(x, t), (contact.u(x, t + d) - contact.u(x, t - d)) / (2 * d),
                    d * d / 6 * std::pow(3 * 5.0, 3));
      }
  }
}

TEST(ManufacturedContact, ItsStressAtTheEndsIsTheReactionAndTheConstraintIsComplementary) {
  const ManufacturedContact contact{
      {1.3, 2.0, 0.7, 0.4}, ManufacturedContact::End{0.2, 5.0}, ManufacturedContact::End{0.3, 3.0}};
  const double d = 1e-3, length = contact.bar.length;
  for (double t = 0.01; t < 9.0; t += 0.17) {
    const auto stress = [&](double x, double sign) {  // one-sided, second order
      const auto slope = [&](auto f) {
        return sign * (-3 * f(x) + 4 * f(x + sign * d) - f(x + sign * 2 * d)) / (2 * d);
      };
      return contact.bar.modulus * slope([&](double y) { return contact.u(y, t); }) +
             contact.bar.viscosity * slope([&](double y) { return contact.v(y, t); });
    };
    EXPECT_NEAR(-stress(0.0, 1.0), contact.reaction_left(t), d * d * 200);
    EXPECT_NEAR(stress(length, -1.0), contact.reaction_right(t), d * d * 200);
    EXPECT_NEAR(contact.u(0.0, t) + 0.2, contact.left->opening(t), 4 * eps);
    EXPECT_NEAR(contact.u(length, t) + 0.3, contact.right->opening(t), 4 * eps);
    EXPECT_EQ(contact.left->opening(t) * contact.reaction_left(t), 0.0);
  }
}

TEST(ManufacturedContact, ListsItsChangesInOrder) {
  const ManufacturedContact contact{
      {1.0, 1.0, 1.0, 0.5}, ManufacturedContact::End{0.2, 5.0}, ManufacturedContact::End{0.3, 3.0}};
  const auto changes = contact.changes(2.0);
  ASSERT_EQ(changes.size(), 4u);
  EXPECT_DOUBLE_EQ(changes[0].time, pi / 5);
  EXPECT_EQ(changes[0].change, Change::closing);
  EXPECT_DOUBLE_EQ(changes[1].time, pi / 3);
  EXPECT_EQ(changes[1].where, Where::right);
  EXPECT_EQ(changes[2].change, Change::opening);
}

TEST(ElasticImpact, IsAWaveThatKeepsMomentumAndEnergy) {
  const ElasticImpact impact{{2.0, 3.0, 12.0, 0.0}, 0.5, 0.1};
  EXPECT_DOUBLE_EQ(impact.opening() - impact.closing(), 2.0);
  // The reaction reverses the momentum.
  EXPECT_DOUBLE_EQ(impact.reaction(1.0) * 2.0, 2 * 3.0 * 2.0 * 0.5);
  for (const double t : {0.1, 0.9, 1.7, 3.0})
    for (const double x : {0.3, 1.1, 1.9}) {
      const double d = 1e-6;
      EXPECT_NEAR((impact.u(x, t + d) - impact.u(x, t - d)) / (2 * d), impact.v(x, t), eps / d * 10);
    }
  EXPECT_NEAR(impact.u(0.7, 5.0), impact.u(1.9, 5.0), 10 * eps);
}

TEST(Solution, AsASolverHasNoErrorAndFitsItsCase) {
  const Solution exact = solution(ManufacturedContact{});
  Case run;
  run.scene = exact.scene;
  run.elements = 7;
  const Recording recording = solver(exact)(run);
  EXPECT_EQ(fault(recording, run), std::nullopt);
  const Error found = error(recording, exact);
  EXPECT_EQ(found.displacement_l2 + found.velocity_l2 + found.end_trace + found.reaction_l1, 0.0);
}

TEST(Solution, LaterIsTheSameMotionFromThenOn) {
  const Solution exact = solution(ManufacturedContact{}), then = later(exact, 0.6);
  for (const double x : {0.0, 0.3, 1.0}) {
    EXPECT_EQ(then.scene.displacement(x), exact.u(x, 0.6));
    EXPECT_EQ(then.scene.velocity(x), exact.v(x, 0.6));
    EXPECT_EQ(then.u(x, 0.25), exact.u(x, 0.6 + 0.25));
    EXPECT_EQ(std::get<GeneralLoad>(*then.scene.load).density(x, 0.25),
              std::get<GeneralLoad>(*exact.scene.load).density(x, 0.6 + 0.25));
  }
  EXPECT_EQ(then.reaction_left(0.1), exact.reaction_left(0.6 + 0.1));
  EXPECT_FALSE(later(solution(ElasticImpact{}), 1.0).reaction_right);
}

TEST(Error, OfTheInterpolantIsTheMeshErrorAloneAndOfAShiftTheShift) {
  const ManufacturedContact contact;
  const Solution exact = solution(contact);
  Recording recording;
  recording.mesh = {1.0, 10};
  for (double t = 0.0; t <= 1.0; t += 0.1) {
    recording.times.push_back(t);
    for (std::size_t j = 0; j <= 10; ++j) {
      recording.u.push_back(contact.u(recording.mesh.node(j), t) + 0.01);
      recording.v.push_back(contact.v(recording.mesh.node(j), t));
    }
    recording.reaction_left.push_back(contact.reaction_left(t) - 0.2);
    recording.reaction_right.push_back(0.0);
  }
  const Error found = error(recording, exact);
  EXPECT_NEAR(found.displacement_l2, 0.01, 10 * eps);
  EXPECT_NEAR(found.end_trace, 0.01, 10 * eps);
  EXPECT_EQ(found.velocity_l2, 0.0);
  EXPECT_NEAR(found.reaction_l1, 0.2 * recording.times.back(), 10 * eps);
}

}  // namespace
}  // namespace viscobar::exact
