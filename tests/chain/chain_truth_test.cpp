// Bars in line against closed forms; docs/bars-in-line.md derives what is claimed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/decompositions.hpp"
#include "support/dense_matrix.hpp"
#include "support/maximum_norm.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

// The frequencies of a system, rising, and the largest imaginary part of their squares.
std::pair<std::vector<double>, double> frequencies(const BarSystem& system) {
  BandedMatrix stiffness;
  system.dynamic_stiffness(0.0, 0.0, 1.0, stiffness);
  const MatrixXd squares = testing_support::quotient(dense(system.inertia().matrix()), dense(stiffness));
  std::vector<double> found;
  double imaginary = 0.0;
  for (const auto& square : testing_support::eigenvalues(squares)) {
    found.push_back(static_cast<double>(std::sqrt(std::max(0.0L, square.real()))));
    imaginary = std::max(imaginary, static_cast<double>(std::abs(square.imag())));
  }
  std::ranges::sort(found);
  return {found, imaginary};
}

// On a mesh: elastic bars alone would have a method without.
Setup setup_of(const std::string& text) {
  std::vector<std::string> settings;
  if (text.find("name = ") == std::string::npos) settings.push_back("method.name=rigid");
  return resolve(parse_scene(text, "", settings).run);
}

double order(double coarse, double fine) { return std::log2(std::abs(coarse / fine)); }

// tan^2 (k l) = Z1 / Z2 for two bars of equal transit times, fixed at the first [docs/bars-in-line.md].
TEST(Bonded, SteppedBarsHaveTheirFrequenciesToFourthOrder) {
  for (const double ratio : {0.5, 2.0, 4.0}) {
    const double exact = std::atan(1.0 / std::sqrt(ratio));
    std::vector<double> errors;
    for (const int elements : {20, 40, 80}) {
      // Z2 = rho2 c2 at c2 = 2 and twice the length.
      const auto setup = setup_of(fmt::format(
          "[[bar]]\nlength = 1.0\nelements = {0}\n[[bar]]\nlength = 2.0\ndensity = {1}\nmodulus = {2}\nelements = {0}\n"
          "[left]\nkind = \"fixed\"\n[initial]\nvelocity = 1.0\n[time]\nend = 1.0\n[mesh]\nmass = \"fourth_order\"\n",
          elements, ratio / 2.0, 2.0 * ratio));
      const auto [modes, imaginary] = frequencies(setup.system());
      EXPECT_LT(imaginary, 1e-9);
      errors.push_back(modes.front() / exact - 1.0);
    }
    EXPECT_LT(std::abs(errors[1]), 1e-7) << ratio;
    EXPECT_GT(order(errors[1], errors[2]), 3.7) << ratio << ' ' << errors[0] << ' ' << errors[1] << ' ' << errors[2];
  }
}

// A step of the section is one of the impedance, too.
TEST(Bonded, AStepOfTheSectionIsOneOfTheImpedance) {
  const auto setup = setup_of(
      "[[bar]]\nlength = 0.5371\nelements = 20\n[[bar]]\nlength = 0.4629\nsection = 4.0\nelements = 20\n[left]\nkind = "
      "\"fixed\"\n[initial]\nvelocity = 1.0\n[time]\nend = 1.0\n");
  EXPECT_NEAR(frequencies(setup.system()).first.front(), 0.9290754617, 1e-8);
}

// sin(k l) = 0: with both ends fixed the rows of the joint are the only ones that go to one side.
TEST(Bonded, BarsBetweenFixedEndsHaveTheirFrequenciesToFourthOrder) {
  std::vector<double> errors;
  for (const int elements : {20, 40, 80}) {
    const auto setup = setup_of(fmt::format(
        "[[bar]]\nlength = 0.3\nelements = {0}\n[[bar]]\nlength = 0.7\nelements = {0}\n[left]\nkind = "
        "\"fixed\"\n[right]\nkind = \"fixed\"\n[initial]\nvelocity = \"sin(3*x)\"\n[mesh]\nmass = \"fourth_order\"\n[time]\nend = 1.0\n",
        elements));
    errors.push_back(frequencies(setup.system()).first.front() - std::numbers::pi);
  }
  EXPECT_LT(std::abs(errors[1]), std::pow(std::numbers::pi * 0.7 / 40.0, 4) / 50.0);
  EXPECT_GT(order(errors[1], errors[2]), 3.7) << errors[0] << ' ' << errors[1] << ' ' << errors[2];
}

