// Elastic bars in line by characteristics against closed forms, to rounding: some hundred operations on numbers of size
// 1 are allowed to err by n eps.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "case/regime.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

constexpr double rounding = 500.0 * std::numeric_limits<double>::epsilon();

struct Followed {
  Mesh mesh;
  std::vector<double> times;
  std::vector<std::vector<double>> u, v, forces;
  std::vector<double> left, right;
  std::vector<EnergyState> energies;
  std::vector<Event> events;
  Statistics statistics;
};

Followed followed(const std::string& text, const char* method = "characteristics") {
  const Setup setup =
      resolve(parse_scene(text, "", std::vector<std::string>{fmt::format("method.name={}", method)}).run);
  for (const Finding& fault : faults(setup)) ADD_FAILURE() << fault.key << ' ' << fault.problem;
  Followed run;
  run.mesh = setup.mesh;
  Observers observers;
  observers.energy = observers.account = true;
  observers.snapshot = [&](const Snapshot& now) {
    run.times.push_back(now.time);
    run.u.emplace_back(now.u.begin(), now.u.end());
    run.v.emplace_back(now.v.begin(), now.v.end());
    run.forces.emplace_back(now.joint_forces.begin(), now.joint_forces.end());
    run.left.push_back(now.reaction_left), run.right.push_back(now.reaction_right);
    run.energies.push_back(*now.energy);
  };
  observers.event = [&](const Event& event) { run.events.push_back(event); };
  run.statistics = simulate(setup, setup.system(), observers);
  const EnergyAccount& energy = *run.statistics.energy;
  EXPECT_NEAR(energy.balance_error(), 0.0, 100.0 * rounding * std::max(energy.initial, std::abs(energy.work)));
  return run;
}

const Event* event(const Followed& run, std::size_t joint, Change change) {
  for (const Event& one : run.events)
    if (one.where == Where::joint && one.node == joint && one.change == change) return &one;
  return nullptr;
}

// Two bars of c = 1 and lengths 1 and l that touch, of impedances 1 and z, the first at speed 1.
std::string two_bars(double z, double length, const char* rest) {
  return fmt::format(
      "[[bar]]\nlength = 1.0\nvelocity = 1.0\nelements = 4\n[[bar]]\nlength = {0}\ndensity = {1}\nmodulus = {1}\n"
      "velocity = 0.0\nelements = 4\n[[joint]]\nkind = \"contact\"\n[time]\nend = 5.0\n[output]\nevery = 0.25\n{2}",
      length, z, rest);
}

TEST(ChainWaves, EqualBarsOfWhichTheSecondIsFixed) {
  const Followed run = followed(two_bars(1.0, 1.0, "[right]\nkind = \"fixed\"\n"));
  ASSERT_EQ(run.events.size(), 2U);
  EXPECT_EQ(run.events[0].time, 0.0);
  EXPECT_NEAR(run.events[1].time, 4.0, rounding);
  const ContactAccount& joint = run.statistics.account->joints.at(0);
  EXPECT_NEAR(joint.impulse, 2.0, rounding);
  EXPECT_NEAR(joint.peak_reaction, 0.5, rounding);
  for (std::size_t k = 1; k < run.times.size(); ++k) {
    const double t = run.times[k];
    if (std::fmod(t, 1.0) == 0.0) continue;
    EXPECT_NEAR(run.forces[k][0], t < 4.0 ? 0.5 : 0.0, rounding) << t;
    EXPECT_NEAR(run.right[k], t > 1.0 && t < 3.0 ? -1.0 : 0.0, rounding) << t;
    for (std::size_t j = 0; j < 5 && t > 4.0; ++j) EXPECT_NEAR(run.v[k][j], -1.0, rounding);
  }
}

TEST(ChainWaves, EqualFreeBarsExchangeTheirVelocities) {
  const Followed run = followed(two_bars(1.0, 1.0, ""));
  EXPECT_NEAR(run.statistics.account->joints.at(0).impulse, 1.0, rounding);
  for (std::size_t j = 0; j < 10; ++j) EXPECT_NEAR(run.v.back()[j], j < 5 ? 0.0 : 1.0, rounding);
}

