// Where the energy is at each output time: the columns of energy.csv.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "results/csv.hpp"
#include "support/scratch.hpp"
#include "viscobar/case/case.hpp"
#include "viscobar/record/record_run.hpp"

namespace viscobar {
namespace {

/// A loaded bar that falls between two obstacles; every method but `characteristics` takes it with viscosity.
Case bouncing(MethodName method, double viscosity) {
  Case run;
  run.scene.bar.viscosity = viscosity;
  run.scene.left = Obstacle{.gap = 0.1};
  run.scene.right = Obstacle{.gap = 0.2, .side = Side::above};
  run.scene.displacement = [](double x) { return 0.05 * x * (1.0 - x); };
  run.scene.velocity = [](double x) { return -0.7 - 0.2 * x; };
  run.scene.load =
      SeparableLoad{[](double x) { return std::cos(2.0 * x); }, [](double t) { return std::sin(3.0 * t); }};
  run.elements = 20;
  run.method = method;
  run.epsilon = 1e-3;
  run.tolerance.relative = 1e-8;
  run.step = 1e-3;
  run.end = 2.5;
  run.output_every = 0.0173;  // no multiple of a step
  return run;
}

struct Told {
  std::vector<double> times;
  std::vector<EnergyState> states;
  Statistics done;
};

Told told(const Case& run) {
  Told all;
  Observers observers;
  observers.energy = observers.account = true;
  observers.snapshot = [&](const Snapshot& now) {
    all.times.push_back(now.time);
    all.states.push_back(now.energy.value());
  };
  all.done = simulate(resolve(run), observers);
  return all;
}

double scale(const Told& run) {
  double largest = 0.0;
  for (const EnergyState& now : run.states) largest = std::max({largest, now.total(), std::abs(now.work)});
  return largest;
}

/// Largest error of the balance at output times, relative to the largest energy.
double largest_imbalance(const Told& run) {
  double largest = 0.0;
  for (const EnergyState& now : run.states)
    largest = std::max(largest, std::abs(now.total() + now.dissipated - now.work - run.done.energy->initial));
  return largest / scale(run);
}

// An error of 100 times the tolerance, relative to the largest u and v, is one of twice that of an energy.
constexpr double of_tolerance = 2.0 * 100.0 * 1e-8;

void expect_balance(const Case& run, double tolerance) {
  SCOPED_TRACE(name(run.method));
  const Told all = told(run);
  ASSERT_EQ(all.times, run.output_times());
  ASSERT_GT(all.done.events, 0u);
  EXPECT_LE(largest_imbalance(all), tolerance);
  // The last row is what the summary says.
  const EnergyState& last = all.states.back();
  const double rounding = 8.0 * std::numeric_limits<double>::epsilon() * scale(all);
  EXPECT_NEAR(last.total(), all.done.energy->final, rounding);
  EXPECT_NEAR(last.dissipated, all.done.energy->dissipated, rounding);
  EXPECT_NEAR(last.work, all.done.energy->work, rounding);
  EXPECT_NEAR(last.end_inertia, all.done.energy->end_inertia, rounding);
}

TEST(EnergyColumns, BalanceAtEveryOutputTimeByAdaptiveMethods) {
  for (const MethodName method : {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint})
    for (const Mass mass : {Mass::consistent, Mass::fourth_order}) {
      Case run = bouncing(method, 0.05);
      run.mass = mass;
      expect_balance(run, of_tolerance);
    }
}

TEST(EnergyColumns, BalanceWithImpactsOfRigidContacts) {
  for (const double restitution : {0.0, 0.6}) {
    Case run = bouncing(MethodName::rigid, 0.05);
    run.epsilon.reset();
    run.mass = Mass::fourth_order;
    run.restitution = restitution;
    expect_balance(run, of_tolerance);
  }
}

// To rounding: some hundred steps, each of some matrix products of sixty unknowns.
TEST(EnergyColumns, BalanceToRoundingByMatrixExponentials) {
  for (const Mass mass : {Mass::consistent, Mass::redistributed, Mass::fourth_order}) {
    Case run = bouncing(MethodName::exponential, 0.05);
    run.mass = mass;
    expect_balance(run, 1e5 * std::numeric_limits<double>::epsilon());
  }
}

// The exact motion: work and energy are integrals of polynomials, but for cos and sin, which pieces follow to rounding.
TEST(EnergyColumns, BalanceToRoundingByCharacteristics) {
  Case run = bouncing(MethodName::characteristics, 0.0);
  run.epsilon.reset();
  expect_balance(run, 1e4 * std::numeric_limits<double>::epsilon());
  run.scene.load = SteadyLoad{[](double x) { return -1.0 - x; }};
  expect_balance(run, 1e4 * std::numeric_limits<double>::epsilon());
  run.scene.load.reset();
  expect_balance(run, 1e4 * std::numeric_limits<double>::epsilon());
}

// Its balance is an identity of each step, so roundings of 2500 of them are all there is.
TEST(EnergyColumns, OfASchemeBalanceToRounding) {
  for (const Mass mass : {Mass::consistent, Mass::fourth_order}) {
    Case run = bouncing(MethodName::fully_discrete, 0.05);
    run.mass = mass;
    expect_balance(run, 2500.0 * 16.0 * std::numeric_limits<double>::epsilon());
  }
}

// dissipated(t) = int_0^t eta int v_x^2, by Simpson's rule on the output times, whose error is a sixteenth of the
// change when every other one is left out.
TEST(EnergyColumns, DissipatedIsTheIntegralOfTheViscousPower) {
  Case run = bouncing(MethodName::cvode, 0.05);
  run.mass = Mass::consistent;
  run.scene.load.reset();
  run.scene.left = run.scene.right = Free{};
  run.output_every = run.end / 400.0;
  const BarSystem system = resolve(run).system();
  std::vector<double> power, dissipated;
  Observers observers;
  observers.energy = true;
  observers.snapshot = [&](const Snapshot& now) {
    power.push_back(run.scene.bar.viscosity * system.elements().squared_strain_rate(now.v));
    dissipated.push_back(now.energy->dissipated);
  };
  simulate(resolve(run), system, observers);
  ASSERT_EQ(power.size(), 401u);
  // Not over the start, where the initial data do not satisfy the conditions at the ends.
  constexpr std::size_t first = 40;
  const auto simpson = [&](std::size_t until, std::size_t stride) {
    double sum = 0.0;
    for (std::size_t k = first; k + 2 * stride <= until; k += 2 * stride)
      sum += static_cast<double>(stride) * run.output_every / 3.0 *
             (power[k] + 4.0 * power[k + stride] + power[k + 2 * stride]);
    return sum;
  };
  for (const std::size_t until : {120u, 240u, 400u}) {
    const double fine = simpson(until, 1), coarse = simpson(until, 2);
    EXPECT_NEAR(dissipated[until] - dissipated[first], fine,
                std::abs(fine - coarse) / 8.0 + of_tolerance * dissipated.back())
        << until;
  }
  EXPECT_GT(dissipated.back(), 1e-4);
}

SceneFile recorded_scene(const std::string& output = "") {
  return parse_scene(
      "[bar]\nlength = 1.0\nviscosity = 0.05\n[left]\nkind = 'obstacle'\ngap = 0.1\n[initial]\nvelocity = -1.0\n"
      "[time]\nend = 1.0\n[mesh]\nelements = 10\n[method]\nname = 'rigid'\n[output]\nevery = 0.05\n" +
          output,
      "scene");
}

TEST(EnergyColumns, AreAFileWithARowForEachOutputTime) {
  const Scratch scratch;
  record_run(recorded_scene(), scratch / "out");
  const std::vector<std::string> energy = read_lines(scratch / "out/energy.csv"),
                                 ends = read_lines(scratch / "out/ends.csv");
  ASSERT_EQ(energy.size(), 22u);
  EXPECT_EQ(energy[0], "t,kinetic,elastic,contact,dissipated,work,total");
  for (std::size_t row = 1; row < energy.size(); ++row)
    EXPECT_EQ(energy[row].substr(0, energy[row].find(',')), ends[row].substr(0, ends[row].find(',')));
}

TEST(OutputWrite, ChoosesTheFilesOfARun) {
  const Scratch scratch;
  const auto files_in = [&](const std::filesystem::path& directory) {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(directory)) names.insert(entry.path().filename());
    names.erase(".viscobar.lock");
    return names;
  };
  using Names = std::set<std::string>;
  record_run(recorded_scene("write = ['ends', 'energy']"), scratch / "some");
  EXPECT_EQ(files_in(scratch / "some"), (Names{"summary.json", "ends.csv", "energy.csv"}));
  record_run(recorded_scene("write = []"), scratch / "none");
  EXPECT_EQ(files_in(scratch / "none"), Names{"summary.json"});
  record_run(recorded_scene("write = ['field', 'report', 'events']"), scratch / "some");
  EXPECT_EQ(files_in(scratch / "some"), (Names{"summary.json", "events.csv", "field.h5", "field.xdmf", "report.html"}))
      << "files of the result before have gone";
}

// The scene of the README: what the bar has lost. On fine meshes 0.1727; here to O(h^2), by which energies of P1
// elements differ from those of the bar, and that falls by four where the elements are halved. What viscosity took
// alone would be 4 % less.
TEST(EnergyColumns, TellAsDissipatedWhatTheBarHasLost) {
  const auto lost = [](std::size_t elements) {
    Case run;
    run.scene.bar.viscosity = 0.01;
    run.scene.left = run.scene.right = Obstacle{.gap = 0.1};
    run.scene.displacement = [](double x) { return x * (1.0 - x); };
    run.scene.velocity = [](double x) { return -x * (1.0 - x); };
    run.elements = elements;
    run.method = MethodName::rigid;
    run.mass = Mass::fourth_order;
    run.end = 6.0;
    const Told all = told(run);
    const EnergyAccount& energy = *all.done.energy;
    EXPECT_EQ(energy.dissipated, all.states.back().dissipated);
    EXPECT_NEAR(energy.dissipated, energy.initial - energy.final, 1e-5);
    return energy.dissipated;
  };
  const double coarse = lost(27), fine = lost(54), finer = lost(108);
  EXPECT_NEAR(fine + (fine - coarse) / 3.0, finer + (finer - fine) / 3.0, 5e-5);
  EXPECT_NEAR(finer, 0.1727, 0.5e-4 + std::abs(finer - fine) / 3.0);
  EXPECT_NEAR(coarse, 0.1727, 0.5e-4 + 4.0 / 3.0 * std::abs(fine - coarse));
}

}  // namespace
}  // namespace viscobar
