// Masses on the ends, against closed forms.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "ends/closed_forms.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar::end_mass {
namespace {

using namespace closed_forms;

Recording recorded(const std::string& text) { return record(parse_scene(text, "").run); }

// u = sin(kappa (L - x)) cos(kappa c t) of a bar that is fixed at L, with kappa tan(kappa L) = rho / m.
TEST(EndMass, GivesTheBarTheFrequencyOfItsTranscendentalEquation) {
  const double mass = 1.7;
  double low = 0.0, high = std::numbers::pi / (2 * length);
  for (int k = 0; k < 80; ++k) {
    const double kappa = (low + high) / 2;
    (kappa * std::tan(kappa * length) < density / mass ? low : high) = kappa;
  }
  const double kappa = low;
  const auto u = [&](double x, double t) { return std::sin(kappa * (length - x)) * std::cos(kappa * c * t); };
  for (const auto& [method, matrix, order] : all_orders) {
    SCOPED_TRACE(method + " " + matrix);
    const auto scene = [&, method = method, matrix = matrix](int n) {
      return fmt::format(
          "{}[left]\nkind = \"free\"\nmass = {}\n[right]\nkind = \"fixed\"\n[initial]\n"
          "displacement = \"sin({:.17g}*(1.25-x))\"\n{}",
          bar, mass, kappa, numerics(n, matrix, method, 3.0));
    };
    expect_order(order, scene, u, 8);
  }
  // Rows made apart have the frequency to 5e-9 on 40 elements.
  EXPECT_LT(error(recorded(fmt::format("{}[left]\nkind = \"free\"\nmass = {}\n[right]\nkind = \"fixed\"\n[initial]\n"
                                       "displacement = \"sin({:.17g}*(1.25-x))\"\n{}",
                                       bar, mass, kappa, numerics(64, "fourth_order", "rigid", 3.0))),
                  u),
            1e-8);
}

// Under F(t) = (1 - cos 2 t)^3 = sum A_k cos(w_k t) the mass moves as m v' + Z v = F until the echo returns, and the
// bar behind as that a way / c ago.
TEST(EndMass, ThatIsPushedSendsAWaveThatLagsBehindTheForce) {
  const double mass = 1.7, a = impedance / mass;
  const auto moved = [&](double t) {
    if (t <= 0.0) return 0.0;
    const double fading = 1.0 - std::exp(-a * t);
    double sum = 2.5 * (t - fading / a) / a;
    for (const auto& [amplitude, w] : {std::pair{-15.0 / 4, 2.0}, {3.0 / 2, 4.0}, {-1.0 / 4, 6.0}})
      sum += amplitude * (a * std::sin(w * t) / w + 1.0 - std::cos(w * t) - fading) / (a * a + w * w);
    return sum / mass;
  };
  for (const auto& [method, matrix, order] : all_orders) {
    for (const bool right : {false, true}) {
      SCOPED_TRACE(fmt::format("{} {} {}", method, matrix, right));
      const auto u = [&](double x, double t) {
        const double way = right ? length - x : x;
        return moved(t - way / c) + moved(t - (2 * length - way) / c);
      };
      const auto scene = [&, method = method, matrix = matrix](int n) {
        return fmt::format("{}[{}]\nkind = \"free\"\nmass = {}\nforce = \"(1-cos(2*t))^3\"\n{}", bar,
                           right ? "right" : "left", mass, numerics(n, matrix, method, 1.6));
      };
      expect_order(order, scene, u, 12);
    }
  }
  // Characteristics have no mesh: to rounding.
  for (const bool right : {false, true}) {
    const Recording run =
        recorded(fmt::format("{}[{}]\nkind = \"free\"\nmass = {}\nforce = \"(1-cos(2*t))^3\"\n{}", bar,
                             right ? "right" : "left", mass, numerics(8, "consistent", "characteristics", 1.6)));
    EXPECT_LT(error(run,
                    [&](double x, double t) {
                      const double way = right ? length - x : x;
                      return moved(t - way / c) + moved(t - (2 * length - way) / c);
                    }),
              1e-13);
    EXPECT_NEAR(run.statistics.energy->balance_error(), 0.0, 1e-12);
  }
}

// A step of velocity V that meets the mass comes back as V (1 - 2 exp(-Z t / m)) behind its front.
TEST(EndMass, ReturnsAStepAtFirstAsAFixedEndDoesAndThenAsAFreeOne) {
  const double mass = 1.7, speed = 0.25;
  const Recording run =
      recorded(fmt::format("{}[left]\nkind = \"free\"\nforce = {}\n[right]\nkind = \"free\"\nmass = {}\n{}", bar,
                           impedance * speed, mass, numerics(4, "consistent", "characteristics", 1.9 * length / c)));
  const std::size_t n = run.mesh.nodes();
  for (std::size_t k = 0; k < run.times.size(); ++k) {
    for (std::size_t j = 0; j < n; ++j) {
      const double x = run.mesh.node(j), there = run.times[k] - x / c, back = run.times[k] - (2 * length - x) / c;
      if (std::abs(there) < 1e-12 || std::abs(back) < 1e-12) continue;
      const double v =
          (there > 0.0 ? speed : 0.0) + (back > 0.0 ? speed * (1.0 - 2.0 * std::exp(-impedance * back / mass)) : 0.0);
      EXPECT_NEAR(run.velocity(k)[j], v, 1e-13) << x << " " << run.times[k];
    }
  }
}

struct Thrown {
  double mass, end, impulse;  // of the contact
};

std::string thrown(double mass, double viscosity, const std::string& rest) {
  return fmt::format(
      "[bar]\nlength = 1\nviscosity = {}\n[left]\nkind = \"obstacle\"\ngap = 0\n[right]\nkind = \"free\"\nmass = {}\n"
      "[initial]\nvelocity = -1\n[time]\nend = 4\n[output]\nevery = 0.05\n{}",
      viscosity, mass, rest);
}

// Reaction of an elastic bar with m = mu rho L behind: R = 1 for 2 L / c, then 4 exp(-(t - 2) / mu) - 1.
TEST(EndMass, BehindAThrownElasticBarPressesItThreefoldOnTheWall) {
  for (const Thrown& of : {Thrown{0.5, 2.0 + 0.5 * std::log(4.0), 2.0 + 0.5 * (3.0 - std::log(4.0))},
                           Thrown{1.0, 2.0 + std::log(4.0), 2.0 + 3.0 - std::log(4.0)}}) {
    const Recording run = recorded(thrown(of.mass, 0.0, "[method]\nname = \"characteristics\"\n"));
    ASSERT_EQ(run.events.size(), 2u);
    EXPECT_NEAR(run.events[0].time, 0.0, 1e-15);
    EXPECT_NEAR(run.events[1].time, of.end, 1e-12);
    const EndAccount& wall = run.statistics.account->left;
    EXPECT_NEAR(wall.impulse, of.impulse, 1e-12);
    EXPECT_NEAR(wall.peak_reaction, 3.0, 1e-12);
    EXPECT_NEAR(wall.latest.time, 2.0, 1e-12);
    EXPECT_NEAR(run.statistics.energy->initial, 0.5 * (1.0 + of.mass), 1e-14);
    EXPECT_NEAR(run.statistics.energy->balance_error(), 0.0, 1e-12);
  }
}

// The same of a viscous bar. The Laplace transform of the reaction is
//     R^ = sqrt(1 + eta s) (tanh q + b) / (s (1 + b tanh q)),    q = s / sqrt(1 + eta s),    b = m s / sqrt(1 + eta s).
// Talbot's contour inverted it in 40 digits.
TEST(EndMass, BehindAThrownViscousBarEndsItsContactAsTheTransformSays) {
  for (const Thrown& of :
       {Thrown{0.5, 2.7713184425724, 2.5706161402164}, Thrown{1.0, 3.5375424676568, 3.4862270876986}}) {
    double off[2];
    for (const int level : {0, 1}) {
      const Recording run = recorded(thrown(of.mass, 0.1,
                                            fmt::format("[mesh]\nelements = {}\nmass = \"fourth_order\"\n[contact]\n"
                                                        "restitution = 0\n[method]\nname = \"rigid\"\n"
                                                        "relative_tolerance = 1e-11\n",
                                                        50 << level)));
      ASSERT_EQ(run.events.size(), 2u);
      off[level] = std::abs(run.events[1].time - of.end) + std::abs(run.statistics.account->left.impulse - of.impulse);
    }
    EXPECT_LT(off[1], 1e-8);
    EXPECT_GT(std::log2(off[0] / off[1]), 3.5) << off[0] << " " << off[1];
  }
}

// A mass on the end that touches stops at once, with the impulse m V. The bar behind it then is thrown as without it;
// but as the end leaves, it takes the mass along.
TEST(EndMass, ThatTouchesLeavesItsMomentumToTheWall) {
  const double mass = 0.7;
  const auto scene = [&](double viscosity, const std::string& rest) {
    return fmt::format(
        "[bar]\nlength = 1\nviscosity = {}\n[left]\nkind = \"obstacle\"\ngap = 0.1\nmass = {}\n[initial]\nvelocity = -1\n"
        "[time]\nend = 4\n{}",
        viscosity, mass, rest);
  };
  const Recording waves = recorded(scene(0.0, "[method]\nname = \"characteristics\"\n"));
  ASSERT_EQ(waves.events.size(), 2u);
  EXPECT_NEAR(waves.events[0].time, 0.1, 1e-13);
  EXPECT_NEAR(waves.events[0].velocity, -1.0, 1e-13);
  EXPECT_NEAR(waves.events[1].time, 2.1, 1e-13);
  EXPECT_NEAR(waves.statistics.account->left.impulse, mass + 2.0, 1e-12);
  EXPECT_NEAR(waves.statistics.account->left.peak_reaction, 1.0, 1e-12);
  EXPECT_NEAR(waves.statistics.energy->dissipated, 0.5 * mass, 1e-12);
  EXPECT_NEAR(waves.statistics.energy->balance_error(), 0.0, 1e-12);
  // Contact of a viscous bar (1.9124710098, 1.650793636853 by its transform), as that of the bar alone.
  const Recording rigid = recorded(scene(0.1,
                                         "[mesh]\nelements = 40\nmass = \"fourth_order\"\n[contact]\nrestitution = 0\n"
                                         "[method]\nname = \"rigid\"\nrelative_tolerance = 1e-11\n"));
  ASSERT_EQ(rigid.events.size(), 2u);
  EXPECT_NEAR(rigid.events[1].time - rigid.events[0].time, 1.9124710098, 1e-5);
  EXPECT_NEAR(rigid.statistics.account->left.impulse, mass + 1.650793636853, 1e-5);
}

// Without the wall's push the mass is where it was left: the bar's stress pulls it off again within the step. Its
// impact is one of the scene, not of the mesh.
TEST(EndMass, ThatStrikesAndIsPulledOffAtOnceHasAContact) {
  const std::string scene =
      "bar.length=1\nbar.viscosity=0.0121\nbar.density=0.554\nmesh.elements=22\nmesh.mass=\"fourth_order\"\n"
      "left.kind=\"obstacle\"\nleft.gap=0.24654\nleft.mass=0.3\nright.kind=\"free\"\nright.stiffness=2\nright.dashpot=0.1\n"
      "initial.velocity=\"-cos(pi*x)\"\nload.profile=\"1+x\"\nload.history=\"sin(3*t)\"\ntime.end=0.3\n";
  const Recording rigid = recorded(scene + "method.name=\"rigid\"\nmethod.relative_tolerance=1e-9\n");
  const Recording scheme = recorded(scene + "method.name=\"fully_discrete\"\nmethod.step=1e-5\n");
  ASSERT_EQ(rigid.events.size(), 2u);
  EXPECT_EQ(rigid.events[0].change, Change::closing);
  EXPECT_EQ(rigid.events[1].change, Change::opening);
  EXPECT_NEAR(rigid.events[0].time, scheme.events[0].time, 2e-5);  // a scheme's step, and how late it is
  EXPECT_NEAR(rigid.events[0].velocity, scheme.events[0].velocity, 1e-4);
  EXPECT_LT(rigid.events[0].velocity, -0.8);
  const double struck = *rigid.events[1].impulse - *rigid.events[0].impulse;
  EXPECT_GT(struck, 0.3 * 0.8);  // the mass alone
}

TEST(EndMass, IsRefusedWhereNothingFeelsIt) {
  const auto message = [](const std::string& text) -> std::string {
    try {
      parse_scene(text, "scene");
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  };
  const std::string rest = "[time]\nend = 1\n[initial]\nvelocity = 1\n";
  EXPECT_NE(message("[bar]\nlength = 1\n[left]\nkind = \"fixed\"\nmass = 1\n" + rest).find("left.mass"),
            std::string::npos);
  EXPECT_NE(message("[bar]\nlength = 1\n[left]\nkind = \"free\"\nmass = -1\n" + rest).find("left.mass"),
            std::string::npos);
  const std::string redistributed = message(
      "[bar]\nlength = 1\nviscosity = 0.1\n[left]\nkind = \"obstacle\"\ngap = 1\nmass = 1\n[mesh]\n"
      "mass = \"redistributed\"\n" +
      rest);
  EXPECT_NE(redistributed.find("mesh.mass"), std::string::npos) << redistributed;
  EXPECT_EQ(parse_scene("[bar]\nlength = 1\n[left]\nkind = \"obstacle\"\ngap = 1\nmass = 1\n[contact]\nepsilon = 1e-3\n"
                        "[method]\nname = \"cvode\"\n" +
                            rest,
                        "")
                .run.scene.left_input.mass,
            1.0);
}

}  // namespace
}  // namespace viscobar::end_mass
