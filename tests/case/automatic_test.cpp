// The method and the mass of a scene that names none.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "viscobar/case/recording.hpp"
#include "viscobar/characteristics/characteristics.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

struct Given {
  std::string left = "obstacle", right = "free", load{}, mass{};
  bool span = false, epsilon = false, restitution = false;
  double viscosity = 0.0;
  std::size_t elements = 6;
  std::string more{};

  std::string text() const {
    const auto end = [](const char* side, const std::string& kind) {
      return fmt::format("[{}]\nkind = \"{}\"\n{}", side, kind, kind == "obstacle" ? "gap = 0.1\n" : "");
    };
    return fmt::format("[bar]\nlength = 1.0\nviscosity = {}\n{}{}{}", viscosity, end("left", left), end("right", right),
                       span ? "[span]\ngap = 0.15\n" : "") +
           "[initial]\ndisplacement = 0.0\nvelocity = \"-x*(1-x)\"\n" +
           (load.empty() ? "" : fmt::format("[load]\ndensity = \"{}\"\n", load)) +
           fmt::format("[time]\nend = 1.0\n[mesh]\nelements = {}\n{}[contact]\n{}{}{}", elements,
                       mass.empty() ? "" : fmt::format("mass = \"{}\"\n", mass), epsilon ? "epsilon = 1e-3\n" : "",
                       restitution ? "restitution = 0.5\n" : "", more);
  }
  Case run() const { return parse_scene(text(), "scene").run; }
  /// Keys of what is refused.
  std::vector<std::string> refused() const {
    std::vector<std::string> keys;
    try {
      run();
    } catch (const SceneError& error) {
      for (const Diagnostic& one : error.diagnostics) keys.push_back(one.key);
    }
    return keys;
  }
};

std::vector<Given> every_combination() {
  std::vector<Given> all;
  for (const char* left : {"free", "fixed", "obstacle"})
    for (const char* right : {"free", "fixed", "obstacle"})
      for (const char* load : {"", "-1", "-1 - x*sin(t)"})
        for (const char* mass : {"", "consistent", "lumped", "paper", "redistributed", "fourth_order"})
          for (const bool span : {false, true})
            for (const bool epsilon : {false, true})
              for (const bool restitution : {false, true})
                for (const double viscosity : {0.0, 0.1})
                  all.push_back({left, right, load, mass, span, epsilon, restitution, viscosity, 6, ""});
  return all;
}

// The one contradiction is a span obstacle on massless nodes: all nodes meet the obstacle.
// u = t - sin t, all along a bar so soft that no wave crosses an element. The scheme begins with the velocity 0 in
// place of dt^2 / 6, which is dt^2 T / 6 at the end; what its sums leave has the other sign.
TEST(StepOfAScheme, IsShortBesideTheRunWhereNoWaveCrossesAnElement) {
  for (const char* method : {"fully_discrete", "finite_difference"}) {
    const Case run = parse_scene(fmt::format("[bar]\nlength = 1.0\nmodulus = 1e-12\n[load]\ndensity = \"sin(t)\"\n"
                                             "[time]\nend = 10.0\n[mesh]\nelements = 4\n[method]\nname = \"{}\"\n",
                                             method),
                                 "")
                         .run;
    const Recording soft = record(run);
    for (const double u : soft.displacement(soft.times.size() - 1))
      EXPECT_NEAR(u, 10.0 - std::sin(10.0), 1e-4 * 10.0 / 6.0) << method;
  }
}

TEST(Automatic, RunsEveryCombinationOfKeysOrRefusesItByTheKeyThatIsWrong) {
  for (const Given& given : every_combination()) {
    std::vector<std::string> wrong;
    if (given.span && given.mass == "redistributed") wrong.push_back("mesh.mass");
    ASSERT_EQ(given.refused(), wrong) << given.text();
    if (!wrong.empty()) continue;
    const Case run = given.run();
    const Recording recording = record(run);
    EXPECT_TRUE(recording.statistics.completed) << given.text();
    EXPECT_TRUE(std::ranges::all_of(recording.u, [](double u) { return std::isfinite(u); })) << given.text();
    const MethodName exact = given.span              ? MethodName::fully_discrete
                             : given.viscosity > 0.0 ? MethodName::rigid
                                                     : MethodName::characteristics;
    EXPECT_EQ(is_penalised(run.method), given.epsilon) << given.text();
    if (!given.epsilon) {
      EXPECT_EQ(run.method, exact) << given.text();
    }
    EXPECT_EQ(run.warning, "");
  }
}

