// A lone mass in a stop, against closed forms and quadratures.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "laws/scene.hpp"

namespace viscobar::laws {
namespace {

// The bar behind takes 1e-12 of the mass's momentum a unit of time. The tolerance of the solution is 1e-11, and the
// promised multiple of it 100; closed forms are given to ten digits.
constexpr double close_enough = 1e-9;

double contact_time(const Outcome& run) { return run.events.at(1).time - run.events.at(0).time; }

struct Impact {
  double time, restitution, deepest, peak;
};

void expect_impact(const Outcome& run, const Impact& expected, double speed) {
  ASSERT_EQ(run.events.size(), 2u);
  EXPECT_NEAR(contact_time(run), expected.time, close_enough * expected.time);
  EXPECT_NEAR(run.events[1].velocity / speed, expected.restitution, close_enough);
  EXPECT_NEAR(-run.statistics.account->left.lowest, expected.deepest, close_enough * expected.deepest);
  EXPECT_NEAR(run.statistics.max_penetration, expected.deepest, close_enough * expected.deepest);
  EXPECT_NEAR(run.statistics.account->left.peak_reaction, expected.peak, 10 * close_enough * expected.peak);
  EXPECT_NEAR(run.statistics.energy->balance_error(), 0.0, close_enough);
  EXPECT_NEAR(run.statistics.account->left.impulse, 1.0 + expected.restitution, close_enough);
}

// w t = 2 acos(zeta) / q, e = exp(-zeta w t), w d / V = exp(-zeta acos(zeta) / q), q = sqrt(1 - zeta^2). The peak is at
// the angle acos(zeta (3 - 4 zeta^2)), or from zeta = 1/2 on at the touch.
TEST(LoneMass, OnASpringAndADamperLeavesWhereTheForceIsZero) {
  for (const double zeta : {0.05, 0.2, 0.5, 0.8})
    for (const char* method : linear_methods) {
      SCOPED_TRACE(fmt::format("{} zeta {}", method, zeta));
      const double q = std::sqrt(1.0 - zeta * zeta), angle = std::acos(zeta), time = 2.0 * angle / q;
      const double at_peak = std::acos(zeta * (3.0 - 4.0 * zeta * zeta));
      const double peak = zeta < 0.5 ? std::exp(-zeta * at_peak / q) : 2.0 * zeta;
      const Outcome run =
          outcome(lone_mass("mass = 1\n" + contact("spring_damper", 1.0, 2.0 * zeta), 1.0, time + 0.5, method));
      expect_impact(run, {time, std::exp(-zeta * time), std::exp(-zeta * angle / q), peak}, 1.0);
    }
}

// At zeta = 1 and 2 the force begins at its peak, 2 zeta. Contact times and restitutions of the closed forms.
TEST(LoneMass, MayBeDampedBeyondTheCritical) {
  for (const char* method : linear_methods) {
    SCOPED_TRACE(method);
    expect_impact(outcome(lone_mass("mass = 1\n" + contact("spring_damper", 1.0, 2.0), 1.0, 3.0, method)),
                  {2.0, std::exp(-2.0), std::exp(-1.0), 2.0}, 1.0);
    const double q = std::sqrt(3.0), growth = std::acosh(2.0) / q;
    expect_impact(outcome(lone_mass("mass = 1\n" + contact("spring_damper", 1.0, 4.0), 1.0, 3.0, method)),
                  {2.0 * growth, std::exp(-4.0 * growth), std::exp(-2.0 * growth), 4.0}, 1.0);
  }
}

// d = (5/4)^(2/5), T = 2 sqrt(pi) Gamma(7/5) / Gamma(9/10) d / V; it leaves as it came.
TEST(LoneMass, OnAHertzContactTakesTheTimeOfGammaFunctions) {
  const double deepest = std::pow(1.25, 0.4);
  const double time = 2.0 * std::sqrt(std::numbers::pi) * std::tgamma(1.4) / std::tgamma(0.9) * deepest;
  EXPECT_NEAR(time / deepest, 2.9432751843, 1e-10);
  for (const char* method : all_methods) {
    SCOPED_TRACE(method);
    expect_impact(outcome(lone_mass("mass = 1\n" + contact("hertz", 1.0), 1.0, time + 0.5, method)),
                  {time, 1.0, deepest, std::pow(deepest, 1.5)}, 1.0);
  }
}

// a (1 + e) = ln((1 + a) / (1 - a e)) with a = lambda V; d^(5/2) = (5/2) (a - ln(1 + a)) / lambda^2; the time by
// quadrature, made apart.
TEST(LoneMass, OfHuntAndCrossleyLeavesWithTheRestitutionOfItsEquation) {
  struct Row {
    double lambda, restitution, deepest, time;
  };
  for (const auto& [lambda, restitution, deepest, time] :
       {Row{0.15, 0.90901574135, 1.0529070269, 3.2516213297}, Row{0.45, 0.76799978908, 0.98721819256, 3.3252981032},
        Row{0.75, 0.6629622, 0.93536123076, 3.4053359602}, Row{1.05, 0.58128804181, 0.89281937262, 3.4900902237},
        Row{1.5, 0.48774125602, 0.84097218506, 3.6240222332}})
    for (const char* method : all_methods) {
      SCOPED_TRACE(fmt::format("{} lambda {}", method, lambda));
      double low = 0.0, high = std::min(1.0, 1.0 / lambda);
      for (int k = 0; k < 100; ++k) {
        const double e = 0.5 * (low + high), a = lambda;
        (std::log((1.0 + a) / (1.0 - a * e)) < a * (1.0 + e) ? low : high) = e;
      }
      EXPECT_NEAR(low, restitution, 1e-7);
      const Outcome run = outcome(lone_mass("mass = 1\n" + contact("hunt_crossley", 1.0, lambda), 1.0, 4.5, method));
      ASSERT_EQ(run.events.size(), 2u);
      EXPECT_NEAR(contact_time(run), time, close_enough * time);
      EXPECT_NEAR(run.events[1].velocity, low, close_enough);
      EXPECT_NEAR(-run.statistics.account->left.lowest, deepest, close_enough);
      EXPECT_NEAR(run.statistics.energy->balance_error(), 0.0, close_enough);
      EXPECT_NEAR(run.statistics.energy->dissipated, 0.5 * (1.0 - low * low), close_enough);
    }
}

// Code_Aster's test SDND101: a mass of 100 on a spring of 1e4 meets a stop of 1e6 at speed 1.
TEST(LoneMass, OnASpringMeetsAStopAsInSdnd101) {
  for (const char* method : linear_methods) {
    SCOPED_TRACE(method);
    const Outcome run =
        outcome(lone_mass("mass = 100\nstiffness = 1e4\n" + contact("spring_damper", 1e6), 1.0, 0.2, method));
    ASSERT_EQ(run.events.size(), 2u);
    EXPECT_NEAR(contact_time(run), 0.0312600152683, close_enough * 0.03126);
    EXPECT_NEAR(run.statistics.account->left.peak_reaction, 9950.3719021, close_enough * 9950);
  }
}

// x'' = f - max(0, x + 2 zeta x') while x > 0, else f: it opens by its force, and a force presses it in again before or
// after it has left. The numbers are of an integration made apart.
TEST(LoneMass, ThatIsPressedComesBackToASurfaceThatHasRelaxed) {
  for (const auto& [zeta, force, opening, second] :
       {std::array{0.2, 0.3, 3.81331811, 6.08112506}, {0.3, 0.1, 3.013115044, 10.622120392}})
    for (const char* method : linear_methods) {
      SCOPED_TRACE(fmt::format("{} zeta {} force {}", method, zeta, force));
      const Outcome run =
          outcome(lone_mass(fmt::format("mass = 1\nforce = {}\n", -force) + contact("spring_damper", 1.0, 2.0 * zeta),
                            1.0, second + 0.2, method));
      ASSERT_GE(run.events.size(), 3u);
      EXPECT_NEAR(run.events[1].time, opening, 1e-8);
      EXPECT_EQ(run.events[2].change, Change::closing);
      EXPECT_NEAR(run.events[2].time, second, 1e-8);
      EXPECT_NEAR(run.statistics.energy->balance_error(), 0.0, close_enough);
    }
  for (const auto& [zeta, force] : {std::array{0.3, 0.4}, {0.2, 0.5}})
    for (const char* method : linear_methods) {
      SCOPED_TRACE(fmt::format("{} zeta {} force {}", method, zeta, force));
      const Outcome run =
          outcome(lone_mass(fmt::format("mass = 1\nforce = {}\n", -force) + contact("spring_damper", 1.0, 2.0 * zeta),
                            1.0, 40.0, method));
      EXPECT_EQ(run.events.size(), 1u);
    }
}

// x'' = f - N with f = 0.9 away from the stop, lambda = 4: it gains the speed 1 / lambda inside, where the stop would
// pull beyond it. By formulas of order 4 on 2^15 steps, and the zero of 1 + lambda d' on the last.
TEST(LoneMass, ThatIsPulledOutFasterThanItsStopFollowsIsLetGo) {
  const double lambda = 4.0, pull = 0.9, h = 0x1p-14;
  double d = 0.0, v = 1.0, t = 0.0, before = v;
  const auto rate = [&](double depth, double speed) {
    return -pull - std::pow(std::max(depth, 0.0), 1.5) * (1.0 + lambda * speed);
  };
  for (; 1.0 + lambda * v > 0.0; t += h) {
    before = v;
    const double a1 = rate(d, v), v2 = v + 0.5 * h * a1, a2 = rate(d + 0.5 * h * v, v2), v3 = v + 0.5 * h * a2,
                 a3 = rate(d + 0.5 * h * v2, v3), v4 = v + h * a3, a4 = rate(d + h * v3, v4);
    d += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4), v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  ASSERT_GT(d, 0.01);
  const double opens = t - h * (1.0 / lambda + v) / (v - before);  // v falls; it is linear within h to h^2
  for (const char* method : all_methods) {
    SCOPED_TRACE(method);
    const Outcome run = outcome(lone_mass(
        fmt::format("mass = 1\nforce = {}\n", pull) + contact("hunt_crossley", 1.0, lambda), 1.0, opens + 0.5, method));
    ASSERT_EQ(run.events.size(), 2u);
    EXPECT_NEAR(run.events[1].time, opens, h * h);
    EXPECT_NEAR(run.events[1].velocity, 1.0 / lambda, close_enough);
    EXPECT_NEAR(run.statistics.energy->balance_error(), 0.0, close_enough);
  }
}

}  // namespace
}  // namespace viscobar::laws
