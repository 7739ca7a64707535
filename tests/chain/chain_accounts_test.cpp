// Bodies that are held or meet an obstacle beside a joint, breaks at joints, sides: each against another way to the
// same motion.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "studies/accuracy/quick_estimate.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar::chain_accounts {
namespace {

Case case_of(const std::string& text, const std::vector<std::string>& settings = {}) {
  return parse_scene(text, "", settings).run;
}

// The bar's first node is none of the body's: rho h / 24 (7, 6, -1) is its row.
TEST(ChainAccounts, ABarOnASpringOfABodyThatIsHeldMovesAsOnASpringOfTheGround) {
  const std::string rest =
      "[initial]\nvelocity = -1.0\n[time]\nend = 3.0\n[mesh]\nelements = 20\n[method]\nname = \"{}\"\n"
      "relative_tolerance = 1e-9\nstep = 1e-3\n";
  const std::string bar = "length = 1.0\nviscosity = 0.1\n";
  for (const char* method : {"rigid", "cvode", "ida", "arkode", "odeint", "exponential", "fully_discrete"}) {
    const std::string end = fmt::format(fmt::runtime(rest), method);
    const Recording alone = record(case_of("[bar]\n" + bar + "[left]\nkind = \"free\"\nstiffness = 5.0\n" + end));
    const Recording held =
        record(case_of("[[bar]]\nmass = 1.0\n[[bar]]\n" + bar +
                       "[[joint]]\nkind = \"spring\"\nstiffness = 5.0\n[left]\nkind = \"fixed\"\n" + end));
    const Recording mirrored =
        record(case_of("[[bar]]\n" + bar +
                       "[[bar]]\nmass = 1.0\n[[joint]]\nkind = \"spring\"\nstiffness = 5.0\n[right]\nkind "
                       "= \"fixed\"\n" +
                       end));
    ASSERT_EQ(alone.times.size(), held.times.size());
    for (std::size_t k = 0; k < alone.times.size(); ++k) {
      EXPECT_NEAR(alone.displacement(k).back(), held.displacement(k).back(), 1e-7) << method << " " << alone.times[k];
      EXPECT_NEAR(alone.displacement(k).back(), mirrored.displacement(k).front(), 1e-7)
          << method << " " << alone.times[k];
    }
    // A scheme has it at t = dt / 2, larger by k (dt / 2)^2 / 2.
    EXPECT_NEAR(held.statistics.energy->initial, 0.5, 5.0 * 2.5e-7 + 1e-12) << method;
  }
}

// The body leaves its stop at speed v where k d + c d' = 0, d = c v / k deep, and then has the gap and d to go.
TEST(ChainAccounts, ABodyThatLeavesItsObstacleMeetsTheBarWhereItStands) {
  const std::string text =
      "[[bar]]\nmass = 1.0\nvelocity = -2.0\n[[bar]]\nlength = 1.0\nviscosity = 0.05\nvelocity = 0.0\n[[joint]]\nkind = "
      "\"contact\"\nlaw = \"hertz\"\nstiffness = 50.0\n[left]\nkind = \"obstacle\"\ngap = 0.2\ncontact = {{ law = "
      "\"spring_damper\", stiffness = 240.0, damping = 0.4 }}\n[right]\nkind = \"fixed\"\n[time]\nend = 1.0\n[mesh]\nelements "
      "= 20\n[method]\nname = \"{}\"\nrelative_tolerance = 1e-9\n";
  for (const char* method : {"cvode", "ida", "arkode", "odeint"}) {
    const Recording run = record(case_of(fmt::format(fmt::runtime(text), method)));
    ASSERT_GE(run.events.size(), 3u) << method;
    const Event &left = run.events[1], &met = run.events[2];
    EXPECT_EQ(left.change, Change::opening);
    EXPECT_EQ(met.where, Where::joint);
    EXPECT_NEAR(met.time, left.time + 0.2 / left.velocity + 0.4 / 240.0, 1e-7) << method;
    EXPECT_NEAR(run.statistics.energy->balance_error(), 0.0, 1e-6) << method;
  }
}

// The first steps in a contact are as short as 1e-14: rounding of a momentum over such a step is no force. A depth is
// wrong by 100 tolerances at most, 1e-7, its force by that over epsilon.
TEST(ChainAccounts, ABriefTouchHasThePeakOfItsSpring) {
  const std::string text =
      "[[bar]]\nlength = 0.7\nvelocity = -0.9\nelements = 6\n[[bar]]\nmass = 1.0\nvelocity = {}\n[[bar]]\nlength = "
      "0.6\nviscosity = 0.35\nelements = 7\nvelocity = 0.05\n[[joint]]\nkind = \"contact\"\n[left]\nkind = "
      "\"free\"\n[right]\nkind = \"fixed\"\n[time]\nend = 0.5\n[contact]\nepsilon = 0.07\n[method]\nname = "
      "\"{}\"\nrelative_tolerance = 1e-9\n";
  for (const double velocity : {-0.93, -0.95, -0.97, -1.0}) {
    const auto peak = [&](const char* method) {
      const Recording run = record(case_of(fmt::format(fmt::runtime(text), velocity, method)));
      return run.statistics.account->joints.front().peak_reaction;
    };
    const double truth = peak("exponential");
    EXPECT_GT(truth, 4e-5);
    for (const char* method : {"cvode", "ida", "arkode", "odeint"})
      EXPECT_NEAR(peak(method), truth, 1e-7 / 0.07) << method << " " << velocity;
  }
}

// Another contact changes beside it, behind which the first steps are shorter than the roundings of their times; the
// force with which a weak dashpot begins is no measure of what follows.
TEST(ChainAccounts, AContactKeepsItsPeakWhereAnotherChanges) {
  const std::string text =
      "[[bar]]\nlength = 1.0\nvelocity = -{0}\nelements = 7\n[[bar]]\nmass = {2}\nvelocity = -{1}\n[[joint]]\nkind = "
      "\"contact\"\ngap = {3}\nlaw = \"spring_damper\"\nstiffness = {4}\ndamping = {5}\n[left]\nkind = \"obstacle\"\n"
      "gap = 0.1\n[time]\nend = 3.0\n[mesh]\nmass = \"consistent\"\n[contact]\nepsilon = {6}\n[method]\nname = \"{7}\"\n"
      "relative_tolerance = 3e-11\n";
  const auto peak = [&](bool damped, const char* method) {
    const std::string scene = damped ? fmt::format(fmt::runtime(text), 1.5, 3.0, 1.7, 0.09, 50.0, 0.001, 0.01, method)
                                     : fmt::format(fmt::runtime(text), 0.8, 1.6, 1.1, 0.06, 200.0, 0.0, 0.001, method);
    return record(case_of(scene)).statistics.account->joints.front().peak_reaction;
  };
  for (const bool damped : {true, false}) {
    const double truth = peak(damped, "exponential");
    for (const char* method : {"cvode", "ida", "arkode", "odeint"})
      EXPECT_NEAR(peak(damped, method), truth, 1e-5 * truth) << method << damped;
  }
}

// Without rebound zeta is 1, and the force is largest as it begins: c v with c = 2 (m / epsilon)^(1/2). Of two bodies m
// is the mass of their impact, and the node of the bar has the mass 0.8 h / 2. The first steps behind the closing are
// so short that they tell the force by roundings.
TEST(ChainAccounts, ADashpotBeginsWithThePeakOfItsContact) {
  const std::string bodies =
      "[[bar]]\nmass = 2.0\nvelocity = 1.0\n[[bar]]\nmass = 1.0\nvelocity = 0.0\n[[bar]]\nlength = 1.0\nviscosity = "
      "0.1\nelements = 4\n[[joint]]\nkind = \"contact\"\ngap = 0.1\n[[joint]]\nkind = \"contact\"\ngap = 5.0\n";
  const std::string of_bar =
      "[[bar]]\nmass = 0.5\nvelocity = 1.0\n[[bar]]\nlength = 0.7\ndensity = 0.8\nmodulus = 1.5\nviscosity = "
      "0.05\nvelocity = -0.1\nelements = 5\n[[joint]]\nkind = \"contact\"\ngap = 0.1\n[mesh]\nmass = \"lumped\"\n";
  const double node = 0.8 * 0.14 / 2.0;
  for (const auto& [chain, mass, speed] :
       {std::tuple{bodies, 2.0 / 3.0, 1.0}, std::tuple{of_bar, 0.5 * node / (0.5 + node), 1.1}})
    for (const double epsilon : {1e-2, 1e-4, 1e-5, 1e-6})
      for (const char* method : {"cvode", "ida", "arkode", "odeint", "exponential"}) {
        const Recording run = record(case_of(
            chain + fmt::format("[time]\nend = 0.4\n[contact]\nepsilon = {}\nrestitution = 0.0\n[method]\nname = "
                                "\"{}\"\nrelative_tolerance = 1e-8\n",
                                epsilon, method)));
        const double peak = 2.0 * std::sqrt(mass / epsilon) * speed;
        EXPECT_NEAR(run.statistics.account->joints.front().peak_reaction, peak, 1e-5 * peak)
            << method << " " << epsilon;
      }
}

// Penalties on both sides of a body.
TEST(ChainAccounts, ABodyBetweenAnObstacleAndABarKeepsTheEnergy) {
  const std::string text =
      "[[bar]]\nmass = 1.0\nvelocity = 0.0\n[[bar]]\nlength = 1.0\nviscosity = 0.1\nvelocity = -1.0\n[[joint]]\nkind = "
      "\"contact\"\n[left]\nkind = \"obstacle\"\ngap = 0.1\n[time]\nend = 2.0\n[mesh]\nelements = 20\n[contact]\nepsilon = "
      "1e-4\n[method]\nname = \"{}\"\nrelative_tolerance = 1e-9\n";
  const Recording exact = record(case_of(fmt::format(fmt::runtime(text), "exponential")));
  for (const char* method : {"cvode", "ida", "arkode", "odeint"}) {
    const Recording run = record(case_of(fmt::format(fmt::runtime(text), method)));
    EXPECT_NEAR(run.statistics.energy->balance_error(), 0.0, 1e-6) << method;
    EXPECT_NEAR(run.statistics.account->left.impulse, exact.statistics.account->left.impulse, 1e-5) << method;
    for (std::size_t k = 0; k < exact.times.size(); ++k)
      ASSERT_NEAR(run.displacement(k).back(), exact.displacement(k).back(), 1e-5) << method << " " << exact.times[k];
  }
}

// A break of the whole chain's velocity at a joint gives each bar its own: the same moments, but for roundings.
TEST(ChainAccounts, AVelocityThatBreaksAtAJointIsThatOfEachBar) {
  const auto text = [](const std::string& first, const std::string& second, const std::string& whole) {
    return "[[bar]]\nlength = 1.0\nviscosity = 0.1\nelements = 10\n" + first +
           "[[bar]]\nlength = 0.5\nviscosity = 0.1\nelements = 5\n" + second +
           "[[joint]]\nkind = \"contact\"\ngap = 0.05\n[initial]\nvelocity = " + whole + "\n[time]\nend = 2.0\n";
  };
  const Recording apart = record(case_of(text("velocity = 1.0\n", "velocity = 0.0\n", "0.0")));
  for (const char* whole : {"\"x<1 ? 1 : 0\"", "\"x<=1 ? 1 : 0\""}) {
    const Recording run = record(case_of(text("", "", whole)));
    for (std::size_t k = 0; k < apart.times.size(); ++k)
      for (std::size_t j = 0; j < apart.mesh.nodes(); ++j)
        ASSERT_NEAR(run.displacement(k)[j], apart.displacement(k)[j], 1e-12) << whole << " " << apart.times[k];
  }
}

TEST(ChainAccounts, TheImpulseOfAJointIsThatOfItsForceBesideASideThatResists) {
  const std::string text =
      "[[bar]]\nmass = 1.0\nvelocity = 1.0\n[[bar]]\nlength = 1.0\nviscosity = 0.1\nvelocity = 0.0\n[[joint]]\nkind = "
      "\"contact\"\n[side]\nstiffness = 2.0\ndrag = 0.5\n[contact]\nepsilon = 0.01\n[time]\nend = 3.0\n[mesh]\nelements = "
      "20\n[output]\nevery = 0.0005\n[method]\nname = \"{}\"\nrelative_tolerance = 1e-8\n";
  for (const char* method : {"cvode", "arkode", "exponential"}) {
    const Case run = case_of(fmt::format(fmt::runtime(text), method));
    std::vector<double> forces;
    Observers observers;
    observers.account = true;
    observers.snapshot = [&](const Snapshot& at) { forces.push_back(at.joint_forces.front()); };
    const Statistics done = simulate(resolve(run), observers);
    double integral = 0.0;
    for (std::size_t k = 1; k < forces.size(); ++k) integral += 0.5 * run.output_every * (forces[k] + forces[k - 1]);
    EXPECT_NEAR(done.account->joints.front().impulse, integral, 1e-5) << method;  // h^2 / 12 of the trapezoidal rule
    EXPECT_GT(integral, 1.0);
  }
}

// The force of a step of (2.8) leads to its end: half of it is of the contact that closes there.
TEST(ChainAccounts, ContactsOfAJointShareItsWholeImpulse) {
  for (const char* gap : {"0.1", "0.0"}) {
    const Recording run = record(case_of(fmt::format(
        "[[bar]]\nmass = 1.0\nvelocity = 1.0\n[[bar]]\nlength = 1.0\nviscosity = 0.1\nvelocity = 0.0\n[[joint]]\nkind "
        "= \"contact\"\ngap = {}\n[right]\nkind = \"fixed\"\n[time]\nend = 8.0\n[mesh]\nelements = 20\n[method]\nname = "
        "\"fully_discrete\"\nstep = 0.02\n",
        gap)));
    double sum = 0.0;
    std::size_t closings = 0;
    for (const Event& event : run.events) {
      ASSERT_EQ(event.where, Where::joint);
      closings += event.change == Change::closing;
      sum += event.change == Change::closing ? -event.impulse.value() : event.impulse.value();
    }
    const ContactAccount& joint = run.statistics.account->joints.front();
    ASSERT_EQ(run.events.size(), 2 * closings) << gap;
    EXPECT_EQ(closings, joint.closings);
    EXPECT_GT(joint.impulse, 1.0);
    EXPECT_NEAR(sum, joint.impulse, 1e-12) << gap;
  }
}

TEST(ChainAccounts, AnObstacleOnTheRightOfABodyReactsAsOneOnTheLeft) {
  const std::string rest =
      "[time]\nend = 4.0\n[mesh]\nelements = 20\nmass = \"lumped\"\n[method]\nname = \"fully_discrete\"\n";
  const std::string joint = "[[joint]]\nkind = \"contact\"\ngap = 0.1\n",
                    body = "[[bar]]\nmass = 1.0\nvelocity = 0.0\n";
  const auto bar = [](double velocity) {
    return fmt::format("[[bar]]\nlength = 1.0\nviscosity = 0.1\nvelocity = {}\n", velocity);
  };
  const Recording right =
      record(case_of(bar(1.0) + body + joint + "[right]\nkind = \"obstacle\"\ngap = 0.3\nside = \"above\"\n" + rest));
  const Recording left = record(case_of(body + bar(-1.0) + joint + "[left]\nkind = \"obstacle\"\ngap = 0.3\n" + rest));
  EXPECT_NEAR(right.statistics.account->right.impulse, -left.statistics.account->left.impulse, 1e-9);
  EXPECT_GT(left.statistics.account->left.impulse, 1.0);
  double most = 0.0;
  for (std::size_t k = 0; k < left.times.size(); ++k) {
    ASSERT_NEAR(right.reaction_right[k], -left.reaction_left[k], 1e-6) << left.times[k];
    most = std::max(most, left.reaction_left[k]);
  }
  EXPECT_GT(most, 0.5);
}

// A consistent mass couples the two faces of a bar of one element: an impact on one would pull at the other.
TEST(ChainAccounts, AnImpactOpensAContactThatItWouldPull) {
  const std::string text =
      "[[bar]]\nlength = 1.39\nviscosity = 0.00759\nelements = 3\nmodulus = 1.04\ndensity = 1.01\nvelocity = 0.0\n"
      "[[bar]]\nlength = 0.38\nviscosity = 0.00672\nelements = 1\nmodulus = 1.66\ndensity = 0.67\nvelocity = 0.039\n"
      "[[bar]]\nmass = 2.073\nvelocity = -1.067\n[[bar]]\nmass = 0.7677\nvelocity = 1.44\n[[joint]]\nkind = \"contact\"\n"
      "gap = 0.187\n[[joint]]\nkind = \"contact\"\ngap = 0.116\n[[joint]]\nkind = \"contact\"\ngap = 0.029\n[left]\n"
      "kind = \"fixed\"\n[right]\nkind = \"free\"\nstiffness = 3.032\nforce = \"-1.46*sin(2.17*t)\"\n[time]\nend = {}\n"
      "[mesh]\nmass = \"consistent\"\n[method]\nname = \"{}\"\nstep = 1e-5\n[contact]\nrestitution = 0.0\n";
  const auto run = [&](double end, const char* method) {
    return record(case_of(fmt::format(fmt::runtime(text), end, method)));
  };
  const Recording rigid = run(3.0, "rigid"), scheme = run(3.0, "fully_discrete");
  // Contacts of the scheme are at most a step off, at speeds below 2.
  for (std::size_t k = 0; k < rigid.times.size(); ++k)
    ASSERT_NEAR(rigid.displacement(k).back(), scheme.displacement(k).back(), 2.0 * 1e-5 * 10.0) << rigid.times[k];
  for (const std::size_t k : {0, 1, 2})
    EXPECT_NEAR(rigid.statistics.account->joints[k].impulse, scheme.statistics.account->joints[k].impulse, 1e-4) << k;
  // The impulse of no contact falls.
  double before = 0.0;
  for (const double end : {0.43, 0.43515, 0.43516, 0.44}) {
    const double impulse = run(end, "rigid").statistics.account->joints[1].impulse;
    EXPECT_GE(impulse, before - 1e-12) << end;
    before = impulse;
  }
}

// Pulled on by less than the bar knows, a body of 1.7e-5 would fly by its own.
TEST(ChainAccounts, ALightBodyIsLetGo) {
  const std::string text =
      "[[bar]]\nlength = 0.36\nviscosity = 0.179\nelements = 3\nmodulus = 2.06\ndensity = 2.83\nvelocity = -0.002\n[[bar]]\n"
      "mass = 1.707e-05\nvelocity = -0.167\n[[bar]]\nmass = 2.19\nvelocity = 1.02\n[[joint]]\nkind = \"contact\"\n[[joint]]\n"
      "kind = \"contact\"\ngap = 0.113\n[left]\nkind = \"free\"\nstiffness = 13.447\nmass = 0.953\n[time]\nend = 3.0\n"
      "[mesh]\nmass = \"lumped\"\n[method]\nname = \"{}\"\nstep = 1e-4\nrelative_tolerance = {}\n[contact]\nrestitution = 0.0\n";
  const auto body = [&](const char* method, const char* tolerance) {
    const Recording run = record(case_of(fmt::format(fmt::runtime(text), method, tolerance)));
    const auto u = run.displacement(run.times.size() - 1);
    return u[u.size() - 2];
  };
  const double of_scheme = body("fully_discrete", "1e-6");
  for (const char* tolerance : {"1e-5", "1e-6", "1e-8"})
    EXPECT_NEAR(body("rigid", tolerance), of_scheme, 1e-5) << tolerance;
}

// More bodies are bonded than there are elements.
TEST(ChainAccounts, BondedBodiesAreOne) {
  const std::string body = "[[bar]]\nmass = 1.0\nvelocity = 1.0\n", bond = "[[joint]]\nkind = \"bonded\"\n",
                    bar = "[[bar]]\nlength = 1.0\nelements = 1\nviscosity = 0.05\nvelocity = 0.0\n",
                    contact = "[[joint]]\nkind = \"contact\"\ngap = 0.1\n",
                    rest = "[time]\nend = 1.0\n[mesh]\nmass = \"lumped\"\n[method]\nname = \"rigid\"\n";
  for (const char* method : {"rigid", "cvode", "fully_discrete"}) {
    const Recording three = record(case_of(body + body + body + bar + bond + bond + contact + rest,
                                           {std::string("method.name=") + method, "contact.epsilon=1e-4"}));
    const Recording one = record(case_of("[[bar]]\nmass = 3.0\nvelocity = 1.0\n" + bar + contact + rest,
                                         {std::string("method.name=") + method, "contact.epsilon=1e-4"}));
    ASSERT_EQ(three.u.size(), one.u.size());
    for (std::size_t i = 0; i < one.u.size(); ++i) ASSERT_NEAR(three.u[i], one.u[i], 1e-9) << method;
  }
}

TEST(ChainAccounts, AnEstimateHalvesBarsOfFewElements) {
  const Case run = case_of(
      "[[bar]]\nlength = 1.0\nviscosity = 0.1\nelements = 9\nvelocity = 1.0\n[[bar]]\nlength = 1.0\nviscosity = 0.1\n"
      "elements = 15\nvelocity = 0.0\n[[joint]]\nkind = \"contact\"\n[time]\nend = 3.0\n");
  const accuracy::QuickEstimate found = accuracy::quick_estimate(run, std::nullopt, 30.0, {});
  ASSERT_TRUE(found.estimate) << found.why_not;
  EXPECT_GT(found.estimate->total, 0.0);
}

// The pull at an opening drives the two nodes apart and is not what pushes both: the joint opens where the force
// between the bars is zero, seen from either side.
TEST(ChainAccounts, AJointOfTwoPushedBarsOpensOnTime) {
  for (const bool mirrored : {false, true}) {
    const char* const forces[] = {"1.0", "0.5*t", "-0.5*t", "-1.0"};
    const Recording run = record(case_of(fmt::format(
        "[[bar]]\nlength = 1.0\nviscosity = 0.2\nelements = 4\n[[bar]]\nlength = 1.0\nviscosity = 0.2\nelements = "
        "4\n[[joint]]\nkind = \"contact\"\ngap = 0.01\n[left]\nkind = \"free\"\nforce = \"{}\"\n[right]\nkind = "
        "\"free\"\nforce = \"{}\"\n[time]\nend = 4.0\n[mesh]\nmass = \"consistent\"\n[contact]\nrestitution = 0.0\n"
        "epsilon = 1e-7\n[method]\nname = \"cvode\"\nrelative_tolerance = 1e-8\n",
        forces[2 * mirrored], forces[2 * mirrored + 1])));
    ASSERT_EQ(run.events.size(), 2u);
    EXPECT_LT(run.statistics.late_opening.ratio, 1.0) << mirrored;
  }
}

// Bars that touch and move as one, but for the rounding of their velocities: only forces close their contacts, from
// either side alike.
TEST(ChainAccounts, TheRoundingOfVelocitiesIsNoImpact) {
  const std::string bars[] = {"[[bar]]\nlength = 1.0\ndensity = 0.5\nmodulus = 0.7\nviscosity = 0.01\nelements = 16\n",
                              "[[bar]]\nlength = 0.5\ndensity = 2.0\nmodulus = 3.0\nviscosity = 1.0\nelements = 9\n",
                              "[[bar]]\nlength = 0.5\ndensity = 0.5\nmodulus = 0.7\nviscosity = 0.01\nelements = 9\n"};
  for (const char* method : {"rigid", "cvode", "exponential", "fully_discrete"}) {
    std::vector<std::string> places[2];
    for (const bool mirrored : {false, true}) {
      const Recording run = record(case_of(fmt::format(
          "{}{}{}[[joint]]\nkind = \"contact\"\n[[joint]]\nkind = \"contact\"\n[{}]\nkind = \"free\"\nforce = {}\n"
          "stiffness = 2.0\n[initial]\nvelocity = {}\n[load]\ndensity = \"{}\"\n[time]\nend = 2.0\n[contact]\n"
          "restitution = 0.0\nepsilon = 1e-4\n[method]\nname = \"{}\"\nrelative_tolerance = 1e-9\nstep = 2e-3\n",
          bars[mirrored ? 2 : 0], bars[1], bars[mirrored ? 0 : 2], mirrored ? "left" : "right", mirrored ? -0.3 : 0.3,
          mirrored ? -0.4 : 0.4, mirrored ? "-sin(t)*(2-x)" : "sin(t)*x", method)));
      for (const Event& event : run.events) {
        places[mirrored].push_back(
            fmt::format("{} {}", mirrored ? 3 - event.node : event.node, event.change == Change::closing));
        EXPECT_TRUE(event.time > 0.0 || std::string_view(method) != "fully_discrete") << event.velocity;
      }
    }
    EXPECT_EQ(places[0], places[1]) << method;
  }
}

}  // namespace
}  // namespace viscobar::chain_accounts
