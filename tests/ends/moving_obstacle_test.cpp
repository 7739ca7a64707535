// An obstacle that moves is nothing to a bar that does not come to it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/maximum_norm.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

struct Untouched {
  std::string moving, still;  ///< the obstacle's end
  std::string rest;           ///< of the scene
};

// Nothing of the obstacle but its moving gap differs between the two ends of a pair.
std::vector<Untouched> untouched() {
  const auto obstacle = [](const std::string& end, const std::string& gap, const std::string& more = "") {
    return "[" + end + "]\nkind = \"obstacle\"\ngap = " + gap + "\n" + more;
  };
  return {
      // It flies away ever faster.
      {obstacle("left", "\"100+100*t^2\""), obstacle("left", "100"),
       "[right]\nkind = \"free\"\nforce = \"sin(3*t)\"\n[initial]\nvelocity = 1.0\n"},
      // It shakes in front of a bar whose other end is moved.
      {obstacle("right", "\"0.6+0.25*sin(40*t)\"", "side = \"above\"\n"),
       obstacle("right", "0.6", "side = \"above\"\n"), "[left]\nkind = \"fixed\"\nmotion = \"0.1*sin(3*t)\"\n"},
      // It flees from the bar, at the same speed at last, and its motion has kinks.
      {obstacle("left", "\"0.2+2*t-max(0,t-1.3)\""), obstacle("left", "50"), "[initial]\nvelocity = \"-1-0.1*x\"\n"},
      // It comes and goes where the end has been, and both ends have one.
      {obstacle("left", "\"1+0.9*cos(2*t)\"", "stiffness = 0.3\n") + obstacle("right", "\"3-t\"", "dashpot = 0.2\n"),
       obstacle("left", "9", "stiffness = 0.3\n") + obstacle("right", "9", "dashpot = 0.2\n"),
       "[initial]\nvelocity = 0.7\ndisplacement = \"0.3*x^2\"\n"},
  };
}

std::string numerics(const std::string& method, const std::string& mass) {
  return fmt::format(
      "[time]\nend = 2.5\n[mesh]\nelements = 12\nmass = \"{}\"\n[method]\nname = \"{}\"\nstep = 0.005\n[contact]\nepsilon "
      "= 1e-4\n[output]\nevery = 0.11\n",
      mass, method);
}

const std::pair<const char*, const char*> methods_and_masses[] = {
    {"cvode", "fourth_order"},        {"ida", "consistent"},          {"arkode", "lumped"},
    {"odeint", "fourth_order"},       {"rigid", "fourth_order"},      {"exponential", "consistent"},
    {"fully_discrete", "consistent"}, {"finite_difference", "lumped"}};

TEST(MovingObstacle, ThatIsNotTouchedChangesNoDigitAndNoStep) {
  for (const auto& [moving, still, rest] : untouched())
    for (const auto& [method, mass] : methods_and_masses) {
      // A spring is at odds with some masses only where there is no mass.
      SCOPED_TRACE(std::string(method) + "\n" + moving + rest);
      const std::string head = "[bar]\nlength = 1.0\nviscosity = 0.1\n", how = numerics(method, mass);
      const Recording a = record(parse_scene(head + moving + rest + how, "").run);
      const Recording b = record(parse_scene(head + still + rest + how, "").run);
      EXPECT_TRUE(a.events.empty());
      EXPECT_EQ(a.statistics.steps, b.statistics.steps);
      EXPECT_EQ(a.u, b.u);
      EXPECT_EQ(a.v, b.v);
      EXPECT_EQ(a.reaction_left, b.reaction_left);
      EXPECT_EQ(a.reaction_right, b.reaction_right);
      const EnergyAccount &e = a.statistics.energy.value(), &f = b.statistics.energy.value();
      EXPECT_EQ(e.initial, f.initial);
      EXPECT_EQ(e.final, f.final);
      EXPECT_EQ(e.work, f.work);
      EXPECT_EQ(e.dissipated, f.dissipated);
      EXPECT_EQ(a.statistics.account->left.lowest, b.statistics.account->left.lowest);
      EXPECT_EQ(a.statistics.account->right.highest, b.statistics.account->right.highest);
    }
}