// Where rows are sums of elements, three equal bars are one.
TEST(Bonded, EqualBarsAreOneBar) {
  const std::string rest =
      "[left]\nkind = \"obstacle\"\ngap = 0.1\n[initial]\nvelocity = -1.0\ndisplacement = \"0.01*cos(3*x)\"\n[load]\n"
      "density = \"0.3*sin(2*x)*cos(3*t)\"\n[time]\nend = 2.0\n[output]\nevery = 0.25\ngauges = [0.2, 0.7]\n[contact]\n"
      "epsilon = 1e-3\n[method]\nrelative_tolerance = 1e-9\nstep = 1e-3\n";
  for (const char* method : {"cvode", "ida", "arkode", "odeint", "rigid", "exponential", "fully_discrete"})
    for (const char* mass : {"consistent", "lumped"}) {
      const std::string end = fmt::format("name = \"{}\"\n[mesh]\nmass = \"{}\"\n", method, mass);
      const Recording chain = record(
          parse_scene(
              "[[bar]]\nlength = 0.5\nviscosity = 0.1\nelements = 10\n[[bar]]\nlength = 0.25\nviscosity = 0.1\nelements = 5\n"
              "[[bar]]\nlength = 0.25\nviscosity = 0.1\nelements = 5\n" +
                  rest + end,
              "")
              .run);
      const Recording one =
          record(parse_scene("[bar]\nlength = 1.0\nviscosity = 0.1\n" + rest + end + "elements = 20\n", "").run);
      ASSERT_EQ(chain.events.size(), one.events.size()) << method << mass;
      // Rounding, which an adaptive method may answer with another step: then the errors of both.
      const double allowed = std::string_view(method) == "fully_discrete" ? 1e-11 : 1e-7;
      for (std::size_t k = 0; k < one.u.size(); ++k) EXPECT_NEAR(chain.u[k], one.u[k], allowed) << method << mass << k;
      for (std::size_t k = 0; k < one.events.size(); ++k)
        EXPECT_NEAR(chain.events[k].time, one.events[k].time, 10 * allowed) << method << mass;
      EXPECT_NEAR(chain.statistics.energy->balance_error(), 0.0, 1e-5) << method << mass;
    }
}

// A horn in two parts, fixed and free: with A = e^{2x}, u = e^{-x} sin(k x), tan k = k, omega^2 = k^2 + 1. One part has
// given nodes, the other one shrinks towards an obstacle that is not met.
TEST(BarMeshes, AHornInTwoPartsHasItsFrequenciesToFourthOrder) {
  const double exact = std::hypot(4.493409457909064, 1.0);
  std::vector<double> errors;
  for (const int elements : {24, 48, 96}) {
    const auto setup = setup_of(fmt::format(
        "[[bar]]\nlength = 0.4\nsection = \"exp(2*x)\"\nelements = {0}\nnodes = [0.0, 0.07, 0.17, 0.27, 0.4]\n[[bar]]\nlength = "
        "0.6\nsection = \"exp(2*x+0.8)\"\nelements = {0}\ngrading = 3.0\n[left]\nkind = \"fixed\"\n[right]\nkind = "
        "\"obstacle\"\ngap = 9.0\n[initial]\nvelocity = \"x\"\n[time]\nend = 1.0\n[mesh]\nmass = \"fourth_order\"\n",
        elements));
    EXPECT_LT(setup.mesh.element(2 * static_cast<std::size_t>(elements) - 1),
              0.4 * setup.mesh.element(static_cast<std::size_t>(elements)));
    const auto [modes, imaginary] = frequencies(setup.system());
    EXPECT_LT(imaginary, 1e-9);
    EXPECT_NEAR(modes[0], 1.0, 1e-4);  // k = 0
    errors.push_back(modes[1] / exact - 1.0);
  }
  EXPECT_LT(std::abs(errors[2]), 1e-6);
  EXPECT_GT(order(errors[1], errors[2]), 3.7) << errors[0] << ' ' << errors[1] << ' ' << errors[2];
}

