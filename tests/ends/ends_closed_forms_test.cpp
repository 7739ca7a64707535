// Inputs of ends against closed forms: forces, springs, dashpots, motion and obstacles that move.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "ends/closed_forms.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

constexpr double pi = std::numbers::pi;
using namespace closed_forms;

// A wave that an end sends, which the free other end returns as it is, and the first end with `sign`.
double train(const std::function<double(double)>& f, double sign, double x, double t) {
  double sum = 0.0, factor = 1.0;
  for (int n = 0; 2 * n * length / c < t; ++n, factor *= sign)
    for (const double way : {x + 2 * n * length, 2 * (n + 1) * length - x})
      if (t > way / c) sum += factor * f(t - way / c);
  return sum;
}

// v = F / (rho c) behind the front, and twice that from each return on.
TEST(EndForce, SendsTheWaveFOverRhoCAndItsEchoes) {
  const auto impulse = [](double t) {
    return (2.5 * t - 15.0 / 8 * std::sin(2 * t) + 3.0 / 8 * std::sin(4 * t) - std::sin(6 * t) / 24) / impedance;
  };
  for (const auto& [method, mass, order] : all_orders) {
    SCOPED_TRACE(method + " " + mass);
    for (const bool right : {false, true}) {
      const auto scene = [&, method = method, mass = mass](int n) {
        return fmt::format("{}[{}]\nkind = \"free\"\nforce = \"(1-cos(2*t))^3\"\n{}", bar, right ? "right" : "left",
                           numerics(n, mass, method, 3.0));
      };
      expect_order(
          order, scene, [&](double x, double t) { return train(impulse, 1.0, right ? length - x : x, t); }, 12);
    }
  }
}

// Characteristics have no mesh: to rounding.
TEST(EndForce, AndMotionAreExactByCharacteristics) {
  const auto impulse = [](double t) {
    return (2.5 * t - 15.0 / 8 * std::sin(2 * t) + 3.0 / 8 * std::sin(4 * t) - std::sin(6 * t) / 24) / impedance;
  };
  const auto d = [](double t) { return 0.05 * std::pow(1 - std::cos(2 * t), 4); };
  const auto by_waves = [](const std::string& end) {
    return record(parse_scene(bar + end + numerics(8, "consistent", "characteristics", 6.0), "").run);
  };
  for (const bool right : {false, true}) {
    const std::string table = right ? "[right]\n" : "[left]\n";
    const Recording forced = by_waves(table + "kind = \"free\"\nforce = \"(1-cos(2*t))^3\"\n");
    EXPECT_LT(error(forced, [&](double x, double t) { return train(impulse, 1.0, right ? length - x : x, t); }), 1e-13);
    EXPECT_NEAR(forced.statistics.energy->balance_error(), 0.0, 1e-12);
    EXPECT_GT(forced.statistics.energy->work, 1.0);
    const Recording moved = by_waves(table + "kind = \"fixed\"\nmotion = \"0.05*(1-cos(2*t))^4\"\n");
    EXPECT_LT(error(moved, [&](double x, double t) { return train(d, -1.0, right ? length - x : x, t); }), 1e-13);
    EXPECT_NEAR(moved.statistics.energy->balance_error(), 0.0, 1e-12);
    const EndAccount& end = right ? moved.statistics.account->right : moved.statistics.account->left;
    EXPECT_NEAR(end.highest, 0.05 * 16, 1e-14);
    EXPECT_NEAR(end.lowest, 0.0, 1e-15);
    const std::string other = right ? "[left]\n" : "[right]\n";
    const Recording taken = by_waves(other + "kind = \"free\"\ndashpot = 3\n" + table +
                                     "kind = \"free\"\nforce = \"t < 2 ? sin(pi*t/2) : 0\"\n");
    EXPECT_NEAR(taken.statistics.energy->final, 0.0, 1e-15);
    EXPECT_NEAR(taken.statistics.energy->work, 1.0 / impedance, 1e-14);  // int F^2 / Z dt
    EXPECT_NEAR(taken.statistics.energy->dissipated, 1.0 / impedance, 1e-14);
  }
}