TEST(MovingObstacle, ThatIsNotTouchedHasNoDerivative) {
  for (const auto& [moving, still, rest] : untouched())
    for (const char* method : {"cvode", "ida", "arkode", "rigid"}) {
      SCOPED_TRACE(std::string(method) + "\n" + moving + rest);
      const std::string head = "[parameters]\nshift = 0.0\n[bar]\nlength = 1.0\nviscosity = 0.1\n";
      const std::string how =
          numerics(method, "consistent") + "[sensitivity]\nof = [\"bar.viscosity\", \"parameters.shift\"]\n";
      std::string shifted = moving;
      shifted.replace(shifted.find("gap = \"") + 7, 0, "shift+");
      const Recording a = record(parse_scene(head + shifted + rest + how, "").run);
      const Recording b = record(parse_scene(head + still + rest + how, "").run);
      ASSERT_EQ(a.sensitivities.size(), 2u);
      EXPECT_EQ(a.u, b.u);
      EXPECT_EQ(a.sensitivities[0].u, b.sensitivities[0].u);
      EXPECT_EQ(a.sensitivities[0].v, b.sensitivities[0].v);
      for (const double slope : a.sensitivities[1].u) EXPECT_EQ(slope, 0.0);
    }
}

// A bar that may come to it within the first step is followed from the start, and all outputs are there. The methods
// agree within ten of their tolerances.
TEST(MovingObstacle, ThatIsNearAtTheStartIsFollowedFromThere) {
  const auto end_of = [](const char* method, const char* viscosity) {
    const std::string head = fmt::format("[bar]\nlength = 1.0\nviscosity = {}\n", viscosity);
    const Recording run =
        record(parse_scene(
                   head +
                       "[left]\nkind = \"obstacle\"\ngap = \"0.001+0.01*t\"\n[initial]\nvelocity = -1.0\n[time]\nend = "
                       "2.0\n[mesh]\nelements = 8\nmass = \"lumped\"\n[contact]\nepsilon = 1e-2\n[method]\nname = \"" +
                       method + "\"\nrelative_tolerance = 1e-10\n",
                   "")
                   .run);
    EXPECT_EQ(run.times.front(), 0.0);
    EXPECT_EQ(run.displacement(0)[0], 0.0);
    EXPECT_FALSE(run.events.empty());
    return run.displacement(run.times.size() - 1)[0];
  };
  for (const char* viscosity : {"0.0", "0.1"})
    EXPECT_NEAR(end_of("exponential", viscosity), end_of("arkode", viscosity), 1e-9) << viscosity;
}

// (2.8) with a start of first order: u^1 = u^0 + dt u_1 of the bar itself, whatever the obstacle does. The bar flies at
// its velocity, and u(dt) is to rounding where that leads.
TEST(MovingObstacle, SchemesStartWithTheVelocityOfTheBar) {
  for (const std::string end : {"kind = \"obstacle\"\ngap = \"1+5*t^2\"\n", "kind = \"free\"\n"})
    for (const char* method : {"fully_discrete", "finite_difference"}) {
      const std::string text = "[bar]\nlength = 1.0\n[left]\n" + end +
                               "[initial]\nvelocity = 1.0\n[time]\nend = 1.0\n[mesh]\nelements = 10\nmass = "
                               "\"lumped\"\n[method]\nname = \"" +
                               method + "\"\nstep = 0.01\nstart = \"first_order\"\n";
      const Recording run = record(parse_scene(text, "").run);
      for (std::size_t j = 0; j < run.mesh.nodes(); ++j)
        EXPECT_NEAR(run.displacement(run.times.size() - 1)[j], 1.0, 1e-13) << end << method;
    }
}