// A pulse through the interface of unlike bars: differences of meshes fall as h^4, and energy is kept.
TEST(Bonded, APulsePassesAnInterfaceToFourthOrder) {
  std::vector<std::vector<double>> traces;
  for (const int elements : {20, 40, 80, 160}) {
    const Recording found = record(
        parse_scene(
            fmt::format(
                "[[bar]]\nlength = 1.0\nviscosity = 0.1\nelements = {0}\nvelocity = \"exp(-((x-0.5)/0.12)^2)\"\n[[bar]]\nlength = "
                "1.5\ndensity = 2.0\nmodulus = 3.0\nviscosity = 0.2\nelements = {0}\nvelocity = 0.0\n[time]\nend = 3.0\n[method]\n"
                "name = \"rigid\"\nrelative_tolerance = 1e-11\n[output]\nevery = 0.05\n",
                elements),
            "")
            .run);
    auto& trace = traces.emplace_back();
    for (std::size_t k = 0; k < found.times.size(); ++k)
      for (const int node : {0, elements, 2 * elements})
        trace.push_back(found.displacement(k)[static_cast<std::size_t>(node)]);
    EXPECT_NEAR(found.statistics.energy->balance_error() / found.statistics.energy->initial, 0.0, 1e-8);
  }
  const auto difference = [&](std::size_t m) { return distance(traces[m], traces[m + 1]); };
  EXPECT_GT(order(difference(1), difference(2)), 3.6) << difference(0) << ' ' << difference(1) << ' ' << difference(2);
  EXPECT_LT(difference(2), 1e-6);
}

// The same pulse, and sections, on unlike meshes: of one bar given nodes, of the other graded.
TEST(BarMeshes, APulsePassesAnInterfaceToFourthOrderByEveryKindOfMethod) {
  for (const char* method : {"rigid", "cvode", "fully_discrete"}) {
    std::vector<std::vector<double>> traces;
    for (const int elements : {24, 48, 96, 192}) {
      const Recording found = record(
          parse_scene(
              fmt::format(
                  "[[bar]]\nlength = 1.0\nviscosity = 0.1\nelements = {0}\nvelocity = \"exp(-((x-0.5)/0.15)^2)\"\nsection = "
                  "\"exp(x)\"\nnodes = [0.0, 0.2, 0.5, 0.8, 1.0]\n[[bar]]\nlength = 1.5\ndensity = 2.0\nmodulus = 3.0\nviscosity "
                  "= 0.2\nelements = {0}\ngrading = 2.5\nsection = \"(2-x)^2+0.5\"\nvelocity = 0.0\n[right]\nkind = \"obstacle\"\n"
                  "gap = 9.0\n[time]\nend = 2.0\n[mesh]\nmass = \"fourth_order\"\n[method]\nname = \"{1}\"\nrelative_tolerance = 1e-11\n"
                  "step = 1e-3\nstart = \"second_order\"\n[contact]\nepsilon = 1e-3\n[output]\nevery = 0.1\n",
                  elements, method),
              "")
              .run);
      auto& trace = traces.emplace_back();
      for (std::size_t k = 0; k < found.times.size(); ++k)
        for (const int node : {0, elements, 2 * elements})
          trace.push_back(found.displacement(k)[static_cast<std::size_t>(node)]);
    }
    const auto difference = [&](std::size_t m) { return distance(traces[m], traces[m + 1]); };
    EXPECT_GT(order(difference(1), difference(2)), 3.7)
        << method << ' ' << difference(0) << ' ' << difference(1) << ' ' << difference(2);
  }
}