// A force that is always the same pulls the other end's fixed bar by F L / E on average, to and fro between 0 and
// twice that: u(0, t) is the triangle of period 4 L / c.
TEST(EndForce, ThatIsSteadyMovesAFixedBarBetweenZeroAndTwiceItsStaticPull) {
  const auto run = parse_scene(fmt::format("{}[left]\nkind = \"free\"\nforce = 0.5\n[right]\nkind = \"fixed\"\n{}", bar,
                                           numerics(128, "lumped", "finite_difference", 8 * length / c)),
                               "")
                       .run;
  Case magic = run;
  magic.step = length / 128 / c;  // (3.25) carries waves exactly at dt = h / c, but for its implicit mean
  const Recording done = record(magic);
  const double pull = 0.5 * length / modulus;
  for (std::size_t k = 0; k < done.times.size(); ++k) {
    const double phase = std::fmod(done.times[k] * c / length, 4.0);
    if (std::abs(phase - 2.0) < 0.4 || std::abs(phase - 2.0) > 1.6) continue;  // dispersion rounds the corners off
    // The scheme's start is of first order: its velocity F / Z sets in up to a step late, and so do the echoes.
    EXPECT_NEAR(done.displacement(k)[0], pull * std::min(phase, 4.0 - phase), 2.0 * 0.5 / impedance * *magic.step)
        << done.times[k];
  }
  EXPECT_NEAR(done.statistics.account->left.highest, 2.0 * pull, 0.02 * pull);
}

// u = cos(kappa (L - x)) cos(kappa c t) with kappa tan(kappa L) = k / E.
TEST(EndSpring, GivesTheBarTheFrequencyOfItsTranscendentalEquation) {
  const double stiffness = 7.0;
  double low = 0.0, high = pi / (2 * length);
  for (int k = 0; k < 80; ++k) {
    const double kappa = (low + high) / 2;
    (kappa * std::tan(kappa * length) < stiffness / modulus ? low : high) = kappa;
  }
  const double kappa = low;
  const auto u = [&](double x, double t) { return std::cos(kappa * (length - x)) * std::cos(kappa * c * t); };
  for (const auto& [method, mass, order] : all_orders) {
    SCOPED_TRACE(method + " " + mass);
    const auto scene = [&, method = method, mass = mass](int n) {
      return fmt::format(
          "{}[left]\nkind = \"free\"\nstiffness = {}\n[initial]\ndisplacement = \"cos({:.17g}*(1.25-x))\"\n{}", bar,
          stiffness, kappa, numerics(n, mass, method, 3.0));
    };
    expect_order(order, scene, u, 8);
  }
}

// rho c is the impedance of the bar: nothing comes back. What is left is the error of the mesh, and the dashpot has
// taken the energy.
TEST(EndDashpot, OfTheImpedanceRhoCTakesAWaveWhole) {
  for (const auto& [method, mass, order] : all_orders) {
    if (method == "fully_discrete" || method == "finite_difference") continue;  // order 2 in time, too
    SCOPED_TRACE(method + " " + mass);
    double left[2];
    for (const int refined : {0, 1}) {
      const std::string text =
          fmt::format("{}[right]\nkind = \"free\"\ndashpot = {}\n[initial]\nvelocity = \"sin(pi*x/1.25)^6\"\n{}", bar,
                      impedance, numerics(20 << refined, mass, method, 2.5 * length / c));
      const Recording done = record(parse_scene(text, "").run);
      const EnergyAccount& energy = done.statistics.energy.value();
      left[refined] = energy.final / energy.initial;
      EXPECT_NEAR(energy.dissipated, energy.initial - energy.final, 1e-7 * energy.initial);
    }
    EXPECT_LT(left[1], 1e-4);
    EXPECT_GT(std::log2(left[0] / left[1]), 2.0 * order - 0.8) << left[0] << " " << left[1];  // energy: the square
  }
}

TEST(EndMotion, OfAFixedEndSendsItsDisplacementAsAWave) {
  const auto d = [](double t) { return 0.05 * std::pow(1 - std::cos(2 * t), 4); };
  for (const auto& [method, mass, order] : all_orders) {
    SCOPED_TRACE(method + " " + mass);
    for (const bool right : {false, true}) {
      const auto scene = [&, method = method, mass = mass](int n) {
        return fmt::format("{}[{}]\nkind = \"fixed\"\nmotion = \"0.05*(1-cos(2*t))^4\"\n{}", bar,
                           right ? "right" : "left", numerics(n, mass, method, 3.0));
      };
      expect_order(
          order, scene, [&](double x, double t) { return train(d, -1.0, right ? length - x : x, t); },
          order > 2 ? 48 : 16);
    }
  }
}

