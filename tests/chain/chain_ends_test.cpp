// Ends and obstacles of bars in line that move: two halves are one bar, and a heavy body that a force moves is a wall.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/maximum_norm.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar::chain_ends {
namespace {

using Settings = std::vector<std::string>;

Recording run_of(const std::string& text, const Settings& settings = {}) {
  return record(parse_scene(text, "", settings).run);
}

// Each kind of motion, with and without a kink, and what else an end may have.
const std::string moved_ends[] = {
    "[left]\nkind = \"fixed\"\nmotion = \"0.1*sin(3*t)\"\n[right]\nkind = \"obstacle\"\ngap = \"0.03+a*sin(5*t)\"\n",
    "[left]\nkind = \"obstacle\"\nside = \"above\"\ngap = \"0.2-0.3*max(0,t-0.3)\"\n[right]\nkind = \"free\"\nstiffness = "
    "2.0\nmass = 0.3\nforce = \"0.2*sin(2*t)\"\n",
    "[left]\nkind = \"fixed\"\nmotion = \"0.3*t+a*t^2\"\n[right]\nkind = \"fixed\"\nmotion = \"0.3*t+0.1*max(0,t-0.5)\"\n",
    "[left]\nkind = \"obstacle\"\ngap = \"0.05+a*sin(4*t)\"\n[right]\nkind = \"obstacle\"\ngap = \"0.06+0.2*t\"\nside = "
    "\"above\"\ndashpot = 0.2\n"};

std::string moved(const std::string& ends, double viscosity, bool in_parts, const std::string& method) {
  const std::string of_bar = fmt::format("viscosity = {}\ndensity = 1.2\nmodulus = 1.5\n", viscosity);
  const std::string bars =
      in_parts ? fmt::format(
                     "[[bar]]\nlength = 0.5\nelements = 6\n{0}[[bar]]\nlength = 0.25\nelements = 3\n{0}[[bar]]\n"
                     "length = 0.25\nelements = 3\n{0}",
                     of_bar)
               : "[bar]\nlength = 1.0\n" + of_bar;
  return fmt::format(
      "{}{}[parameters]\na = 0.04\n[initial]\nvelocity = 0.3\ndisplacement = \"0.01*sin(3*x)\"\n[time]\nend = 2.0\n[output]\n"
      "every = 0.1\n[contact]\nepsilon = 1e-3\n[mesh]\n{}mass = \"{}\"\n[method]\nname = \"{}\"\nrelative_tolerance = "
      "1e-9\nstep = 1e-3\n",
      bars, ends, in_parts ? "" : "elements = 12\n", viscosity > 0.05 ? "consistent" : "lumped", method);
}

// Where rows are sums of elements, the chain's are those of the bar: what is left is rounding, which an adaptive method
// may answer with another step.
TEST(MovedChains, PartsOfABarMoveAsThatDoes) {
  for (const std::string& ends : moved_ends)
    for (const double viscosity : {0.1, 0.02, 0.0})
      for (const char* method :
           {"cvode", "ida", "arkode", "odeint", "rigid", "exponential", "fully_discrete", "characteristics"}) {
        const std::string_view name = method;
        if ((name == "characteristics") != (viscosity == 0.0)) continue;
        if (name == "characteristics" && ends.find("mass") != ends.npos && ends.find("gap") == ends.npos) continue;
        const Recording chain = run_of(moved(ends, viscosity, true, method));
        const Recording one = run_of(moved(ends, viscosity, false, method));
        const std::string what = fmt::format("{} {}\n{}", method, viscosity, ends);
        ASSERT_EQ(chain.events.size(), one.events.size()) << what;
        const double allowed = name == "fully_discrete" || name == "characteristics" ? 1e-10 : 1e-7;
        EXPECT_LT(distance(chain.u, one.u), allowed) << what;
        EXPECT_LT(distance(chain.v, one.v), 100 * allowed) << what;
        for (std::size_t k = 0; k < one.events.size(); ++k) {
          EXPECT_NEAR(chain.events[k].time, one.events[k].time, 100 * allowed) << what;
          EXPECT_NEAR(chain.events[k].velocity, one.events[k].velocity, 1000 * allowed) << what;
        }
        const EnergyAccount &of_chain = *chain.statistics.energy, &of_one = *one.statistics.energy;
        EXPECT_NEAR(of_chain.work, of_one.work, 100 * allowed) << what;
        EXPECT_NEAR(of_chain.dissipated, of_one.dissipated, 100 * allowed) << what;
        EXPECT_NEAR(of_chain.balance_error(), of_one.balance_error(), 100 * allowed) << what;
        EXPECT_NEAR(chain.statistics.account->left.impulse, one.statistics.account->left.impulse, 100 * allowed)
            << what;
        EXPECT_NEAR(chain.statistics.account->right.impulse, one.statistics.account->right.impulse, 100 * allowed)
            << what;
      }
}

// Unlike bars, of which no strain is in proportion to another's, a spring, and a contact that closes.
std::string unlike(const std::string& first, const std::string& left, const std::string& method, bool elastic = false) {
  const auto eta = [elastic](double viscosity) { return elastic ? 0.0 : viscosity; };
  return fmt::format(
      "{}[[bar]]\nlength = 1.0\nviscosity = {}\nelements = 10\nvelocity = 0.0\n[[bar]]\nlength = 0.7\nmodulus = 3.0\nviscosity = "
      "{}\nelements = 8\nvelocity = 0.0\n[[bar]]\nlength = 0.5\ndensity = 2.0\nviscosity = {}\nelements = 5\nvelocity = "
      "0.0\n{}[right]\nkind = \"fixed\"\nmotion = \"-0.05*t^2\"\n[time]\nend = 3.0\n[output]\nevery = 0.1\n[contact]\nepsilon = "
      "1e-2\nrestitution = 0\n[mesh]\nmass = \"consistent\"\n[method]\nname = \"{}\"\nrelative_tolerance = 1e-10\nstep = 1e-3\n",
      first, eta(0.1), eta(0.15), eta(0.4), left, method);
}

const std::string joints_behind =
    "[[joint]]\nkind = \"contact\"\ngap = 0.02\n[[joint]]\nkind = \"spring\"\nstiffness = 4.0\n";

// A wall that moves by d is a body of mass m under the force m d'': its own motion is wrong by impulses of the bar over
// m, some t / m = 3e-6 of it at m = 1e6. Its frame stands still. The same of an obstacle.
TEST(MovedChains, AWallThatMovesIsAHeavyBodyUnderAForce) {
  const std::string body = "[[bar]]\nmass = 1e6\nvelocity = 0.0\n";
  const std::string pushed = "[left]\nkind = \"free\"\nforce = \"0.6e6*cos(4*t)\"\n";  // of 0.075 sin^2 2t
  for (const char* method : {"rigid", "cvode", "ida", "arkode", "odeint", "exponential"}) {
    const Recording wall =
        run_of(unlike("", "[left]\nkind = \"fixed\"\nmotion = \"0.075*sin(2*t)^2\"\n" + joints_behind, method));
    const Recording heavy = run_of(unlike(body, pushed + "[[joint]]\nkind = \"bonded\"\n" + joints_behind, method));
    ASSERT_GE(wall.events.size(), 1U) << method;
    EXPECT_LT(distance(wall.u, heavy.u), 1e-5) << method;
    EXPECT_NEAR(wall.events[0].time, heavy.events[0].time, 1e-5) << method;
    EXPECT_NEAR(wall.events[0].velocity, heavy.events[0].velocity, 1e-4) << method;
    EXPECT_NEAR(wall.statistics.account->joints.at(0).impulse, heavy.statistics.account->joints.at(1).impulse, 1e-4)
        << method;
    EXPECT_NEAR(wall.statistics.energy->dissipated, heavy.statistics.energy->dissipated, 1e-4) << method;
    EXPECT_NEAR(wall.statistics.energy->balance_error(), 0.0, 1e-7) << method;
  }
  for (const char* method : {"rigid", "cvode", "arkode"}) {
    const Recording wall =
        run_of(unlike("", "[left]\nkind = \"obstacle\"\ngap = \"0.02-0.075*sin(2*t)^2\"\n" + joints_behind, method));
    const Recording heavy =
        run_of(unlike(body, pushed + "[[joint]]\nkind = \"contact\"\ngap = 0.02\n" + joints_behind, method));
    ASSERT_EQ(wall.events.size(), heavy.events.size()) << method;
    for (std::size_t k = 0; k < wall.events.size(); ++k)
      EXPECT_NEAR(wall.events[k].time, heavy.events[k].time, 1e-4) << method;
    const std::size_t nodes = wall.mesh.nodes();
    for (std::size_t k = 0; k < wall.times.size(); ++k)
      EXPECT_LT(distance(wall.displacement(k), heavy.displacement(k).last(nodes)), 1e-5) << method << k;
    EXPECT_NEAR(wall.statistics.account->left.impulse, heavy.statistics.account->joints.at(0).impulse, 1e-4) << method;
    EXPECT_NEAR(wall.statistics.energy->balance_error(), 0.0, 1e-7) << method;
  }
}

// Many contacts are sampled one by one; the clearance of an obstacle that moves must be among what is sampled, also
// where nobody keeps an account of the ends.
TEST(MovedChains, AnObstacleThatMovesIsMetInTimeWhateverElseIsLookedAt) {
  std::string text =
      "[left]\nkind = \"obstacle\"\ngap = 0.0671\n[right]\nkind = \"obstacle\"\ngap = \"0.072+0.001*sin(3*t)\"\n"
      "[initial]\nvelocity = -0.6376\n[time]\nend = 0.5\n[contact]\nepsilon = 5.861e-3\n";
  for (const char* gap : {"0.0", "0.0328", "0.0"})
    text += fmt::format("[[joint]]\nkind = \"contact\"\ngap = {}\n", gap);
  for (const double modulus : {0.57, 2.72, 0.89, 1.86})
    text += fmt::format("[[bar]]\nlength = 0.75\nviscosity = 0.1\nelements = 8\nmodulus = {}\n", modulus);
  for (const char* method : {"ida", "cvode", "arkode", "odeint"}) {
    const Case run = parse_scene(text, "", Settings{fmt::format("method.name={}", method)}).run;
    const Recording kept = record(run);
    std::vector<Event> events;
    Observers alone;
    alone.event = [&](const Event& event) { events.push_back(event); };
    simulate(resolve(run), alone);
    ASSERT_EQ(events.size(), kept.events.size()) << method;
    for (std::size_t k = 0; k < events.size(); ++k) {
      EXPECT_EQ(events[k].where, kept.events[k].where) << method;
      EXPECT_NEAR(events[k].time, kept.events[k].time, 1e-5) << method;
    }
  }
}

// The scheme is of order one: its step times the largest stiffness of what it follows.
TEST(MovedChains, TheSchemeFollowsThem) {
  const std::string left = "[left]\nkind = \"fixed\"\nmotion = \"0.075*sin(2*t)^2\"\n" + joints_behind;
  const Recording scheme = run_of(unlike("", left, "fully_discrete")), rigid = run_of(unlike("", left, "rigid"));
  EXPECT_LT(distance(scheme.u, rigid.u), 4e-3);
  EXPECT_NEAR(scheme.statistics.energy->balance_error(), 0.0, 1e-9);
  EXPECT_NEAR(scheme.statistics.energy->work, rigid.statistics.energy->work, 1e-2);
}

// A bar that no wave has reached rests in its contact: all that pushes there is rounding of the wall's push, which is
// not small beside a bar that is still at rest.
TEST(MovedChains, TheSchemeHasNoContactBeforeTheWave) {
  for (const char* section : {"1", "1+0.5*x", "exp(-x)", "1+0.3*sin(5*x)"})
    for (const std::size_t elements : {37, 60, 100})
      for (const char* motion : {"0.05*sin(2*t)^2", "0.1*(1-cos(t))"}) {
        const std::string bar =
            fmt::format("[[bar]]\nlength = 1.0\nelements = {}\nsection = \"{}\"\n", elements, section);
        const Recording run = run_of(
            fmt::format("{0}{1}{0}{1}{0}[left]\nkind = \"fixed\"\nmotion = \"{2}\"\n[time]\nend = 0.5\n[mesh]\nmass = "
                        "\"fourth_order\"\n[method]\nname = \"fully_discrete\"\nstep = 2e-3\n[output]\nevery = 0.5\n",
                        bar, "[[joint]]\nkind = \"contact\"\n", motion));
        for (const Event& event : run.events) EXPECT_EQ(event.node, 1u) << section << elements << motion << event.time;
      }
}

// Without viscosity the exact waves; meshes come to them.
TEST(MovedChains, ElasticOnesAreWhatWavesAre) {
  for (const char* left : {"[left]\nkind = \"fixed\"\nmotion = \"0.075*sin(2*t)^2\"\n",
                           "[left]\nkind = \"obstacle\"\ngap = \"0.02-0.075*sin(2*t)^2\"\n"}) {
    const Settings fine = {"mesh.elements=460", "mesh.mass=fourth_order"};
    const Recording waves = run_of(unlike("", left + joints_behind, "characteristics", true), fine),
                    mesh = run_of(unlike("", left + joints_behind, "rigid", true), fine);
    EXPECT_LT(distance(waves.u, mesh.u), 2e-3) << left;
  }
}

// A wall pushes a body of mass m and the bar bonded to it, of impedance Z, by N = m V' + Z V, until a wave comes back.
TEST(MovedChains, AWallBeforeABodyOfAnElasticBarPushesBoth) {
  const double m = 0.4, z = 2.0;
  const Recording run = run_of(
      "[[bar]]\nmass = 0.4\nvelocity = 0.0\n[[bar]]\nlength = 1.0\ndensity = 2.0\nmodulus = 2.0\nvelocity = 0.0\n[left]\n"
      "kind = \"obstacle\"\ngap = \"-0.05*(1-cos(2*t))\"\n[time]\nend = 0.7\n[output]\nevery = 0.1\n[method]\nname = "
      "\"characteristics\"\n");
  const std::size_t nodes = run.mesh.nodes();
  for (std::size_t k = 1; k < run.times.size(); ++k) {
    const double t = run.times[k];
    EXPECT_NEAR(run.u[k * nodes], 0.05 * (1.0 - std::cos(2.0 * t)), 1e-15) << t;
    EXPECT_NEAR(run.reaction_left[k], m * 0.2 * std::cos(2.0 * t) + z * 0.1 * std::sin(2.0 * t), 1e-14) << t;
  }
  const double end = run.times.back(), v = 0.1 * std::sin(2.0 * end);
  EXPECT_NEAR(run.statistics.account->left.impulse, m * v + z * 0.05 * (1.0 - std::cos(2.0 * end)), 1e-14);
  EXPECT_NEAR(run.statistics.energy->work, 0.5 * m * v * v + z * 0.01 * (end / 2.0 - std::sin(4.0 * end) / 8.0), 1e-14);
  EXPECT_NEAR(run.statistics.energy->balance_error(), 0.0, 1e-14);
}

// Derivatives by what moves an end, and by the bars, are those of one bar.
TEST(MovedChains, HaveTheDerivativesOfTheBar) {
  for (const std::string& ends : {moved_ends[0], moved_ends[2]})
    for (const char* method : {"rigid", "cvode", "ida", "arkode"}) {
      const Settings settings = {"sensitivity.of=[\"parameters.a\"]"};
      const Recording chain = run_of(moved(ends, 0.1, true, method), settings),
                      one = run_of(moved(ends, 0.1, false, method), settings);
      const double a = 1e-4;
      const auto at = [&](double shift) {
        return run_of(moved(ends, 0.1, true, method),
                      {fmt::format("parameters.a={:.17g}", 0.04 + shift), "method.relative_tolerance=1e-12"});
      };
      const Recording before = at(-a), after = at(a);
      const auto& of_chain = chain.sensitivities.at(0);
      const auto& of_one = one.sensitivities.at(0);
      double largest = 0.0, apart = 0.0, off = 0.0;
      for (std::size_t i = 0; i < of_one.u.size(); ++i) {
        largest = std::max(largest, std::abs(of_one.u[i]));
        apart = std::max(apart, std::abs(of_chain.u[i] - of_one.u[i]));
        off = std::max(off, std::abs(of_chain.u[i] - (after.u[i] - before.u[i]) / (2.0 * a)));
      }
      EXPECT_GT(largest, 0.1) << method;
      EXPECT_LT(apart, 1e-6 * largest) << method << '\n' << ends;
      EXPECT_LT(off, 1e-4 * largest) << method << '\n' << ends;
    }
}

// By the numbers of unlike bars behind a wall that moves: differences of runs.
TEST(MovedChains, HaveTheDerivativesOfDifferences) {
  const std::string left = "[left]\nkind = \"fixed\"\nmotion = \"0.075*sin(2*t)^2\"\n" + joints_behind;
  const struct {
    const char* key;
    double value;
  } keys[] = {{"bar.1.density", 1.0},     {"bar.1.modulus", 1.0}, {"bar.3.viscosity", 0.4}, {"bar.3.density", 2.0},
              {"joint.2.stiffness", 4.0}, {"joint.1.gap", 0.02},  {"bar.2.length", 0.7}};
  for (const char* method : {"rigid", "cvode"})
    for (const auto& [key, value] : keys) {
      const double step = 1e-4 * value;
      const auto at = [&](double now) {
        return run_of(unlike("", left, method),
                      {fmt::format("{}={:.17g}", key, now), "bar.1.elements=10", "time.end=2"});
      };
      const Recording own =
          run_of(unlike("", left, method), {fmt::format("sensitivity.of=[\"{}\"]", key), "time.end=2"});
      const Recording before = at(value - step), after = at(value + step);
      ASSERT_EQ(before.u.size(), own.u.size());
      double largest = 0.0, off = 0.0;
      for (std::size_t i = 0; i < own.u.size(); ++i) {
        const double truth = (after.u[i] - before.u[i]) / (2.0 * step);
        largest = std::max(largest, std::abs(truth));
        off = std::max(off, std::abs(own.sensitivities.at(0).u[i] - truth));
      }
      EXPECT_LT(off, 1e-4 * largest + 1e-7) << method << ' ' << key << ' ' << largest;
    }
}

}  // namespace
}  // namespace viscobar::chain_ends