// A bar that rests on an obstacle is free as that jumps away, and meets it where it is then. The schemes know no frame,
// and come to the same with their step.
TEST(MovingObstacle, ThatJumpsAwayLetsTheBarGo) {
  const auto scene = [](const std::string& end, const std::string& method, double step, const std::string& mass) {
    return fmt::format(
        "[bar]\nlength = 1\nviscosity = 0.1\n{}[time]\nend = 2\n[mesh]\nelements = 16\nmass = \"{}\"\n[contact]\n"
        "epsilon = 1e-7\nrestitution = 0\n[method]\nname = \"{}\"\nrelative_tolerance = 1e-9\nstep = {}\n"
        "[output]\nevery = 0.05\n",
        end, mass, method, step);
  };
  const auto apart = [](const Recording& a, const Recording& b) { return distance(a.u, b.u); };
  const std::string left = "[left]\nkind = \"obstacle\"\ngap = \"t < 0.5 ? 0.2 : 0.3\"\n";
  for (const std::string& end :
       {left + "[initial]\nvelocity = -1\n", left + "[initial]\nvelocity = -1\n[right]\nkind = \"free\"\nmass = 0.3\n",
        left + "[right]\nkind = \"fixed\"\nmotion = \"-0.3*t\"\n[initial]\nvelocity = \"-(1-x)-0.3*x\"\n",
        std::string(
            "[right]\nkind = \"obstacle\"\nside = \"above\"\ngap = \"t < 0.5 ? 0.2 : 0.3 - 0.02*t\"\n[initial]\n"
            "velocity = 1\n")}) {
    SCOPED_TRACE(end);
    const Recording rigid = record(parse_scene(scene(end, "rigid", 1e-4, "consistent"), "").run);
    ASSERT_GE(rigid.events.size(), 3u);
    EXPECT_EQ(rigid.events[1].change, Change::opening);
    EXPECT_NEAR(rigid.events[1].time, 0.5, 1e-12);
    EXPECT_EQ(rigid.events[2].change, Change::closing);
    // Within a tolerance of the bar's energy.
    EXPECT_NEAR(rigid.statistics.energy->balance_error(), 0.0, 1e-6);
    const Recording coarse = record(parse_scene(scene(end, "fully_discrete", 4e-4, "consistent"), "").run);
    const Recording fine = record(parse_scene(scene(end, "fully_discrete", 1e-4, "consistent"), "").run);
    EXPECT_NEAR(std::log(apart(coarse, rigid) / apart(fine, rigid)) / std::log(4.0), 1.0, 0.15)
        << apart(coarse, rigid) << " " << apart(fine, rigid);
    // A node that rests gives way by epsilon times its reaction, and takes as long to stop as its dashpot lets it.
    for (const std::string method : {"cvode", "ida", "arkode", "odeint", "exponential"}) {
      const Recording penalised = record(parse_scene(scene(end, method, 1e-4, "consistent"), "").run);
      EXPECT_LT(apart(penalised, rigid), 1e-3) << method;
      for (const auto side : {&RunAccount::left, &RunAccount::right})
        EXPECT_NEAR(((*penalised.statistics.account).*side).impulse, ((*rigid.statistics.account).*side).impulse, 1e-3)
            << method;
      EXPECT_EQ(penalised.events.size(), rigid.events.size()) << method;
      EXPECT_NEAR(penalised.statistics.energy->balance_error(), 0.0, 1e-6) << method;
    }
  }
}