// Behind the front of a ramp that holds at t = 0.5 the strain is -V / c, then 0: kinks of the motion are jumps of the
// velocity, which a mesh shows with its own oscillations but loses no energy by.
TEST(EndMotion, WithKinksDoesTheWorkOfTheWavesThatItSends) {
  const double speed = 0.4, hold = 0.5;
  for (const std::string method : {"cvode", "ida", "arkode", "odeint", "rigid", "exponential", "fully_discrete"})
    for (const std::string mass : {"consistent", "fourth_order"}) {
      const std::string text = fmt::format("{}[right]\nkind = \"fixed\"\nmotion = \"min({}*t,{})\"\n{}", bar, speed,
                                           speed * hold, numerics(100, mass, method, 0.8));
      const Recording done = record(parse_scene(text, "").run);
      const EnergyAccount& energy = *done.statistics.energy;
      // Half of the work is kinetic, half elastic, on the stretch c * hold of the wave: rho V^2 c hold.
      const double work = density * speed * speed * c * hold;
      EXPECT_NEAR(energy.work, work, 0.03 * work) << method << " " << mass;
      EXPECT_NEAR(energy.balance_error(), 0.0, 1e-8 * work) << method << " " << mass;
      EXPECT_EQ(done.displacement(done.times.size() - 1).back(), speed * hold);
      EXPECT_NEAR(done.statistics.account->right.highest, speed * hold, 1e-12);
    }
}

// Both ends in motion by the same d: the bar between them is one in a shaken box. u = d - v, v fixed at both ends
// under the load rho d'', here in resonance with nothing: d = a sin^2 gives v in closed form by its modes.
TEST(EndMotion, OfBothEndsAlikeIsALoadOnTheBarBetweenThem) {
  const std::string shaken = "motion = \"0.2*sin(3*t)^2\"\n";
  const std::string moved =
      fmt::format("{}viscosity = 0.05\n[left]\nkind = \"fixed\"\n{}[right]\nkind = \"fixed\"\n{}{}", bar, shaken,
                  shaken, numerics(10, "consistent", "cvode", 2.0));
  // d'' = 0.2 * 18 cos(6 t)
  const std::string loaded = fmt::format(
      "{}viscosity = 0.05\n[left]\nkind = \"fixed\"\n[right]\nkind = \"fixed\"\n[load]\nprofile = \"-2\"\nhistory = "
      "\"3.6*cos(6*t)\"\n{}",
      bar, numerics(10, "consistent", "cvode", 2.0));
  const Recording a = record(parse_scene(moved, "").run), b = record(parse_scene(loaded, "").run);
  for (std::size_t k = 0; k < a.times.size(); ++k)
    for (std::size_t j = 0; j < a.mesh.nodes(); ++j) {
      const double s = std::sin(3 * a.times[k]);
      EXPECT_NEAR(a.displacement(k)[j], b.displacement(k)[j] + 0.2 * s * s, 1e-9);
    }
}