TEST(ChainWaves, UnlikeFreeBarsOfEqualTransit) {
  for (const double z : {2.0, 0.5}) {
    const Followed run = followed(two_bars(z, 1.0, ""));
    const double force = z / (1.0 + z);
    const Event* opening = event(run, 1, Change::opening);
    ASSERT_TRUE(opening) << z;
    EXPECT_NEAR(opening->time, 2.0, rounding) << z;
    const ContactAccount& joint = run.statistics.account->joints.at(0);
    EXPECT_EQ(joint.closings, 1U);
    EXPECT_NEAR(joint.peak_reaction, force, rounding);
    EXPECT_NEAR(joint.impulse, 2.0 * force, rounding);
    EXPECT_NEAR(run.v.back()[1], 1.0 - 2.0 * force, rounding);
  }
}

// N = 3^-n between the returns of the first bar, while the second one's far end is silent.
TEST(ChainWaves, AHeavyBarPressesALightOneInSteps) {
  const Followed run = followed(two_bars(0.5, 10.0, ""));
  for (std::size_t k = 1; k < run.times.size(); ++k)
    if (std::fmod(run.times[k], 2.0) != 0.0) {
      EXPECT_NEAR(run.forces[k][0], std::pow(1.0 / 3.0, std::floor(run.times[k] / 2.0) + 1.0), rounding);
    }
}

TEST(ChainWaves, ARamOnALongRodDiesOut) {
  for (const char* joint : {"contact", "bonded"}) {
    const Followed run = followed(fmt::format(
        "[[bar]]\nmass = 2.0\nvelocity = 1.0\n[[bar]]\nlength = 3.0\nvelocity = 0.0\nelements = 6\n[[joint]]\n"
        "kind = \"{}\"\n[time]\nend = 6.0\n[output]\nevery = 0.5\n",
        joint));
    for (std::size_t k = 0; k < run.times.size(); ++k) {
      EXPECT_NEAR(run.v[k].front(), std::exp(-run.times[k] / 2.0), rounding) << joint << run.times[k];
      if (joint == std::string("contact") && k > 0) {
        EXPECT_NEAR(run.forces[k][0], std::exp(-run.times[k] / 2.0), rounding) << run.times[k];
      }
    }
  }
}

TEST(ChainWaves, AFixedBodyStandsStillWhateverVelocityItIsGiven) {
  const auto run = [](double given) {
    return followed(fmt::format(
        "[[bar]]\nlength = 1.0\nvelocity = 0.3\nelements = 4\n[[bar]]\nmass = 50.0\nvelocity = {}\n[[joint]]\n"
        "kind = \"spring\"\nstiffness = 10.0\ndamping = 0.1\n[right]\nkind = \"fixed\"\n[time]\nend = 0.5\n",
        given));
  };
  const Followed given = run(-1.0), still = run(0.0);
  EXPECT_EQ(given.statistics.energy->initial, still.statistics.energy->initial);
  EXPECT_NEAR(given.statistics.energy->balance_error(), 0.0, rounding);
  EXPECT_EQ(given.v.back(), still.v.back());
}

// By the wave that goes to and fro in the rod: end of contact, peak force, speed of the ram [docs/bars-in-line.md].
TEST(ChainWaves, ARamLeavesAFixedRodInTime) {
  struct Truth {
    double mass, end, peak, speed;
  };
  for (const Truth& truth : {Truth{0.5, 2.504578909722, 2.018315638889, -0.7290516938},
                             {1.0, 3.067667641618, 2.135335283237, -0.6876189398},
                             {2.0, 4.708567243668, 2.367879441171, -0.9252469967},
                             {4.0, 5.899590439603, 2.974410100884, -0.8169115516},
                             {6.0, 7.407591891269, 3.468792199798, -0.9296808541},
                             {10.0, 9.541057903838, 4.073678754045, -0.9491340614}}) {
    const Followed run = followed(fmt::format(
        "[[bar]]\nmass = {}\nvelocity = 1.0\n[[bar]]\nlength = 1.0\nvelocity = 0.0\n[[joint]]\nkind = \"contact\"\n"
        "[right]\nkind = \"fixed\"\n[mesh]\nelements = 4\n[time]\nend = {}\n",
        truth.mass, truth.end + 0.02));
    ASSERT_EQ(run.events.size(), 2U) << truth.mass;
    constexpr double printed = 1e-12;  // the digits of the truth
    EXPECT_NEAR(run.events[1].time, truth.end, printed) << truth.mass;
    EXPECT_NEAR(run.statistics.account->joints.at(0).peak_reaction, truth.peak, printed) << truth.mass;
    EXPECT_NEAR(run.v.back().front(), truth.speed, 1e-10) << truth.mass;
  }
}

