// Where a force, a motion or a contact jumps, the high modes of the mass fourth_order stay at rest: velocities of ends
// then converge like displacements. Errors are those that a code of its own has, which is exact in time (dense modal
// solutions in NumPy, all modes from h^2 omega^2 rho / E = 1 on put at their equilibrium); a quarter is for what the
// tolerance of 1e-9 and other times of output add.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar::testing_jumps {
namespace {

constexpr double pi = std::numbers::pi, more = 1.25;
constexpr const char* adaptive[] = {"cvode", "ida", "arkode", "rigid", "odeint"};

Case scene(const std::string& what, int elements, const std::string& method) {
  return parse_scene(fmt::format("[bar]\nlength = 1.0\n{}[mesh]\nelements = {}\nmass = \"fourth_order\"\n[method]\n"
                                 "name = \"{}\"\nrelative_tolerance = 1e-9\n",
                                 what, elements, method),
                     "")
      .run;
}

struct Errors {
  double v = 0.0, u = 0.0;
};

using Exact = std::function<double(double t)>;

// Largest errors of an end, from `begin` on.
Errors errors(const Recording& run, bool right, double begin, const Exact& v, const Exact& u) {
  Errors most;
  for (std::size_t k = 0; k < run.times.size(); ++k) {
    if (run.times[k] < begin - 1e-9) continue;
    const std::size_t node = right ? run.mesh.nodes() - 1 : 0;
    most.v = std::max(most.v, std::abs(run.velocity(k)[node] - v(run.times[k])));
    most.u = std::max(most.u, std::abs(run.displacement(k)[node] - u(run.times[k])));
  }
  return most;
}

constexpr const char* push =
    "[right]\nkind = \"free\"\nforce = 1.0\n{}[left]\nkind = \"free\"\n[time]\nend = 1.8\n[output]\nevery = 0.01\n";

// A load that begins all along the bar moves it as a whole, by a t^2 / 2. What is left of G at mu = 0 would move it at
// once: by 9.8e-6 on 8 elements. The bound is that of the tolerance, 100 x 1e-9 of u = 5.
TEST(Jump, OfALoadAllAlongTheBarMovesItByItsImpulseAlone) {
  const char* const load =
      "[load]\nprofile = 1.0\nhistory = \"t < 0.5 ? 0 : 1000\"\n[time]\nend = 0.6\n[output]\nevery = 0.1\n";
  for (const char* method : adaptive) {
    const Recording run = record(scene(load, 8, method));
    for (const double u : run.displacement(run.times.size() - 1)) EXPECT_NEAR(u, 5.0, 5e-7) << method;
  }
}

// Without it v is off by 0.82 and u by 2.9e-3, whatever the mesh.
TEST(Jump, OfAForceLeavesTheVelocityOfItsEndRightByEveryMethod) {
  for (const char* method : adaptive) {
    const Errors e = errors(
        record(scene(fmt::format(fmt::runtime(push), ""), 100, method)), true, 0.2, [](double) { return 1.0; },
        [](double t) { return t; });
    EXPECT_LT(e.v, more * 5.0e-5) << method;
    EXPECT_LT(e.u, more * 2.3e-7) << method;  // by 100 and 200 terms of G, too
  }
  const Errors e = errors(
      record(scene(fmt::format(fmt::runtime(push), ""), 50, "exponential")), true, 0.2, [](double) { return 1.0; },
      [](double t) { return t; });
  EXPECT_LT(e.v, more * 1.2e-3);
  EXPECT_LT(e.u, more * 1.2e-5);
}

// The scheme's own error is half a step's of u.
TEST(Jump, OfAForceWithinARunIsThatOfTheStart) {
  const char* late =
      "[right]\nkind = \"free\"\nforce = \"t < 0.5 ? 0 : 1\"\n[left]\nkind = \"free\"\n[time]\nend = "
      "2.3\n[output]\nevery = 0.01\n";
  for (const char* method : {"cvode", "rigid", "exponential", "fully_discrete"}) {
    const Recording run = record(scene(late, 50, method));
    const Errors e = errors(
        run, true, 0.7, [](double) { return 1.0; }, [](double t) { return t - 0.5; });
    EXPECT_LT(e.v, more * 1.2e-3) << method;
    EXPECT_LT(e.u, more * 1.2e-5 + (method == std::string("fully_discrete") ? 0.02 / 50 / 2 : 0.0)) << method;
  }
}

// Without it v is off by 0.74 on 100 elements. 5e-6 is what viscosity does of itself, eta t / 2.
TEST(Jump, OfTheTractionOfTheDataAtAFreeEndLeavesItsVelocityRight) {
  const char* let_go =
      "viscosity = 1e-5\n[left]\nkind = \"free\"\n[right]\nkind = \"free\"\n[initial]\ndisplacement = "
      "\"-(x-x^2/2)\"\n[load]\ndensity = -1.0\n[time]\nend = 0.9\n[output]\nevery = 0.01\n";
  for (const char* method : {"rigid", "cvode", "fully_discrete"}) {
    const Errors e = errors(
        record(scene(let_go, 100, method)), false, 0.2, [](double) { return -1.0; }, [](double t) { return -t; });
    EXPECT_LT(e.v, more * 5.0e-5) << method;
  }
}

// u_1' at a free end costs two orders in u without it: 5.9e-3 and 2.9e-3 of v on 50 and 100 elements.
TEST(Jump, OfTheRateOfTractionCostsNoOrder) {
  const char* tilted =
      "[left]\nkind = \"free\"\n[right]\nkind = \"free\"\n[initial]\nvelocity = \"-0.5-x\"\n[time]\nend = "
      "0.95\n[output]\nevery = 0.01\n";
  const std::pair<int, Errors> rows[] = {{50, {4.0e-4, 2.5e-6}}, {100, {1.6e-5, 1.9e-7}}};
  for (const auto& [elements, table] : rows) {
    const Errors e = errors(
        record(scene(tilted, elements, "rigid")), false, 0.2, [](double t) { return -0.5 - t; },
        [](double t) { return -0.5 * t - t * t / 2.0; });
    EXPECT_LT(e.v, more * table.v);
    EXPECT_LT(e.u, more * table.u);
  }
}

// Stiffness and dashpot of the end: u' = exp(-k t / (1 + d)) / (1 + d). A dashpot of half the impedance and more damps
// the mode itself.
TEST(Jump, OfAForceOnASpringOrADashpotLeavesItsVelocityRight) {
  struct Row {
    double k, d;
    Errors table;
  };
  for (const auto& [k, d, table] : {Row{10.0, 0.0, {6.1e-5, 3.3e-7}}, Row{100.0, 0.0, {2.0e-5, 8.3e-8 + 1e-7}},
                                    Row{0.0, 0.1, {3.6e-3, 1.1e-5}}, Row{0.0, 1.0, {2.6e-3, 1.1e-5}}}) {
    const std::string support = fmt::format("stiffness = {}\ndashpot = {}\n", k, d);
    const double rate = k / (1.0 + d);
    const Errors e = errors(
        record(scene(fmt::format(fmt::runtime(push), support), 100, "rigid")), true, 0.2,
        [=, d = d](double t) { return std::exp(-rate * t) / (1.0 + d); },
        [=, k = k, d = d](double t) { return k > 0.0 ? (1.0 - std::exp(-rate * t)) / k : t / (1.0 + d); });
    EXPECT_LT(e.v, more * table.v) << k << " " << d;
    EXPECT_LT(e.u, more * table.u) << k << " " << d;
  }
}

// 1/2 (theta = 0) from eta / h = 0.7 on: then order 4 is that of the mass.
TEST(Jump, IsLeftToViscosityThatDampsHighModes) {
  std::vector<double> v;
  for (const int elements : {50, 100, 200, 400}) {
    const Recording run = record(scene("viscosity = 0.1\n" + fmt::format(fmt::runtime(push), ""), elements, "rigid"));
    v.push_back(run.velocity(run.times.size() - 1)[run.mesh.nodes() - 1]);
  }
  // Differences fall by 16 with each mesh.
  EXPECT_GT(std::log2(std::abs((v[0] - v[1]) / (v[1] - v[2]))), 3.7);
  EXPECT_GT(std::log2(std::abs((v[1] - v[2]) / (v[2] - v[3]))), 3.7);
}

// The shift of a unit force stores 0.133599 h, and the force does 0.362681 h of work: what is lost is told.
TEST(Jump, HasItsEnergyInTheAccount) {
  const Recording run = record(scene(fmt::format(fmt::runtime(push), ""), 100, "rigid"));
  const EnergyAccount& energy = *run.statistics.energy;
  EXPECT_NEAR(energy.end_inertia, 0.229082 / 100, 2e-4);  // the rest is that of the end rows
  EXPECT_LT(std::abs(energy.balance_error()), 1e-8);
}

// Smooth data that fit the ends ask for nothing: both runs are the same digit by digit.
TEST(Jump, OfNothingLeavesEveryDigit) {
  const char* fits =
      "[left]\nkind = \"free\"\n[right]\nkind = \"free\"\n[initial]\ndisplacement = \"cos(3*pi*x)\"\nvelocity = "
      "\"cos(2*pi*x)\"\n[time]\nend = 0.95\n[output]\nevery = 0.05\n";
  const Errors e = errors(
      record(scene(fits, 100, "rigid")), false, 0.2,
      [](double t) { return -3 * pi * std::sin(3 * pi * t) + std::cos(2 * pi * t); },
      [](double t) { return std::cos(3 * pi * t) + std::sin(2 * pi * t) / (2 * pi); });
  EXPECT_LT(e.v, more * 1.1e-5);
  EXPECT_LT(e.u, more * 1.1e-6);
}

// A run that goes on from a checkpoint where the force jumps is the run that was not stopped.
TEST(Jump, IsPassedOnceByARunThatIsResumedThere) {
  for (const char* method : {"rigid", "cvode", "exponential", "fully_discrete"}) {
    const Case run = scene(
        "[right]\nkind = \"free\"\nforce = \"t < 0.5 ? 0 : 1\"\n[left]\nkind = \"free\"\n[time]\nend = "
        "1.0\n[output]\nevery = 0.25\n",
        20, method);
    const BarSystem system = resolve(run).system();
    std::optional<Checkpoint> half;
    Checkpoints checkpoints;
    checkpoints.every = 0.5;
    checkpoints.take = [&](const Checkpoint& one) {
      half = one;
      return RunControl::go_on;
    };
    std::vector<double> ends[2];
    for (auto& end : ends) {
      Observers observers;
      observers.checkpoints = checkpoints;
      observers.snapshot = [&](const Snapshot& now) { end.push_back(now.u.back()); };
      if (&end == &ends[0])
        simulate(resolve(run), system, observers);
      else
        simulate(resolve(run), system, *half, observers);
    }
    ASSERT_FALSE(ends[1].empty()) << method;
    EXPECT_EQ(ends[0].back(), ends[1].back()) << method;
  }
}

// Central differences of runs over 1e-4: their error is the square of that, times how often a derivative is taken of
// what returns within 0.1, and 1e-11 over it. The bar is stopped, pushed, and opens.
TEST(Jump, PassesDerivatives) {
  const std::string text =
      "[bar]\nlength = 1.0\nviscosity = 1e-3\n[left]\nkind = \"obstacle\"\ngap = 0.0\n[right]\nkind = \"free\"\nforce = "
      "\"t < 0.3 ? 0 : push\"\n[initial]\ndisplacement = \"tilt*x\"\nvelocity = \"-1-tilt*x\"\n[parameters]\npush = "
      "0.5\ntilt = 0.1\n[sensitivity]\nof = [\"parameters.push\", \"parameters.tilt\", \"bar.modulus\", \"bar.density\", "
      "\"bar.viscosity\", \"bar.length\"]\n[time]\nend = 2.5\n[mesh]\nelements = 40\nmass = "
      "\"fourth_order\"\n[method]\nname = \"rigid\"\nrelative_tolerance = 1e-11\n[output]\nevery = 0.25\n";
  const Recording with = record(parse_scene(text, "").run);
  ASSERT_EQ(with.events.size(), 2u);
  const double values[] = {0.5, 0.1, 1.0, 1.0, 1e-3, 1.0};
  for (std::size_t k = 0; k < 6; ++k) {
    const double step = 1e-4 * values[k];
    const auto moved = [&](double by) {
      const std::vector<std::string> changes = {fmt::format("{}={:.17g}", with.sensitivities[k].key, values[k] + by),
                                                "sensitivity.of="};
      return record(parse_scene(text, "", changes).run);
    };
    const Recording above = moved(step), below = moved(-step);
    double largest = 0.0, worst = 0.0;
    for (std::size_t i = 0; i < with.v.size(); ++i) {
      const double slope = (above.v[i] - below.v[i]) / (2.0 * step);
      largest = std::max(largest, std::abs(slope));
      worst = std::max(worst, std::abs(with.sensitivities[k].v[i] - slope));
    }
    EXPECT_LT(worst, 1e-4 * largest) << with.sensitivities[k].key;
  }
}

}  // namespace
}  // namespace viscobar::testing_jumps