// Who moves along at a constant velocity sees the same impact.
TEST(MovingObstacle, AtAConstantVelocityIsOneAtRestForWhoMovesAlong) {
  for (const std::string method : {"cvode", "ida", "arkode", "odeint", "rigid", "exponential", "fully_discrete",
                                   "finite_difference", "characteristics"})
    for (const bool above : {false, true})
      for (const bool other : {false, true}) {  // the other end: free, or an obstacle that stands still for it, too
        SCOPED_TRACE(method + (above ? " above" : " below") + (other ? " two" : ""));
        const auto scene = [&](double speed) {
          const double s = above ? -1.0 : 1.0;
          const auto table = [&](const char* end, double sign, const char* side) {
            return fmt::format("[{}]\nkind = \"obstacle\"\nside = \"{}\"\ngap = \"0.1-({})*t\"\n", end, side,
                               sign * speed);
          };
          return fmt::format(
              "{}viscosity = {}\n{}{}[initial]\nvelocity = \"{}*(-1-0.3*x)+{}\"\n[contact]\nepsilon = 1e-3\n{}", bar,
              method == "characteristics" ? 0.0 : 0.05, table("left", s, above ? "above" : "below"),
              other ? table("right", s, above ? "above" : "below") : "", s, speed,
              numerics(10, "consistent", method, 2.0));
        };
        const Recording a = record(parse_scene(scene(0.0), "").run), b = record(parse_scene(scene(0.75), "").run);
        ASSERT_EQ(a.events.size(), b.events.size());
        ASSERT_GE(a.events.size(), 2u);
        for (std::size_t k = 0; k < a.events.size(); ++k) {
          EXPECT_NEAR(a.events[k].time, b.events[k].time, 1e-7);
          EXPECT_NEAR(a.events[k].velocity + 0.75, b.events[k].velocity, 1e-6);
        }
        for (std::size_t k = 0; k < a.times.size(); ++k)
          for (std::size_t j = 0; j < a.mesh.nodes(); ++j)
            EXPECT_NEAR(a.displacement(k)[j] + 0.75 * a.times[k], b.displacement(k)[j], 1e-8);
        EXPECT_NEAR(a.statistics.account->left.impulse, b.statistics.account->left.impulse, 1e-7);
        EXPECT_NEAR(a.statistics.account->left.peak_reaction, b.statistics.account->left.peak_reaction, 1e-5);
        EXPECT_NEAR(a.statistics.energy->dissipated, b.statistics.energy->dissipated, 1e-7);
        // The obstacles' work is their impulse times their velocity.
        const double impulse = b.statistics.account->left.impulse + b.statistics.account->right.impulse;
        EXPECT_NEAR(b.statistics.energy->work, 0.75 * impulse, 2e-6) << method;
        EXPECT_NEAR(b.statistics.energy->balance_error(), 0.0, 1e-6);
      }
}

// Characteristics against the mesh: a vibrating stop under a bar that is pushed, on one side and the other.
TEST(MovingObstacle, UnderAPushedBarIsTheLimitOfTheMeshByCharacteristics) {
  for (const bool above : {false, true}) {
    const auto scene = [&](int n, const std::string& method) {
      const int s = above ? -1 : 1;
      return fmt::format(
          "{}[{}]\nkind = \"obstacle\"\nside = \"{}\"\ngap = \"0.2+0.1*sin(2*t)^2\"\nforce = \"{}*0.5*sin(t)\"\ndashpot "
          "= 0.5\n[{}]\nkind = \"fixed\"\nmotion = \"{}*0.1*sin(t)^2\"\n{}",
          bar, above ? "right" : "left", above ? "above" : "below", -s, above ? "left" : "right", -s,
          numerics(n, "fourth_order", method, 4.0));
    };
    const Recording exact = record(parse_scene(scene(160, "characteristics"), "").run);
    ASSERT_GE(exact.events.size(), 2u);
    const Recording coarse = record(parse_scene(scene(40, "rigid"), "").run);
    const Recording fine = record(parse_scene(scene(160, "rigid"), "").run);
    const auto off = [&](const Recording& one) {
      double most = 0.0;
      for (std::size_t k = 0; k < one.times.size(); ++k)
        for (const bool left : {false, true}) {
          const auto a = one.displacement(k), b = exact.displacement(k);
          most = std::max(most, std::abs(left ? a.front() - b.front() : a.back() - b.back()));
        }
      return most;
    };
    // Bounds that follow from ends that are wrong by as much as on the coarse mesh.
    const double wrong = off(coarse), dashpot = 0.5, duration = 4.0;
    EXPECT_LT(off(fine), 0.5 * wrong);
    // The touch: by that over the speed against the obstacle.
    const Event& touch = exact.events.front();
    const double speed = std::abs((above ? -1.0 : 1.0) * touch.velocity + 0.2 * std::sin(4.0 * touch.time));
    EXPECT_NEAR(fine.events.front().time, touch.time, wrong / speed);
    // The impulse: R = (Z + c) V - (Z w + F), whose integral is Z and c times displacements, and begins with a jump of
    // Z times that speed.
    const double impulse = (2.0 * impedance + dashpot) * wrong;
    // The work: F u, by parts, with |F| and |F'| up to 0.5; the reaction times the speed of the obstacle, up to 0.2;
    // the stress at the moved end, Z (2 w - d'), times its speed, up to 0.1.
    const double work = 0.5 * (1.0 + duration) * wrong + 0.2 * impulse + 0.1 * 2.0 * impedance * wrong;
    EXPECT_NEAR(fine.statistics.energy->work, exact.statistics.energy->work, work);
    // The dashpot: c v^2, by parts, 2 c |v| and 2 c |v'| times that; both are about 1 at most.
    EXPECT_NEAR(fine.statistics.energy->dissipated, exact.statistics.energy->dissipated,
                2.0 * dashpot * (1.0 + duration) * wrong);
    EXPECT_NEAR(exact.statistics.energy->balance_error(), 0.0, 1e-12);
    const EndAccount& p = above ? exact.statistics.account->right : exact.statistics.account->left;
    const EndAccount& q = above ? fine.statistics.account->right : fine.statistics.account->left;
    EXPECT_NEAR(p.impulse, q.impulse, impulse);
    EXPECT_NEAR(p.lowest, q.lowest, wrong);
    EXPECT_NEAR(p.highest, q.highest, wrong);
  }
}