std::string pair_text(double alpha, int elements, const char* method) {
  return fmt::format(
      "[[bar]]\nlength = 1.0\nviscosity = {0}\nvelocity = 1.0\nelements = {1}\n[[bar]]\nlength = 1.5\ndensity = 2.0\nmodulus "
      "= 3.0\nviscosity = {2}\nvelocity = 0.0\nelements = {1}\n[[joint]]\nkind = \"contact\"\n[time]\nend = 3.0\n[mesh]\n"
      "mass = \"fourth_order\"\n[method]\nname = \"{3}\"\nrelative_tolerance = 1e-10\n[contact]\nepsilon = 1e-5\nrestitution "
      "= 0.0\n",
      alpha, elements, 2.0 * alpha, method);
}

// By Laplace's transform: end of contact, impulse [docs/bars-in-line.md].
struct PairTruth {
  double alpha, end, impulse;
};
constexpr PairTruth pair_truths[] = {{1.0, 1.5535874882557, 0.89166619755518},
                                     {0.1, 2.0599929079778, 1.2432684888266},
                                     {0.01, 2.068825800376, 1.370641194291}};

// The same pair graded towards the contact, and with given nodes. The impulse's error changes its sign between meshes:
// its order is that of a bound. Penalty and step are wrong by 1e-5 and 1e-4.
TEST(BarMeshes, AnImpactOnUnlikeMeshesIsThatOfLaplacesTransform) {
  const PairTruth& truth = pair_truths[1];
  for (const int elements : {20, 40, 80}) {
    std::vector<std::string> settings = {"bar.1.grading=2.5", "bar.2.nodes=[0,0.3,0.7,1.1,1.5]", "method.step=1e-4"};
    for (const char* method : {"rigid", "cvode", "fully_discrete"}) {
      if (method == std::string_view("cvode")) settings.push_back("method.relative_tolerance=1e-8");
      const Recording found = record(parse_scene(pair_text(truth.alpha, elements, method), "", settings).run);
      ASSERT_EQ(found.events.size(), 2U) << method << ' ' << elements;
      const double error = found.statistics.account->joints.at(0).impulse - truth.impulse;
      const double allowed = method == std::string_view("rigid") ? 3e-8 * std::pow(40.0 / elements, 4) : 1e-4;
      EXPECT_NEAR(error, 0.0, allowed) << method << ' ' << elements;
    }
  }
}

TEST(ContactJoint, AnImpactOfUnlikeBarsIsThatOfLaplacesTransform) {
  for (const PairTruth& truth : pair_truths) {
    std::vector<double> errors;
    for (const int elements : {20, 40, 80}) {
      const Recording found = record(parse_scene(pair_text(truth.alpha, elements, "rigid"), "").run);
      ASSERT_EQ(found.events.size(), 2U) << truth.alpha << ' ' << elements;
      EXPECT_EQ(found.events[0].time, 0.0);
      EXPECT_EQ(found.events[1].where, Where::joint);
      EXPECT_EQ(found.events[1].node, 1U);
      const ContactAccount& joint = found.statistics.account->joints.at(0);
      EXPECT_EQ(joint.closings, 1U);
      errors.push_back(joint.impulse - truth.impulse);
      if (elements == 80) {
        EXPECT_NEAR(found.events[1].time, truth.end, 2e-7) << truth.alpha;
        EXPECT_NEAR(joint.impulse, truth.impulse, 1e-6) << truth.alpha;
      }
    }
    EXPECT_GT(order(errors[1], errors[2]), 3.5)
        << truth.alpha << ' ' << errors[0] << ' ' << errors[1] << ' ' << errors[2];
  }
}