TEST(Automatic, TakesTheFirstMassThatTheMethodTakes) {
  const auto mass = [](Given given) { return resolve(given.run()).mass; };
  EXPECT_EQ(mass({.viscosity = 0.1}), Mass::fourth_order);
  EXPECT_EQ(mass({.span = true}), Mass::lumped) << "nothing damps what impacts leave";
  EXPECT_EQ(mass({.span = true, .viscosity = 0.1}), Mass::fourth_order);
  EXPECT_EQ(mass({.span = true, .restitution = true, .viscosity = 0.1}), Mass::lumped) << "nodes are thrown back";
  EXPECT_EQ(mass({.span = true, .epsilon = true}), Mass::consistent);
  EXPECT_EQ(mass({.epsilon = true}), Mass::redistributed);
  EXPECT_EQ(mass({.left = "free", .epsilon = true}), Mass::fourth_order);
  EXPECT_EQ(mass({.mass = "lumped", .viscosity = 0.1}), Mass::lumped);
  // Its end rows reach three nodes, of equal elements.
  EXPECT_EQ(mass({.viscosity = 0.1, .elements = 2}), Mass::redistributed);
  EXPECT_EQ(mass({.viscosity = 0.1, .elements = 1}), Mass::consistent);
  EXPECT_EQ(mass({.epsilon = true, .more = "[method]\nname = \"cvode\"\n"}), Mass::consistent)
      << "takes no algebraic rows";
  EXPECT_EQ(mass({.epsilon = true, .elements = 2, .more = "[method]\nname = \"ida\"\n"}), Mass::redistributed);
  EXPECT_EQ(mass({.span = true, .epsilon = true, .elements = 2}), Mass::consistent);
  EXPECT_EQ(mass({.viscosity = 0.1, .more = "[method]\nname = \"finite_difference\"\nstep = 0.01\n"}), Mass::lumped);
  EXPECT_EQ(mass({.viscosity = 0.1, .more = "[method]\nname = \"fully_discrete\"\nstep = 0.01\n"}), Mass::fourth_order);
  Given graded{.viscosity = 0.1};
  graded.mass = "consistent";
  Case run = graded.run();
  run.mass.reset();
  run.grading = 4.0;
  EXPECT_EQ(resolve(run).mass, Mass::fourth_order);
  run.grading = 1.0;
  run.nodes = std::make_shared<const std::vector<double>>(std::vector<double>{0.0, 0.1, 0.5, 1.0});
  EXPECT_EQ(resolve(run).mass, Mass::redistributed) << "an element is four times its neighbour";
}

// Pressed between two obstacles: each flight of an end leaves two breaks, and these make further flights.
constexpr const char* rough = R"scene(
[bar]
length = 1.0
[left]
kind = "obstacle"
gap = 0.1
[right]
kind = "obstacle"
gap = 0.1
[initial]
displacement = "0.4*x*(1-x)"
velocity = "-0.5-x"
[load]
density = -1.0
[mesh]
elements = 8
[output]
every = 1.0
)scene";

TEST(Automatic, TakesRigidAndSaysWhyWhereTheWavesBreakWithoutEnd) {
  const Case smooth = parse_scene(std::string(rough) + "[time]\nend = 20.0\n", "scene").run;
  EXPECT_EQ(smooth.method, MethodName::characteristics);
  EXPECT_EQ(smooth.warning, "");
  const Case run = parse_scene(std::string(rough) + "[time]\nend = 120.0\n", "scene").run;
  EXPECT_EQ(run.method, MethodName::rigid);
  EXPECT_EQ(resolve(run).mass, Mass::fourth_order);
  EXPECT_NE(run.warning.find("10,000 pieces"), std::string::npos) << run.warning;
  EXPECT_TRUE(record(run).statistics.completed);
}