// N = k V / w exp(-zeta w0 t) sin(w t), by a spring, and by a stop until it lets go.
TEST(ChainWaves, ACushionIsADampedOscillator) {
  for (const double k : {0.5, 1.0, 2.0})
    for (const char* kind : {"spring", "contact\"\nlaw = \"spring_damper"}) {
      const Followed run = followed(
          fmt::format("[[bar]]\nmass = 1.0\nvelocity = 1.0\n[[bar]]\nlength = 10.0\nvelocity = 0.0\n[[joint]]\nkind = "
                      "\"{}\"\nstiffness = {}\n[mesh]\nelements = 4\n[time]\nend = 6.0\n[output]\nevery = 0.25\n",
                      kind, k));
      const double zeta = std::sqrt(k) / 2.0, slow = std::sqrt(k) * std::sqrt(1.0 - zeta * zeta);
      const bool pushes = kind[0] == 'c';
      for (std::size_t i = 0; i < run.times.size(); ++i) {
        const double t = run.times[i], force = k / slow * std::exp(-0.5 * k * t) * std::sin(slow * t);
        EXPECT_NEAR(run.forces[i][0], pushes && t > std::numbers::pi / slow ? 0.0 : force, rounding) << kind << k << t;
      }
      if (!pushes) continue;
      const Event* opening = event(run, 1, Change::opening);
      ASSERT_TRUE(opening);
      EXPECT_NEAR(opening->time, std::numbers::pi / slow, rounding) << k;
    }
}

// A spring without mass beside it, between two bars: d' = V - 2 N / Z, N = k d + c d'.
TEST(ChainWaves, AMasslessSpecimenBetweenTwoBars) {
  constexpr double k = 10.0, c = 0.2, lambda = 2.0 * k / (1.0 + 2.0 * c);
  const Followed run = followed(fmt::format(
      "[[bar]]\nlength = 2.0\nvelocity = 1.0\nelements = 4\n[[bar]]\nlength = 3.0\nvelocity = 0.0\nelements = 4\n[[joint]]\n"
      "kind = \"spring\"\nstiffness = {}\ndamping = {}\n[time]\nend = 3.5\n[output]\nevery = 0.25\n",
      k, c));
  for (std::size_t i = 1; i < run.times.size(); ++i)
    EXPECT_NEAR(run.forces[i][0], 0.5 * (1.0 - std::exp(-lambda * run.times[i]) / (1.0 + 2.0 * c)), rounding)
        << run.times[i];
}

// A bar thrown at a wall that gives way: N = 1 - exp(-k t), and after the return of the wave x = t - 2, N = -1 +
// exp(-k x) (2 - exp(-2 k) + 2 k x).
TEST(ChainWaves, ASpringToTheGroundAndASoftStop) {
  struct Truth {
    double stiffness, damping, end, impulse;
  };
  for (const Truth& truth : {Truth{1.0, 0.0, 3.636661513131, 1.974081038227},
                             {10.0, 0.0, 2.167834698940, 1.994828839267},
                             {100.0, 0.0, 2.016783469900, 1.999482883923},
                             {10.0, 0.5, 2.1456760359, 1.9538388418},
                             {3.0, 0.5, 2.4820842402, 1.8484490369}}) {
    const Followed run = followed(fmt::format(
        "[bar]\nlength = 1.0\n[initial]\ndisplacement = 0.0\nvelocity = -1.0\n[left]\nkind = \"obstacle\"\n"
        "gap = 0.0\ncontact = {{ law = \"spring_damper\", stiffness = {}, damping = {} }}\n[mesh]\nelements = 4\n[time]\n"
        "end = 3.9\n",
        truth.stiffness, truth.damping));
    ASSERT_EQ(run.events.size(), 2U) << truth.stiffness;
    EXPECT_NEAR(run.events[1].time, truth.end, 1e-10) << truth.stiffness;
    EXPECT_NEAR(run.statistics.account->left.impulse, truth.impulse, 1e-10) << truth.stiffness;
  }
  const Followed spring = followed(
      "[bar]\nlength = 1.0\n[initial]\ndisplacement = 0.0\nvelocity = -1.0\n[left]\nkind = \"free\"\nstiffness = 3.0\n"
      "[mesh]\nelements = 4\n[time]\nend = 4.0\n[output]\nevery = 0.125\n");
  for (std::size_t i = 0; i < spring.times.size(); ++i) {
    const double t = spring.times[i], x = t - 2.0;
    const double force =
        t <= 2.0 ? 1.0 - std::exp(-3.0 * t) : -1.0 + std::exp(-3.0 * x) * (2.0 - std::exp(-6.0) + 6.0 * x);
    EXPECT_NEAR(-3.0 * spring.u[i].front(), force, 3.0 * rounding) << t;
  }
}