// A ball on a shaken table: a bar of period 2 L / c far below that of its contact's spring is rigid, and a spring with
// a dashpot that is closed for half its period gives it back e = exp(-pi zeta / sqrt(1 - zeta^2)) of its velocity.
// Between impacts it flies under its weight g: with t_k and w_k the time and velocity after the impact k,
//
//     w_k (t - t_k) - g (t - t_k)^2 / 2 = z(t) - z(t_k),     w_{k+1} = -e (w_k - g (t - t_k) - z'(t)) + z'(t).
TEST(MovingObstacle, ThrowsANearlyRigidBarAsTheMapOfABouncingBallDoes) {
  const double g = 10.0, amplitude = 0.02, omega = 9.0, restitution = 0.6, epsilon = 1e-6, mass = 1.0;
  const double zeta = -std::log(restitution) / std::hypot(pi, std::log(restitution));
  const double spring = 1.0 / epsilon, contact = pi / (std::sqrt(spring / mass) * std::sqrt(1.0 - zeta * zeta));
  // The node's dashpot is 2 zeta_n sqrt(k m_n) with the node's effective mass, of one lumped element half the bar's.
  const double node = std::sqrt(mass / (mass / 2)) * zeta;
  const double node_restitution = std::exp(-pi * node / std::sqrt(1.0 - node * node));
  const auto z = [&](double t) { return amplitude * std::sin(omega * t); };
  const auto z_rate = [&](double t) { return amplitude * omega * std::cos(omega * t); };
  for (const std::string method : {"cvode", "exponential", "arkode"}) {
    const std::string text = fmt::format(
        "[bar]\nlength = 1e-3\ndensity = 1e3\nmodulus = 1e6\nviscosity = 30\n[left]\nkind = \"obstacle\"\ngap = \"0.05-0.02*sin(9*t)\"\n"
        "[load]\ndensity = -1e4\n[time]\nend = 3\n[mesh]\nelements = 1\nmass = \"lumped\"\n[contact]\nepsilon = {}\n"
        "restitution = {:.17g}\n[method]\nname = \"{}\"\nrelative_tolerance = 1e-8\n[output]\nevery = 0.5\n",
        epsilon, node_restitution, method);
    std::vector<Event> closings;
    for (const Event& event : record(parse_scene(text, "").run).events)
      if (event.change == Change::closing) closings.push_back(event);
    ASSERT_GE(closings.size(), 8u) << method;
    double t = 0.0, w = 0.0, height = 0.05;  // above the mean of the table
    for (std::size_t k = 0; k < 8; ++k) {
      const auto clear = [&](double at) { return height + w * (at - t) - g * (at - t) * (at - t) / 2 - z(at); };
      double before = t + 1e-3, after = before;
      while (clear(after) > 0.0) before = after, after += 1e-3;
      for (int halving = 0; halving < 60; ++halving) {
        const double middle = (before + after) / 2;
        (clear(middle) > 0.0 ? before : after) = middle;
      }
      const double arriving = w - g * (after - t);
      // Each impact lasts, and the table goes on meanwhile; a stable orbit forgets that but for the last impacts.
      EXPECT_NEAR(closings[k].time, after, 3.0 * contact) << method << " " << k;
      EXPECT_NEAR(closings[k].velocity, arriving, 3.0 * (g + amplitude * omega * omega) * contact)
          << method << " " << k;
      w = -restitution * (arriving - z_rate(after)) + z_rate(after);
      height = z(after);
      t = after;
    }
  }
}

}  // namespace
}  // namespace viscobar