// The stop has so much of a damper that it lets go where the obstacle stops, at t = 0.775. The bar's own velocities do
// not jump there, and its end has that which the opening tells.
TEST(MovingObstacle, WhoseKinkLetsTheBarGoHasItOnce) {
  for (const char* method : {"cvode", "ida", "arkode", "odeint", "exponential"}) {
    const Recording found = record(parse_scene(fmt::format(R"~(
[bar]
length = 1.2
viscosity = 0.08
[left]
kind = "obstacle"
gap = "max(0.1 - 0.4*t, -0.21)"
contact = {{ law = "spring_damper", stiffness = 50.0, damping = 6.0 }}
[right]
kind = "free"
force = -0.8
dashpot = 0.2
[mesh]
elements = 10
mass = "fourth_order"
[method]
name = "{}"
relative_tolerance = 1e-8
[time]
end = 0.7751
[output]
every = 0.00021
)~",
                                                           method),
                                               "", {})
                                       .run);
    ASSERT_EQ(found.events.size(), 2u) << method;
    EXPECT_EQ(found.events[1].change, Change::opening);
    EXPECT_NEAR(found.events[1].time, 0.775, 1e-12) << method;
    const std::size_t nodes = found.mesh.nodes();
    ASSERT_EQ(found.v.size() % nodes, 0u);
    const double *after = &found.v[found.v.size() - nodes], *before = after - nodes;
    EXPECT_LT(found.times[found.times.size() - 2], 0.775);
    for (const std::size_t j : {std::size_t{0}, nodes - 1}) EXPECT_NEAR(after[j], before[j], 0.03) << method;
    EXPECT_NEAR(found.events[1].velocity, before[0], 0.01) << method;
  }
}

TEST(MovingObstacle, ThatJumpsIntoTheBarIsRefusedAndOneThatJumpsAwayRuns) {
  const auto scene = [](const std::string& gap, const std::string& method, double viscosity = 0.1) {
    return fmt::format(
        "[bar]\nlength = 1\nviscosity = {}\n[left]\nkind = \"obstacle\"\ngap = \"{}\"\n[initial]\nvelocity = -1\n"
        "[time]\nend = 1\n[mesh]\nelements = 10\n[method]\nname = \"{}\"\nstep = 1e-3\n",
        viscosity, gap, method);
  };
  for (const std::string method :
       {"rigid", "cvode", "ida", "arkode", "odeint", "exponential", "fully_discrete", "finite_difference"}) {
    for (const char* gap : {"t < 0.5 ? 0.2 : 0.1", "t < 0.5 ? 0.9 : 0.4"})  // that it rests on, or has not met
      try {
        record(parse_scene(scene(gap, method), "").run);
        FAIL() << method << " " << gap;
      } catch (const IntegrationError& error) {
        EXPECT_EQ(error.failure, Failure::load) << method;
        EXPECT_NE(std::string(error.what()).find("jumps into the bar at t = 0.5"), std::string::npos) << error.what();
        if (std::string(gap).find("0.9") == std::string::npos || method == "finite_difference") continue;
        EXPECT_NEAR(error.statistics.account->left.lowest, -0.5, 2e-3) << method;
        EXPECT_NEAR(error.statistics.account->left.highest, 0.0, 1e-12) << method;
        EXPECT_NEAR(error.statistics.energy->final, 0.5, 1e-12) << method;
        EXPECT_NEAR(error.statistics.energy->balance_error(), 0.0, 1e-12) << method;
      }
    // The bar is at -0.5 then, and 0.55 is free.
    const Recording near = record(parse_scene(scene("t < 0.5 ? 0.9 : 0.55", method), "").run);
    ASSERT_FALSE(near.events.empty()) << method;
    EXPECT_NEAR(near.events[0].time, 0.55, 2e-3) << method;
    // A bar in flight where it jumps, on either side of that.
    const Recording away = record(parse_scene(scene("t < 0.5 ? 1.1 : 1.9", method), "").run);
    EXPECT_NEAR(away.statistics.account->left.lowest, -1.0, 1e-12) << method;
    EXPECT_NEAR(away.statistics.account->left.highest, 0.0, 1e-12) << method;
    const Recording far = record(parse_scene(scene("t < 0.1 ? 0.9 : 0.7", method), "").run);
    ASSERT_FALSE(far.events.empty()) << method;
    EXPECT_NEAR(far.events[0].time, 0.7, 2e-3) << method;
  }
  EXPECT_EQ(parse_scene(scene("t < 0.5 ? 0.2 : 0.3", "automatic", 0.0), "").run.method, MethodName::rigid);
}