// tan^2 (w t) = Z1 / Z2 for two bars of transit time t, fixed at the first: the standing wave comes back as it was.
// How far away the stop is changes nothing but roundings of its depth, on whichever side of 0.
TEST(ChainWaves, AStopClosesWhateverItsClearanceIsRoundedTo) {
  for (int n = 0; n < 60; ++n) {
    const double gap = 0.3 + 0.029 * n;
    const Followed run = followed(fmt::format(
        "[bar]\nlength = 1.0\n[initial]\nvelocity = 0.9\n[right]\nkind = \"obstacle\"\nside = \"above\"\ngap = {}\n"
        "contact = {{ law = \"spring_damper\", stiffness = 400.0 }}\n[time]\nend = {}\n[mesh]\nelements = 4\n",
        gap, gap / 0.9 + 2.5));
    EXPECT_TRUE(run.statistics.completed) << gap;
    ASSERT_EQ(run.events.size(), 2U) << gap;
    EXPECT_NEAR(run.events[0].time, gap / 0.9, 10.0 * rounding) << gap;
    // N / 0.9 is 1 - exp(-k t), and behind a passage to and fro -1 + exp(-k x) (2 - exp(-2 k) + 2 k x), x = t - 2.
    const double x = run.events[1].time - run.events[0].time - 2.0;
    EXPECT_NEAR(std::exp(-400.0 * x) * (2.0 + 800.0 * x), 1.0, 1e-9) << gap;
  }
}

TEST(ChainWaves, SteppedBarsSwingAtTheirFrequency) {
  for (const double ratio : {0.5, 2.0, 4.0}) {
    const double w = std::atan(1.0 / std::sqrt(ratio)), period = 2.0 * std::numbers::pi / w;
    // c2 = 2 and twice the length; u continuous: sin(w) = a cos(w)
    const Followed run = followed(fmt::format(
        "[[bar]]\nlength = 1.0\nelements = 8\ndisplacement = \"sin({0:.17g}*x)\"\n[[bar]]\nlength = 2.0\ndensity = {1}\n"
        "modulus = {2}\nelements = 8\ndisplacement = \"{3:.17g}*cos({0:.17g}*(1-x/2))\"\n[left]\nkind = \"fixed\"\n"
        "[initial]\nvelocity = 0.0\n[time]\nend = {4:.17g}\n[output]\nevery = {5:.17g}\n",
        w, ratio / 2.0, 2.0 * ratio, std::tan(w), 10.0 * period, 0.3 * period));
    for (std::size_t k = 0; k < run.times.size(); ++k)
      for (std::size_t j = 0; j < run.mesh.nodes(); ++j)
        EXPECT_NEAR(run.u[k][j], std::cos(w * run.times[k]) * run.u[0][j], 20.0 * rounding) << ratio << ' ' << k;
  }
}