// A penalty of 1e-5 gives way by some 1e-5, and its dashpot takes the velocity of the nodes alone.
TEST(ContactJoint, PenalisedMethodsComeNear) {
  for (const char* method : {"cvode", "ida", "arkode", "odeint", "exponential"}) {
    const Recording found = record(parse_scene(pair_text(0.1, 20, method), "").run);
    ASSERT_GE(found.events.size(), 2U) << method;
    EXPECT_NEAR(found.events.back().time, pair_truths[1].end, 0.02) << method;
    EXPECT_NEAR(found.statistics.account->joints.at(0).impulse, pair_truths[1].impulse, 3e-3) << method;
  }
}

// By (2.8) the opening is right to two steps, and the impulse to a step.
TEST(ContactJoint, TheSchemeComesNear) {
  std::vector<double> errors;
  for (const double step : {4e-3, 2e-3, 1e-3}) {
    const Recording found = record(parse_scene(pair_text(0.1, 40, "fully_discrete"), "",
                                               std::vector<std::string>{fmt::format("method.step={}", step)})
                                       .run);
    ASSERT_GE(found.events.size(), 2U) << step;
    errors.push_back(found.statistics.account->joints.at(0).impulse - pair_truths[1].impulse);
    EXPECT_NEAR(found.events.back().time, pair_truths[1].end, 2.0 * step) << step;
    EXPECT_LT(std::abs(errors.back()), step);
    EXPECT_NEAR(found.statistics.energy->balance_error(), 0.0, 1e-10) << step;
  }
  EXPECT_LT(std::abs(errors[2]), 0.7 * std::abs(errors[1])) << errors[0] << ' ' << errors[1] << ' ' << errors[2];
}

// Elastic bars of equal length, all free: the first one stops, the second has its velocity, after 2 L / c. On a mesh to
// some h.
TEST(ContactJoint, EqualElasticBarsExchangeTheirVelocities) {
  const Recording found = record(
      parse_scene(
          "[[bar]]\nlength = 1.0\nvelocity = 1.0\nelements = 100\n[[bar]]\nlength = 1.0\nvelocity = 0.0\nelements = "
          "100\n[[joint]]\nkind = \"contact\"\ngap = 0.05\n[time]\nend = 2.5\n[method]\nname = \"rigid\"\n",
          "")
          .run);
  ASSERT_GE(found.events.size(), 2U);
  constexpr double h = 0.01;
  EXPECT_NEAR(found.events.front().time, 0.05, 1e-6);
  EXPECT_NEAR(found.events.back().time, 2.05, 3.0 * h);
  EXPECT_NEAR(found.statistics.account->joints.at(0).impulse, 1.0, h);
}

// A ram of mass M at speed V on a rod without end, the dashpot Z at its far end: N = Z V exp(-Z t / M).
TEST(RigidMember, ARamDiesOutOnALongRod) {
  for (const char* joint : {"bonded", "contact"}) {
    const Recording found = record(
        parse_scene(
            fmt::format(
                "[[bar]]\nmass = 2.0\nvelocity = 1.0\n[[bar]]\nlength = 1.0\nviscosity = 1e-4\nelements = 200\nvelocity = "
                "0.0\n[[joint]]\nkind = \"{}\"\n[right]\nkind = \"free\"\ndashpot = 1.0\n[time]\nend = 2.0\n[output]\nevery = "
                "0.5\n[method]\nname = \"rigid\"\n",
                joint),
            "")
            .run);
    for (std::size_t k = 1; k < found.times.size(); ++k)
      EXPECT_NEAR(found.velocity(k).front(), std::exp(-found.times[k] / 2.0), 3e-3) << joint << found.times[k];
  }
}

// A cushion, the spring k between a ram and a rod without end: kappa = k M / Z^2 = 1, whose peak force, its time and
// end are in docs/bars-in-line.md.
TEST(SpringJoint, ACushionHasItsPeak) {
  const Recording found = record(
      parse_scene(
          "[[bar]]\nmass = 1.0\nvelocity = 1.0\n[[bar]]\nlength = 1.0\nviscosity = 1e-5\nelements = 200\nvelocity = "
          "0.0\n[[joint]]\nkind = \"spring\"\nstiffness = 1.0\n[right]\nkind = \"free\"\ndashpot = 1.0\n[time]\nend = "
          "1.209199576156\n[output]\nevery = 1.209199576156\n[method]\nname = \"rigid\"\n",
          "")
          .run);
  const auto u = found.displacement(found.times.size() - 1);
  EXPECT_NEAR(u[0] - u[1], 0.5462930158736, 1e-3);
}