// The obstacle jumps away from a bar that has left it, or from one that it holds, which comes to it again.
TEST(MovingObstacle, ThatJumpsAwayLeavesTheDerivativesThatDifferencesHave) {
  const std::vector<std::string> keys = {"bar.viscosity", "parameters.near", "parameters.far"};
  for (const auto& [jump, contact] : {std::pair{2.8, "epsilon = 1e-2\n"},
                                      {2.8, "law = \"spring_damper\"\nstiffness = 60\ndamping = 1\n"},
                                      {0.6, "epsilon = 1e-2\n"}}) {
    const std::string scene = fmt::format(
        "[bar]\nlength = 1\nviscosity = 0.2\n[parameters]\nnear = 0.1\nfar = 0.3\n[left]\nkind = \"obstacle\"\n"
        "gap = \"t < {} ? near : far\"\n[right]\nkind = \"free\"\nforce = -0.4\n[initial]\nvelocity = \"-1 + 0.1*x\"\n"
        "[time]\nend = 6\n[mesh]\nelements = 8\nmass = \"consistent\"\n[contact]\n{}[output]\nevery = 0.1\n",
        jump, contact);
    for (const std::string method : {"cvode", "ida", "arkode", "rigid"}) {
      if (method == "rigid" && scene.find("law") != scene.npos) continue;
      SCOPED_TRACE(method + " " + contact);
      const auto run = [&](std::vector<std::string> set) {
        set.insert(set.end(), {"method.name=" + method, "method.relative_tolerance=1e-10"});
        return record(parse_scene(scene, "", set).run);
      };
      const Recording bar = run({"sensitivity.of=[\"bar.viscosity\", \"parameters.near\", \"parameters.far\"]"});
      ASSERT_TRUE(bar.statistics.sensitivity);
      EXPECT_FALSE(bar.statistics.sensitivity->lost) << bar.statistics.sensitivity->why;
      const bool held = jump < 1.0;
      ASSERT_GE(bar.events.size(), 3u);
      EXPECT_EQ(std::abs(bar.events[1].time - jump) < 1e-12, held) << bar.events[1].time;
      EXPECT_GT(bar.events[2].time, jump);
      const std::vector<double> values = {0.2, 0.1, 0.3};
      for (std::size_t k = 0; k < keys.size(); ++k) {
        const double step = 1e-4;
        const Recording more = run({fmt::format("{}={}", keys[k], values[k] + step)});
        const Recording less = run({fmt::format("{}={}", keys[k], values[k] - step)});
        // Differences are right to the square of the step, and to the tolerance over it.
        double off = 0.0, most = 0.0;
        for (std::size_t i = 0; i < bar.u.size(); ++i) {
          const double difference = (more.u[i] - less.u[i]) / (2 * step);
          most = std::max(most, std::abs(difference));
          off = std::max(off, std::abs(bar.sensitivities[k].u[i] - difference));
        }
        EXPECT_LT(off, 2e-4 * std::max(1.0, most)) << keys[k];
      }
    }
  }
}

// The values beside the sample at which a record comes back to 0 have a rounding that 0 has not.
TEST(MovingObstacle, ARecordThatComesBackToZeroDoesNotJump) {
  std::string times = "0", values = "0";
  for (int k = 1; k <= 20; ++k) {
    times += fmt::format(", {}", 0.1 * k);
    values += fmt::format(", {:.4f}",
                          k > 5 && k < 13 ? 0.025 * (1.0 - std::cos(2.0 * std::numbers::pi * (k - 5) / 8.0)) : 0.0);
  }
  const std::string series = fmt::format("{{ t = [{}], values = [{}] }}\n", times, values);
  const std::string rest =
      "[time]\nend = 2\n[mesh]\nelements = 10\n[bar]\nlength = 1\nviscosity = 0.1\n[method]\nname = \"{}\"\n";
  for (const std::string& end : {"[left]\nkind = \"fixed\"\nmotion = " + series,
                                 "[left]\nkind = \"obstacle\"\ngap = " + series + "[load]\ndensity = -1.0\n"})
    for (const char* method : {"rigid", "cvode", "arkode", "exponential", "fully_discrete"})
      EXPECT_NO_THROW(record(parse_scene(end + fmt::format(fmt::runtime(rest), method), "").run)) << end << method;
}

}  // namespace
}  // namespace viscobar