// Newton's cradle of five elastic bars: contact k presses with Z V / 2 from k - 1 to k + 1, the last bar leaves with V.
TEST(ChainWaves, ACradlePassesTheVelocityOn) {
  std::string text, joints;
  for (int k = 0; k < 5; ++k) {
    text += fmt::format("[[bar]]\nlength = 1.0\nelements = 4\nvelocity = {}\n", k == 0 ? 1 : 0);
    if (k > 0) joints += "[[joint]]\nkind = \"contact\"\n";
  }
  const Followed run = followed(text + joints + "[time]\nend = 7.0\n[output]\nevery = 0.25\n");
  for (std::size_t i = 0; i < run.times.size(); ++i) {
    const double t = run.times[i];
    if (std::fmod(t, 1.0) == 0.0) continue;
    for (std::size_t k = 1; k < 5; ++k) {
      const double from = static_cast<double>(k) - 1.0;
      EXPECT_NEAR(run.forces[i][k - 1], t > from && t < from + 2.0 ? 0.5 : 0.0, rounding) << t << ' ' << k;
    }
  }
  for (std::size_t j = 0; j < 25; ++j) EXPECT_NEAR(run.v.back()[j], j < 20 ? 0.0 : 1.0, rounding) << j;
  for (const ContactAccount& joint : run.statistics.account->joints) EXPECT_NEAR(joint.impulse, 1.0, rounding);
  const Event* opening = event(run, 4, Change::opening);
  ASSERT_TRUE(opening);
  EXPECT_NEAR(opening->time, 5.0, rounding);
}

// Three masses in touch meet as one, and momentum is kept; the last one's bar takes it from there.
TEST(ChainWaves, RigidBodiesInTouchMoveOnAsOne) {
  const Followed run = followed(
      "[[bar]]\nmass = 1.0\nvelocity = 1.0\n[[bar]]\nmass = 2.0\n[[bar]]\nmass = 3.0\n[[bar]]\nlength = 1.0\n[[joint]]\n"
      "kind = \"contact\"\n[[joint]]\nkind = \"contact\"\n[[joint]]\nkind = \"contact\"\ngap = 1.0\n[initial]\nvelocity = "
      "0.0\n[mesh]\nelements = 4\n[time]\nend = 8.0\n[output]\nevery = 1.0\n");
  for (std::size_t k = 1; k < 6; ++k)
    for (std::size_t m = 0; m < 3; ++m) EXPECT_NEAR(run.v[k][m], 1.0 / 6.0, rounding) << k;
  // The bar: N = Z v, v = 1/6 exp(-(t - 6) / 6), which slows the bodies down by joints 1 and 2.
  const double v = std::exp(-2.0 / 6.0) / 6.0;
  EXPECT_NEAR(run.v[8][2], v, rounding);
  EXPECT_NEAR(run.statistics.account->joints.at(0).impulse, 1.0 - v, rounding);
  EXPECT_NEAR(run.statistics.account->joints.at(1).impulse, 1.0 - 3.0 * v, rounding);
}

// The bounce that contact.restitution wants of masses is left to a mesh, and `automatic` takes one. A face of a bar
// has no mass, so that beside it the restitution means nothing.
TEST(ChainWaves, AReboundOfMassesIsRefused) {
  const std::string rod = "[[bar]]\nlength = 1.0\nelements = 4\n", body = "[[bar]]\nmass = 1.0\nvelocity = 1.0\n",
                    meet = "[[joint]]\nkind = \"contact\"\ngap = 0.1\n", bond = "[[joint]]\nkind = \"bonded\"\n",
                    rest = "[contact]\nrestitution = 0.5\n[time]\nend = 0.2\n",
                    wall = "kind = \"obstacle\"\nside = \"above\"\ngap = 0.1\n";
  const std::string unlike[] = {body + "[[bar]]\nmass = 2.0\n" + rod + meet + bond,
                                rod + body + bond + "[right]\n" + wall,
                                "[bar]\nlength = 1.0\n[initial]\nvelocity = 1.0\n[right]\nmass = 1.0\n" + wall};
  for (const std::string& text : unlike) {
    const Case run = parse_scene(text + rest, "scene").run;
    EXPECT_EQ(run.method, MethodName::rigid) << text;
    EXPECT_NE(run.warning.find("contact.restitution is 0.5"), std::string::npos) << run.warning;
    const auto setup = resolve(run);
    const std::optional<std::string> remark = peak_remark(setup, setup.system());
    ASSERT_TRUE(remark) << text;
    EXPECT_EQ(remark->find("characteristics"), std::string::npos) << *remark;
    const Recording done = record(run);
    ASSERT_EQ(done.events.size(), 2U) << text;
    EXPECT_NEAR(done.events[1].velocity, -0.5 * done.events[0].velocity, 1e-6) << text;
    EXPECT_THROW((void)parse_scene(text + rest + "[method]\nname = \"characteristics\"\n", "scene"), SceneError);
  }
  EXPECT_EQ(parse_scene(body + rod + meet + rest, "scene").run.method, MethodName::characteristics);
}