// The same by a stop that pushes alone: it lets go at 3.6276 M / Z, the ram having -0.16303 V. The rod is a little
// viscous, which takes some 1e-4.
TEST(ContactJoint, ACushionThatPushesLetsGoInTime) {
  for (const char* method : {"cvode", "ida", "arkode", "odeint", "exponential"}) {
    const Recording found =
        record(parse_scene("[[bar]]\nmass = 1.0\nvelocity = 1.0\n[[bar]]\nlength = 2.0\nviscosity = 1e-5\nelements = "
                           "200\nvelocity = 0.0\n[[joint]]\nkind = \"contact\"\nlaw = \"spring_damper\"\nstiffness = "
                           "1.0\n[right]\nkind = \"free\"\ndashpot = 1.0\n[time]\nend = 5.0\n",
                           "", std::vector<std::string>{fmt::format("method.name={}", method)})
                   .run);
    ASSERT_EQ(found.events.size(), 2U) << method;
    EXPECT_NEAR(found.events[1].time, 3.627598728468, 1e-4) << method;
    EXPECT_NEAR(found.velocity(found.times.size() - 1).front(), -0.1630335348, 1e-4) << method;
    EXPECT_NEAR(found.statistics.account->joints.at(0).peak_reaction, 0.5462930158736, 1e-4) << method;
  }
}

// A ram of the rod's mass, times 1 and 2, on a rod that is fixed behind: end of contact and speed of the ram by the
// wave that goes to and fro. The rod is a little viscous, which takes some 1e-3.
TEST(RigidMember, ARamLeavesAFixedRodInTime) {
  for (const auto& [mass, end, speed] :
       {std::tuple{1.0, 3.067667641618, -0.6876189398}, {2.0, 4.708567243668, -0.9252469967}}) {
    const Recording found =
        record(parse_scene(fmt::format("[[bar]]\nmass = {}\nvelocity = 1.0\n[[bar]]\nlength = 1.0\nviscosity = "
                                       "1e-4\nelements = 400\nvelocity = 0.0\n[[joint]]\nkind = "
                                       "\"contact\"\n[right]\nkind = \"fixed\"\n[time]\nend = {}\n[method]\n"
                                       "name = \"rigid\"\n",
                                       mass, end + 0.2),
                           "")
                   .run);
    ASSERT_EQ(found.events.size(), 2U) << mass;
    EXPECT_NEAR(found.events[1].time, end, 1e-3) << mass;
    EXPECT_NEAR(found.velocity(found.times.size() - 1).front(), speed, 1e-3) << mass;
  }
}

// A body between two contacts gains the momentum that they give it; the second closes while the first is closed, and
// the first has a share in that.
TEST(RigidMember, BetweenContactsItsImpulsesAreItsMomentum) {
  for (const char* mass : {"fourth_order", "consistent", "lumped"}) {
    const Recording found = record(
        parse_scene(
            fmt::format(
                "[[bar]]\nlength = 1.0\nviscosity = 0.1\nelements = 6\nvelocity = 1.0\n[[bar]]\nmass = "
                "0.5\nvelocity = 0.0\n[[bar]]\nlength = 1.0\nviscosity = 0.1\nelements = 6\nvelocity = "
                "-0.2\n[[joint]]\nkind = \"contact\"\ngap = 0.1\n[[joint]]\nkind = \"contact\"\ngap = "
                "0.3\n[mesh]\nmass = \"{}\"\n[time]\nend = 2.0\n[method]\nname = \"rigid\"\nrelative_tolerance = 1e-9\n",
                mass),
            "")
            .run);
    const std::vector<ContactAccount>& joints = found.statistics.account->joints;
    ASSERT_GT(joints[1].impulse, 0.1) << mass;
    const double gained = 0.5 * found.velocity(found.times.size() - 1)[7];
    EXPECT_NEAR(joints[0].impulse - joints[1].impulse, gained, 10.0 * 1e-9) << mass;
  }
}

