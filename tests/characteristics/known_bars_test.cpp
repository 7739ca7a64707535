// The method against bars whose motion is known in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "characteristics/followed.hpp"

namespace viscobar {
namespace {

constexpr double rounding = std::numeric_limits<double>::epsilon();

Scene at_rest(double length) {
  Scene scene;
  scene.bar.length = length;
  scene.displacement = scene.velocity = [](double) { return 0.0; };
  return scene;
}

// Doyen, Ern and Piperno: contact from 1 to 5/3, from 11/3 to 13/3, period 16/3; bounds of some hundred roundings.
Scene bouncing() {
  Scene scene = at_rest(10.0);
  scene.bar.modulus = 900.0;
  scene.left = Obstacle{5.0};
  scene.load = SteadyLoad{[](double) { return -10.0; }};
  return scene;
}

TEST(KnownBar, BouncesForTenPeriodsAsInClosedForm) {
  const Followed run = followed(bouncing(), equal_times(160.0 / 3.0, 1600));
  ASSERT_EQ(run.events.size(), 40u);
  for (std::size_t k = 0; k < 40; ++k) {
    constexpr double changes[] = {1.0, 5.0 / 3.0, 11.0 / 3.0, 13.0 / 3.0};
    EXPECT_NEAR(run.events[k].time, 16.0 / 3.0 * static_cast<double>(k / 4) + changes[k % 4], 1e-12) << k;
    EXPECT_EQ(run.events[k].change, k % 2 == 0 ? Change::closing : Change::opening);
  }
  // Free fall, contact, and from 5/3 on the end is sent up at the speed 10/3: it decelerates by jumps of 20/3 each 2/3.
  for (std::size_t k = 0; k < run.times.size(); ++k) {
    const double t = std::fmod(run.times[k], 16.0 / 3.0);
    if (t <= 1.0) {
      EXPECT_NEAR(run.u[k][0], -5.0 * t * t, 5e-11) << run.times[k];
    }
    if (t >= 1.0 && t <= 5.0 / 3.0) {
      EXPECT_NEAR(run.u[k][0], -5.0, 5e-11);
    }
  }
  EXPECT_NEAR(run.statistics.account->left.impulse, 20.0 * 800.0 / 3.0, 1e-9);
  EXPECT_NEAR(run.statistics.account->left.peak_reaction, 500.0, 1e-10);
}

TEST(KnownBar, VibratesInANonsmoothMode) {
  for (const double period : {3.1, 3.25, 3.5, 3.9}) {
    const double gap = 0.1, speed = gap / (2.0 * (period - 3.0)), a = 2.0 - period / 2.0;
    Scene scene = at_rest(1.0);
    scene.left = Obstacle{gap};
    scene.right = Fixed{};
    scene.displacement = [=](double x) {
      return x < a ? -gap - 2.0 * speed * x : -gap - 4.0 * speed * a + 2.0 * speed * x;
    };
    const Followed run = followed(scene, equal_times(10.0 * period, 1000));
    ASSERT_EQ(run.events.size(), 21u) << period;
    double highest = -1.0;
    for (std::size_t k = 0; k < run.times.size(); ++k) {
      highest = std::max(highest, run.u[k][0]);
      const double t = std::fmod(run.times[k], period);
      if (t > 1e-9 && (t < a - 1e-9 || (t > period - a + 1e-9 && t < period - 1e-9))) {
        EXPECT_NEAR(run.reaction_left[k], 2.0 * speed, 1e-12) << run.times[k];
      }
    }
    for (std::size_t k = 1; k < run.events.size(); ++k) {
      const double start = period * static_cast<double>(k / 2);
      EXPECT_NEAR(run.events[k].time, k % 2 == 1 ? start + a : start - a, 1e-12);
    }
    EXPECT_LE(highest, -gap + 2.0 * speed * (period / 2.0 - a) + 1e-12);
    EXPECT_NEAR(run.statistics.energy->initial, 2.0 * speed * speed, 1e-14 * speed * speed + 1e-15);
    EXPECT_NEAR(run.statistics.energy->final, 2.0 * speed * speed, 1e-13 * speed * speed + 1e-15);
  }
}

// Siconos' ImpactingBar and Code_Aster's SDNV100: contact for 2 L / c at the reaction rho c v.
TEST(KnownBar, OfSteelHitsForTwoPassages) {
  struct Steel {
    Bar bar;
    double gap, speed;
  };
  for (const auto& [bar, gap, speed] :
       {Steel{{0.99, 7800.0, 210e9, 0.0}, 5e-5, 0.1}, Steel{{0.2, 8000.0, 2e11, 0.0}, 2e-3, 100.0}}) {
    Scene scene = at_rest(bar.length);
    scene.bar = bar;
    scene.left = Obstacle{gap};
    scene.velocity = [v = speed](double) { return -v; };
    const double c = bar.wave_speed(), contact = 2.0 * bar.length / c, touch = gap / speed;
    const Followed run = followed(scene, {0.0, 0.5 * touch, touch + 2.0 * contact}, 3);
    ASSERT_EQ(run.events.size(), 2u);
    EXPECT_NEAR(run.events[0].time, touch, 1e-12 * touch);
    EXPECT_NEAR(run.events[1].time - run.events[0].time, contact, 1e-12 * contact);
    EXPECT_NEAR(run.statistics.account->left.impulse, 2.0 * bar.density * bar.length * speed,
                1e-9 * bar.density * bar.length * speed);
    EXPECT_NEAR(run.statistics.account->left.peak_reaction, bar.density * c * speed, 1e-12 * bar.density * c * speed);
    for (const double v : run.v.back()) EXPECT_NEAR(v, speed, 1e-12 * speed);
    EXPECT_NEAR(run.events[0].velocity, -speed, 1e-12 * speed);
    EXPECT_NEAR(run.events[1].velocity, speed, 1e-12 * speed);
  }
}

// d'Alembert: u = sin(pi x) cos(pi t) between fixed ends, cos(pi x) cos(pi t) between free ones.
TEST(KnownBar, SwingsInItsModes) {
  for (const bool fixed : {true, false}) {
    Scene scene = at_rest(1.0);
    if (fixed) scene.left = scene.right = Fixed{};
    scene.displacement = [fixed](double x) {
      return fixed ? std::sin(std::numbers::pi * x) : std::cos(std::numbers::pi * x);
    };
    const Followed run = followed(scene, equal_times(7.3, 50), 16);
    for (std::size_t k = 0; k < run.times.size(); ++k)
      for (std::size_t j = 0; j <= 16; ++j)
        EXPECT_NEAR(run.u[k][j],
                    scene.displacement(static_cast<double>(j) / 16) * std::cos(std::numbers::pi * run.times[k]), 1e-14);
  }
}

// Under f = f_0 sin(omega t) sin(pi x) the mode between fixed ends swings as an oscillator; each kind of load says so.
TEST(KnownBar, UnderALoadOfEachKindSwingsAsAnOscillator) {
  const double pi = std::numbers::pi, omega = 2.3;
  const auto shape = [pi](double x) { return std::sin(pi * x); };
  const auto forced = [=](double t) {
    return (std::sin(omega * t) - omega / pi * std::sin(pi * t)) / (pi * pi - omega * omega);
  };
  Scene scene = at_rest(1.0);
  scene.left = scene.right = Fixed{};
  const auto largest_error = [&](const auto& exact) {
    const Followed run = followed(scene, equal_times(7.9, 40), 16);
    double off = 0.0;
    for (std::size_t k = 0; k < run.times.size(); ++k)
      for (std::size_t j = 0; j <= 16; ++j)
        off = std::max(off, std::abs(run.u[k][j] - shape(static_cast<double>(j) / 16) * exact(run.times[k])));
    const EnergyAccount& energy = *run.statistics.energy;
    EXPECT_LT(std::abs(energy.balance_error()), 1e-13 * largest_energy(energy));
    return off;
  };
  scene.load = SeparableLoad{shape, [=](double t) { return std::sin(omega * t); }};
  EXPECT_LT(largest_error(forced), 1e-13);
  scene.load = GeneralLoad{[=](double x, double t) { return std::sin(omega * t) * shape(x); }};
  EXPECT_LT(largest_error(forced), 1e-13);
  scene.load = SteadyLoad{shape};
  EXPECT_LT(largest_error([=](double t) { return (1.0 - std::cos(pi * t)) / (pi * pi); }), 1e-14);
}

TEST(KnownBar, UnderALoadThatSwitchesIsThrownAsAPointMass) {
  // Uniform: no wave. Switched on at 0.3 and off at 0.7, reversed until 1.1.
  Scene scene = at_rest(2.0);
  const auto history = [](double t) { return t < 0.3 ? 0.0 : t < 0.7 ? 1.0 : t < 1.1 ? -1.0 : 0.0; };
  const NextBreak breaks = [](double after, double until) -> std::optional<double> {
    for (const double at : {0.3, 0.7, 1.1})
      if (at > after && at < until) return at;
    return std::nullopt;
  };
  for (const bool told : {true, false}) {
    scene.load = SeparableLoad{[](double) { return 1.0; }, history, told ? breaks : NextBreak{}};
    const Followed run = followed(scene, equal_times(5.0, 20));
    for (const double u : run.u.back()) EXPECT_NEAR(u, 0.16, 1e-13);
    for (const double v : run.v.back()) EXPECT_NEAR(v, 0.0, 1e-13);
    if (!told) continue;
    scene.load = GeneralLoad{[=](double, double t) { return history(t); }, breaks};
    const Followed general = followed(scene, equal_times(5.0, 2));
    for (const double u : general.u.back()) EXPECT_NEAR(u, 0.16, 1e-13);
  }
}

TEST(KnownBar, ThatTouchesAtTheStartClosesIfItMovesInOrIsPressed) {
  Scene scene = at_rest(1.0);
  scene.left = Obstacle{0.0};
  const auto changes = [&] { return followed(scene, equal_times(1.0, 4)).events; };
  EXPECT_TRUE(changes().empty()) << "at rest";
  scene.velocity = [](double) { return 1.0; };
  EXPECT_TRUE(changes().empty()) << "leaves";
  scene.velocity = [](double) { return -1.0; };
  ASSERT_EQ(changes().size(), 1u) << "moves in";
  EXPECT_EQ(changes()[0].time, 0.0);
  EXPECT_NEAR(followed(scene, equal_times(1.0, 4)).reaction_left[0], 1.0, 1e-15);
  scene.velocity = [](double) { return 0.0; };
  scene.load = SteadyLoad{[](double) { return -1.0; }};
  ASSERT_EQ(changes().size(), 1u) << "pressed";
  EXPECT_NEAR(changes()[0].time, 0.0, 1e-13);
  // Pressed at rest it swings about the static state for ever: R = t up to 2 L / c, then back to 0.
  const Followed rest = followed(scene, equal_times(40.0, 400));
  for (std::size_t k = 0; k < rest.times.size(); ++k) {
    const double t = std::fmod(rest.times[k], 4.0);
    EXPECT_NEAR(rest.reaction_left[k], t < 2.0 ? t : 4.0 - t, 1e-12) << rest.times[k];
    EXPECT_NEAR(rest.u[k][0], 0.0, 1e-13);
  }
}

TEST(KnownBar, InItsStaticStateStaysThere) {
  Scene scene = at_rest(1.0);
  scene.left = Obstacle{0.25};
  scene.displacement = [](double x) { return -0.25 - x + 0.5 * x * x; };
  scene.load = SteadyLoad{[](double) { return -1.0; }};
  const Followed run = followed(scene, equal_times(1000.0, 200));
  for (std::size_t k = 0; k < run.times.size(); ++k) {
    EXPECT_NEAR(run.reaction_left[k], 1.0, 1e-12);
    EXPECT_NEAR(run.u[k].back(), -0.75, 1e-12);
  }
  EXPECT_EQ(run.events.size(), 1u);
}

TEST(KnownBar, ThatGrazesItsObstacleDoesNotBounce) {
  // The end swings as cos(pi t) and touches the obstacle at -1 without speed.
  Scene scene = at_rest(1.0);
  scene.displacement = [](double x) { return std::cos(std::numbers::pi * x); };
  scene.left = Obstacle{1.0};
  scene.right = Obstacle{1.0};
  const Followed run = followed(scene, equal_times(20.0, 200));
  for (std::size_t k = 0; k < run.times.size(); ++k)
    EXPECT_NEAR(run.u[k][0], std::cos(std::numbers::pi * run.times[k]), 2e-13) << run.times[k];
  EXPECT_LT(run.statistics.account->left.impulse, 1e-12);
}

TEST(KnownBar, FallsOnBothObstaclesAtOnce) {
  // Uniform speed, both ends stop at once, and leave at once when the two waves have crossed.
  Scene scene = at_rest(2.0);
  scene.left = scene.right = Obstacle{0.5};
  scene.velocity = [](double) { return -1.0; };
  const Followed run = followed(scene, equal_times(6.0, 60));
  ASSERT_EQ(run.events.size(), 4u);
  EXPECT_NEAR(run.events[0].time, 0.5, 1e-14);
  EXPECT_NEAR(run.events[1].time, 0.5, 1e-14);
  EXPECT_EQ(run.events[0].where, Where::left);
  EXPECT_EQ(run.events[1].where, Where::right);
  EXPECT_NEAR(run.events[2].time, 2.5, 1e-13);
  EXPECT_NEAR(run.events[3].time, 2.5, 1e-13);
  for (const double v : run.v.back()) EXPECT_NEAR(v, 1.0, 1e-13);
}

TEST(KnownBar, RefusesWhatItIsNotMadeFor) {
  Scene scene = at_rest(1.0);
  EXPECT_FALSE(refusal(scene, 1.0, Characteristics{}));
  scene.displacement = [](double x) { return x < 0.5 ? 0.0 : 1.0; };
  EXPECT_THROW(followed(scene, {0.0, 1.0}), std::invalid_argument);
  scene.displacement = [](double x) { return 1.0 / (x - 0.4); };
  EXPECT_THROW(followed(scene, {0.0, 1.0}), std::invalid_argument);
  scene = at_rest(1.0);
  scene.load = SeparableLoad{[](double) { return 1.0; }, [](double t) { return std::log(3.0 - t); }};
  try {
    followed(scene, {0.0, 10.0});
    FAIL();
  } catch (const IntegrationError& error) {
    EXPECT_NEAR(error.statistics.reached_time, 2.0, 1.0);
    EXPECT_NE(std::string(error.what()).find("history"), std::string::npos) << error.what();
  }
  scene = at_rest(1.0);
  scene.bar.viscosity = 0.1;
  EXPECT_NE(refusal(scene, 1.0, Characteristics{}).value().problem.find("bar.viscosity"), std::string::npos);
  EXPECT_THROW(followed(scene, {0.0, 1.0}), std::invalid_argument);
  scene = at_rest(1.0);
  scene.span = Obstacle{1.0};
  EXPECT_NE(refusal(scene, 1.0, Characteristics{}).value().problem.find("span"), std::string::npos);
}

// An end that is sqrt(x) near 0 has no polynomial pieces; the run says by how much.
TEST(KnownBar, SaysHowWellItsDataAreRepresented) {
  Scene scene = at_rest(1.0);
  scene.velocity = [](double x) { return std::sin(20.0 * x); };
  const Representation smooth = *followed(scene, {0.0, 3.0}).statistics.representation;
  EXPECT_LT(smooth.error, 1e4 * smooth.rounding);
  scene.displacement = [](double x) { return std::sqrt(std::abs(x - 0.3)); };
  const Representation rough = *followed(scene, {0.0, 3.0}).statistics.representation;
  EXPECT_GT(rough.error, smooth.error);
  EXPECT_GT(rounding, 0.0);
}

}  // namespace
}  // namespace viscobar