// Smooth data in five unlike bars with contacts: a mesh comes nearer as it gets finer.
TEST(ChainWaves, AMeshComesNearerAsItGetsFiner) {
  const auto text = [](int elements) {
    return fmt::format(
        "[[bar]]\nlength = 1.0\nvelocity = \"0.2+exp(-((x-0.5)/0.15)^2)\"\nelements = {0}\n[[bar]]\nlength = 0.7\n"
        "density = 2.0\nelements = {0}\n[[bar]]\nlength = 1.3\nmodulus = 3.0\nelements = {0}\n[[bar]]\nlength = 0.5\n"
        "density = 0.5\nmodulus = 2.0\nsection = 2.0\nelements = {0}\n[[bar]]\nlength = 0.9\nelements = {0}\n[[joint]]\n"
        "kind = \"bonded\"\n[[joint]]\nkind = \"contact\"\ngap = 0.02\n[[joint]]\nkind = \"spring\"\nstiffness = 5.0\n"
        "damping = 0.3\n[[joint]]\nkind = \"contact\"\ngap = 0.03\n[initial]\nvelocity = 0.2\ndisplacement = 0.0\n"
        "[right]\nkind = \"obstacle\"\ngap = 0.1\nside = \"above\"\n[time]\nend = 4.0\n[output]\nevery = 0.1\n[mesh]\n"
        "mass = \"fourth_order\"\n[method]\nrelative_tolerance = 1e-9\n",
        elements);
  };
  const Followed exact = followed(text(20));
  std::vector<double> errors;
  for (const int factor : {1, 2, 4}) {
    const Followed mesh = followed(text(20 * factor), "rigid");
    double most = 0.0;
    for (std::size_t k = 0; k < exact.times.size(); ++k)
      for (const std::size_t bar : {0U, 1U, 2U, 3U, 4U}) {
        // Bar 2 and 3 begin behind a bond and joints.
        constexpr std::size_t joints_before[] = {0, 0, 1, 2, 3};
        const std::size_t middle = 20 * bar + 10;
        most = std::max(most, std::abs(exact.u[k][middle + joints_before[bar]] -
                                       mesh.u[k][middle * static_cast<std::size_t>(factor) + joints_before[bar]]));
      }
    errors.push_back(most);
  }
  EXPECT_LT(errors[1], 0.6 * errors[0]) << errors[0] << ' ' << errors[1] << ' ' << errors[2];
  EXPECT_LT(errors[2], 0.6 * errors[1]) << errors[0] << ' ' << errors[1] << ' ' << errors[2];
  constexpr double h = 1.3 / 80.0;
  EXPECT_LT(errors[2], 0.2 * h);
}

// Unlike windows: the shortest part is crossed in 0.3 of c = 1, the longest in 0.9.
const char* const loads_in_time[] = {"density = \"sin(3*t-2*x)*(1+x)\"",
                                     "density = \"t>0.83 ? exp(-x)*cos(t) : 0.4*x\"",
                                     "profile = \"x<0.71 ? 1+x : 0.2\"\nhistory = \"t<1.1 ? sin(5*t) : -0.3\""};

TEST(ChainWaves, ALoadThatDependsOnTimeIsOnPartsOfABarAsOnTheWhole) {
  const char* const ends =
      "[left]\nkind = \"obstacle\"\ngap = 0.05\n[right]\nkind = \"free\"\nstiffness = 0.5\n[time]\nend = 5.0\n[output]\n"
      "every = 0.13\n[load]\n";
  for (const char* load : loads_in_time) {
    const Followed whole = followed(std::string("[bar]\nlength = 1.7\n[mesh]\nelements = 17\n") + ends + load);
    const Followed parts =
        followed(std::string("[[bar]]\nlength = 0.3\nelements = 3\n[[bar]]\nlength = 0.9\nelements = 9\n[[bar]]\n"
                             "length = 0.5\nelements = 5\n") +
                 ends + load);
    ASSERT_EQ(parts.events.size(), whole.events.size()) << load;
    EXPECT_GE(whole.events.size(), 1U) << load;
    for (std::size_t k = 0; k < whole.events.size(); ++k)
      EXPECT_NEAR(parts.events[k].time, whole.events[k].time, 10.0 * rounding) << load;
    for (std::size_t k = 0; k < whole.times.size(); ++k)
      for (std::size_t j = 0; j < whole.u[k].size(); ++j)
        ASSERT_NEAR(parts.u[k][j], whole.u[k][j], 10.0 * rounding) << load << ' ' << whole.times[k] << ' ' << j;
    EXPECT_NEAR(parts.statistics.energy->work, whole.statistics.energy->work, 10.0 * rounding) << load;
    EXPECT_NEAR(parts.statistics.account->left.impulse, whole.statistics.account->left.impulse, 10.0 * rounding)
        << load;
  }
}