// Two contacts that close at the start: what both take from the energy is told.
TEST(ContactJoint, TwoThatStrikeAtTheStartKeepTheBalance) {
  for (const double restitution : {0.0, 0.5}) {
    std::string text = "[contact]\nrestitution = " + std::to_string(restitution) + "\n";
    for (const double velocity : {1.0, 0.2, -0.5})
      text += fmt::format("[[bar]]\nlength = 1.0\nviscosity = 0.1\nelements = 5\nvelocity = {}\n", velocity);
    const Recording found =
        record(parse_scene(text + "[[joint]]\nkind = \"contact\"\n[[joint]]\nkind = \"contact\"\n[mesh]\nmass = "
                                  "\"consistent\"\n[time]\nend = 0.3\n[method]\nname = \"rigid\"\n",
                           "")
                   .run);
    const EnergyAccount& energy = *found.statistics.energy;
    EXPECT_NEAR(energy.final + energy.dissipated, energy.initial, 1e-9) << restitution;
    EXPECT_GT(energy.dissipated, 0.05);
  }
}

// Newton's cradle of five elastic bars that touch, the first thrown: the last leaves with its velocity.
TEST(ContactJoint, ACradlePassesTheVelocityOn) {
  std::string text, joints;
  for (int k = 0; k < 5; ++k) {
    text += fmt::format("[[bar]]\nlength = 1.0\nviscosity = 1e-4\nelements = 50\nvelocity = {}\n", k == 0 ? 1 : 0);
    if (k > 0) joints += "[[joint]]\nkind = \"contact\"\n";
  }
  const Recording found =
      record(parse_scene(text + joints + "[time]\nend = 7.0\n[method]\nname = \"rigid\"\n", "").run);
  const auto v = found.velocity(found.times.size() - 1);
  double first = 0.0, last = 0.0;
  for (std::size_t j = 0; j <= 50; ++j) first += v[j] / 51.0, last += v[v.size() - 1 - j] / 51.0;
  constexpr double h = 0.02;  // elastic bars are right to some of it
  EXPECT_NEAR(first, 0.0, h);
  EXPECT_NEAR(last, 1.0, 1.5 * h);
  for (const ContactAccount& joint : found.statistics.account->joints) EXPECT_NEAR(joint.impulse, 1.0, 1.5 * h);
}

// A body of 1e12 gives way by 1e-12.
TEST(ContactJoint, AHeavyBodyIsAWallToEveryLaw) {
  const std::string bar = "length = 1.0\nviscosity = 0.1\nelements = 8\n",
                    rest = "[time]\nend = 2.5\n[method]\nrelative_tolerance = 1e-9\nname = ";
  for (const char* law :
       {"law = \"spring_damper\"\nstiffness = 5.0\ndamping = 0.5\n", "law = \"hertz\"\nstiffness = 20.0\n",
        "law = \"hunt_crossley\"\nstiffness = 20.0\ndamping = 0.7\n"})
    for (const char* method : {"cvode", "ida", "arkode", "odeint"}) {
      const Recording wall =
          record(parse_scene(fmt::format("[bar]\n{}[left]\nkind = \"obstacle\"\ngap = 0.1\n[initial]\nvelocity = "
                                         "-1.0\n[contact]\n{}[mesh]\nelements = 8\n{}\"{}\"\n",
                                         bar.substr(0, bar.find("elements")), law, rest, method),
                             "")
                     .run);
      const Recording body =
          record(parse_scene(fmt::format("[[bar]]\nmass = 1e12\nvelocity = 0.0\n[[bar]]\n{}velocity = -1.0\n[[joint]]\n"
                                         "kind = \"contact\"\ngap = 0.1\n{}{}\"{}\"\n",
                                         bar, law, rest, method),
                             "")
                     .run);
      const std::size_t last = wall.times.size() - 1;
      EXPECT_NEAR(body.displacement(last).back(), wall.displacement(last).back(), 1e-7) << law << method;
      EXPECT_NEAR(body.statistics.account->joints[0].impulse, wall.statistics.account->left.impulse, 1e-7)
          << law << method;
      EXPECT_GT(wall.statistics.account->left.impulse, 1.0);
    }
}