// The breaks of such loads are places that travel; to follow them to rounding takes a search for each wave's way.
TEST(Automatic, TakesRigidAndSaysWhyWhereALoadTravels) {
  for (const char* load :
       {"x < 0.4*t ? -2 : 0", "x > 0.4*t-0.1 && x < 0.4*t ? -2 : 0", "abs(x-0.3-0.2*t) < 0.1 ? 1 : 0"}) {
    Given given{.left = "free", .elements = 20};
    given.load = load;
    const Case run = given.run();
    EXPECT_EQ(run.method, MethodName::rigid) << load;
    EXPECT_NE(run.warning.find("travel"), std::string::npos) << run.warning;
    given.more = "[method]\nname = \"characteristics\"\n";
    EXPECT_EQ(given.run().method, MethodName::characteristics);
  }
  for (const char* load : {"-1-x*sin(t)", "t < 0.4 ? -2*x : x", "sin(9*x)*cos(7*t)"}) {
    Given given{.left = "free", .elements = 20};
    given.load = load;
    EXPECT_EQ(given.run().method, MethodName::characteristics) << load;
  }
}

// A string of speed 1 that is plucked in its middle over a flat barrier, which throws it back: it moves as if there
// were no barrier, but for its sign, for it meets the barrier with all its nodes at once.
TEST(Automatic, ConvergesWhereAStringIsThrownBackByAFlatBarrier) {
  const auto hat = [](double s) {
    s = std::fmod(s + 4.0, 2.0);
    const double x = s > 1.0 ? 2.0 - s : s, u = 0.2 * std::min(x, 1.0 - x);
    return s > 1.0 ? -u : u;
  };
  std::vector<double> errors;
  for (const std::size_t elements : {40, 80, 160}) {
    const Case run =
        parse_scene(fmt::format("[bar]\nlength = 1.0\n[left]\nkind = \"fixed\"\n[right]\nkind = \"fixed\"\n"
                                "[span]\ngap = 0.0\n[initial]\ndisplacement = \"0.1-0.2*abs(x-0.5)\"\n"
                                "[contact]\nrestitution = 1.0\n[time]\nend = 1.0\n[output]\nevery = 0.1\n"
                                "[mesh]\nelements = {}\n",
                                elements),
                    "scene")
            .run;
    const Recording recording = record(run);
    double error = 0.0;
    for (std::size_t k = 0; k < recording.times.size(); ++k)
      for (std::size_t j = 0; j <= elements; ++j) {
        const double x = static_cast<double>(j) / static_cast<double>(elements), t = recording.times[k];
        const double exact = std::abs(hat(x - t) + hat(x + t)) / 2.0;
        error = std::max(error, std::abs(recording.u[k * (elements + 1) + j] - exact));
      }
    errors.push_back(error);
  }
  // Kinks that travel are met with order 2/3 by a mesh of order 2; twice on two halvings is order 1/2.
  EXPECT_LT(errors[1], errors[0]);
  EXPECT_LT(errors[2], errors[0] / 2.0);
}

TEST(Automatic, TakesRigidAndSaysWhyWhereALoadTakesTooManyValues) {
  const auto choice = [](double every) {
    Given given;
    Case run = given.run();
    run.scene.load = GeneralLoad{[](double x, double t) { return std::sin(40.0 * x * t); }};
    run.end = 1.0;
    run.output_every = every;
    return automatic_method(run);
  };
  EXPECT_EQ(choice(0.1).method, MethodName::characteristics);
  EXPECT_EQ(choice(1e-6).method, MethodName::rigid);
  EXPECT_NE(choice(1e-6).warning.find("evaluations for 1000000 outputs"), std::string::npos) << choice(1e-6).warning;
}

TEST(Automatic, TakesRigidAndSaysWhyWhereADisplacementJumps) {
  Given given;
  Case run = given.run();
  run.scene.displacement = [](double x) { return x < 0.5 ? 0.0 : 0.1; };
  const AutomaticMethod choice = automatic_method(run);
  EXPECT_EQ(choice.method, MethodName::rigid);
  EXPECT_NE(choice.warning.find("jumps"), std::string::npos) << choice.warning;
}

// The look ahead ends: a motion that is periodic is believed to remain so.
TEST(Automatic, DoesNotFollowAMotionForEverToChooseItsMethod) {
  Scene scene = Given{.right = "fixed"}.run().scene;
  scene.displacement = [](double x) { return (1 - x) / 2; };
  scene.velocity = [](double) { return 0.0; };
  scene.left = Obstacle{0.0};
  EXPECT_EQ(roughens(scene, 1e9), std::nullopt);
}

}  // namespace
}  // namespace viscobar