// Smooth, of bars that are at rest: order 4.
TEST(ChainWaves, AMeshComesToUnlikeBarsUnderALoadThatDependsOnTime) {
  const auto text = [](int elements) {
    return fmt::format(
        "[[bar]]\nlength = 1.0\nelements = {0}\n[[bar]]\nlength = 0.7\ndensity = 2.0\nsection = 2.0\nelements = {0}\n"
        "[[bar]]\nlength = 1.3\nmodulus = 3.0\nelements = {0}\n[[joint]]\nkind = \"bonded\"\n[[joint]]\nkind = \"spring\"\nstiffness = "
        "2.0\n[left]\nkind = \"fixed\"\n[load]\ndensity = \"sin(t)^5*(1+cos(x))\"\n[time]\nend = 2.0\n[output]\nevery = "
        "0.25\n[mesh]\nmass = \"fourth_order\"\n[method]\nrelative_tolerance = 1e-11\n",
        elements);
  };
  const Followed exact = followed(text(10));
  std::vector<double> errors;
  for (const int factor : {1, 2, 4}) {
    const Followed mesh = followed(text(10 * factor), "rigid");
    double most = 0.0;
    for (std::size_t k = 0; k < exact.times.size(); ++k)
      most = std::max(most, std::abs(exact.u[k].back() - mesh.u[k].back()));
    errors.push_back(most);
  }
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_NEAR(std::log2(errors[k] / errors[k + 1]), 4.0, 0.3) << errors[k] << ' ' << errors[k + 1];
}

TEST(ChainWaves, ALoadThatDependsOnTimeGoesOnFromCheckpointsBitForBit) {
  for (const char* load : loads_in_time) {
    const auto setup = resolve(
        parse_scene(
            std::string(
                "[[bar]]\nlength = 0.3\n[[bar]]\nlength = 0.94\ndensity = 2.0\n[[bar]]\nmass = "
                "0.3\n[[joint]]\nkind = \"bonded\"\n[[joint]]\nkind = \"contact\"\ngap = 0.01\n[time]\nend = 4.0\n[output]\n"
                "every = 0.3\n[method]\nname = \"characteristics\"\n[load]\n") +
                load,
            "")
            .run);
    std::vector<Checkpoint> checkpoints;
    std::vector<std::vector<double>> whole, rest;
    Observers observers;
    observers.energy = observers.account = true;
    observers.checkpoints.emplace().every = 0.9;
    observers.checkpoints->take = [&](const Checkpoint& one) {
      checkpoints.push_back(one);
      return RunControl::go_on;
    };
    observers.snapshot = [&](const Snapshot& now) { whole.emplace_back(now.u.begin(), now.u.end()); };
    const Statistics of_whole = simulate(setup, observers);
    ASSERT_EQ(checkpoints.size(), 4U);
    observers.checkpoints->take = [](const Checkpoint&) { return RunControl::go_on; };
    observers.snapshot = [&](const Snapshot& now) { rest.emplace_back(now.u.begin(), now.u.end()); };
    for (const Checkpoint& from : checkpoints) {
      rest.clear();
      const Statistics of_rest = simulate(setup, setup.system(), from, observers);
      ASSERT_EQ(rest.size() + from.outputs, whole.size());
      for (std::size_t k = 0; k < rest.size(); ++k) ASSERT_EQ(rest[k], whole[k + from.outputs]) << load;
      EXPECT_EQ(of_rest.energy->work, of_whole.energy->work) << load;
      EXPECT_EQ(of_rest.energy->final, of_whole.energy->final) << load;
      EXPECT_EQ(of_rest.representation->error, of_whole.representation->error) << load;
    }
  }
}

}  // namespace
}  // namespace viscobar