// Bars without strain close the gap at gap / (v_a - v_b), however long the steps are.
TEST(ContactJoint, IsClosedWithinALongStep) {
  const Recording found = record(
      parse_scene("[[bar]]\nlength = 1.0\nelements = 11\nvelocity = 0.3924\n[[bar]]\nlength = 0.5\nelements = 7\n"
                  "velocity = 0.362\nviscosity = 0.02\n[[joint]]\nkind = \"contact\"\ngap = 0.0257\n[initial]\n"
                  "velocity = 0.0\n[time]\nend = 2.3\n[method]\nname = \"rigid\"\n",
                  "")
          .run);
  ASSERT_GE(found.events.size(), 1U);
  EXPECT_NEAR(found.events[0].time, 0.0257 / (0.3924 - 0.362), 1e-9);
}

// Two rigid bodies part with e times the speed at which they met, whatever their masses. By a penalty the dashpot is
// that of m1 m2 / (m1 + m2).
TEST(ContactJoint, OfRigidBodiesHasItsRestitution) {
  for (const auto& [left, right] : {std::pair{1.0, 1.0}, {1.0, 10.0}, {10.0, 1.0}}) {
    const auto scene = [&](const char* bond, const char* method) {
      return fmt::format(
          "[[bar]]\nmass = {}\nvelocity = 1.0\n[[bar]]\nmass = {}\n[[bar]]\nlength = 1.0\n[[joint]]\n"
          "kind = \"contact\"\ngap = 0.1\n[[joint]]\n{}\n[initial]\nvelocity = 0.0\n[time]\nend = 0.6\n"
          "[mesh]\nelements = 4\nmass = \"lumped\"\n[contact]\nepsilon = 1e-6\nrestitution = 0.5\n"
          "[method]\nname = \"{}\"\nstep = 1e-3\n",
          left, right, bond, method);
    };
    const Recording found = record(parse_scene(scene("kind = \"contact\"\ngap = 10.0", "fully_discrete"), "").run);
    const auto v = found.velocity(found.times.size() - 1);
    EXPECT_NEAR(v[1] - v[0], 0.5, 1e-9) << left << right;
    const BarSystem system = setup_of(scene("kind = \"bonded\"", "cvode")).system();
    const double other = right + 0.125;  // half an element of the bar is on it
    EXPECT_NEAR(system.inertia().contact_mass(system.contacts()[0]), left * other / (left + other), 1e-12)
        << left << right;
  }
}

// A body at either end of a bar at rest brings its whole momentum.
TEST(Bonded, ARigidBodyKeepsItsMomentum) {
  for (const char* mass : {"consistent", "lumped", "fourth_order"})
    for (const bool right : {false, true}) {
      const std::string bar = "[[bar]]\nlength = 1.0\nelements = 20\n", body = "[[bar]]\nmass = 1.0\nvelocity = 1.0\n";
      const auto setup = setup_of((right ? bar + body : body + bar) +
                                  "[initial]\nvelocity = 0.0\n[time]\nend = 1.0\n[mesh]\nmass = \"" + mass + "\"\n");
      const BarSystem system = setup.system();
      const std::vector<double> v = system.initial_state().v;
      std::vector<double> momentum(v.size());
      system.inertia().matrix().multiply(v, momentum);
      double sum = 0.0;
      for (const double part : momentum) sum += part;
      EXPECT_NEAR(sum, 1.0, 1e-12) << mass << right;
    }
}

}  // namespace
}  // namespace viscobar
