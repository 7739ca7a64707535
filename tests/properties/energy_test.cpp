#include "properties/generator.hpp"
#include "properties/tolerance.hpp"
#include "viscobar/dynamics/penalty_law.hpp"

namespace viscobar::properties {
namespace {

// Energy of the k-th snapshot: the bar's, and that of the springs of a penalty.
double energy(const Case& run, const BarSystem& system, const Recording& recording, std::size_t k) {
  const auto part = [&](std::span<const double> nodal) {
    return nodal.subspan(system.unknowns().first_node(), system.size());
  };
  const auto u = part(recording.displacement(k)), v = part(recording.velocity(k));
  double sum = system.energy(u, v);
  if (!is_penalised(run.method)) return sum;
  for (const Contact& contact : system.contacts())
    sum += penalty_law({*run.epsilon, 1.0}, contact.weight, 0.0).energy(-(u[contact.unknown] + contact.gap));
  return sum;
}

// With |du| <= d and |dv| <= V d of a field, |dE| <= 2 sqrt(E N) + N, where N is the energy of the worst such field:
// alternating from node to node it strains every element by 2 d / h.
double energy_error(const Case& run, double energy, double d) {
  const Bar& bar = run.scene.bar;
  const double h = run.mesh().spacing(), dv = fastest_frequency(run) * d;
  const double springs = is_penalised(run.method) && run.epsilon ? 3.0 * d * d / (2.0 * *run.epsilon) : 0.0;
  const double n = (bar.density * dv * dv / 2.0 + bar.modulus * 2.0 * d * d / (h * h)) * bar.length + springs;
  return 2.0 * std::sqrt(std::max(energy, 0.0) * n) + n;
}

// Rounding of a scheme's account, which adds up the terms of each step.
double rounding(const Statistics& done) {
  const EnergyAccount& energy = *done.energy;
  return 1e-12 * static_cast<double>(done.steps) * (energy.initial + energy.final + std::abs(energy.work));
}

TEST(Energy, WithoutLoadNeverGrowsButByWhatASchemeSays) {
  expect_always([] {
    Asked asked;
    asked.loads = false;
    // The energy of the nodes is not that of the bar, where what lies between them is no straight line.
    std::erase(asked.methods, MethodName::characteristics);
    const RandomScene scene = *scenes(asked);
    const Case run = scene.read().run;
    if (run.mass == Mass::fourth_order) return;  // its symmetric part makes no energy that only falls
    const Recording recording = record(run);
    const EnergyAccount account = recording.statistics.energy.value();
    RC_CLASSIFY(!recording.events.empty(), "contact");
    if (is_scheme(run.method)) {
      // The law of (2.8) is one of its half steps: E^{n+1/2} - E^{n-1/2} <= 0 up to rounding, n steps of it. Only an
      // impact that rebounds may break it.
      const double allowed = rounding(recording.statistics) + (scene.restitution > 0.0 ? account.growth : 0.0);
      RC_ASSERT(account.final <= account.initial + allowed);
      RC_ASSERT(account.dissipated >= -allowed);
      return;
    }
    const BarSystem system = resolve(run).system();
    const double d = displacement_error(run, largest(recording.u));
    for (std::size_t k = 1; k < recording.times.size(); ++k) {
      const double before = energy(run, system, recording, k - 1), after = energy(run, system, recording, k);
      if (after > before + 2.0 * energy_error(run, std::max(before, after), d))
        RC_FAIL(fmt::format("E({}) = {}, E({}) = {}", recording.times[k - 1], before, recording.times[k], after));
    }
  });
}

// Steps from a 16th of an element to 16 elements: impacts of Paoli and Schatzman gain in one of ten scenes.
TEST(Energy, OfReboundsGrowsByWhatASchemeSaysAndNeverByMoreausImpact) {
  int tried = 0, gained = 0;
  expect_always([&] {
    ++tried;
    Asked asked;
    asked.loads = false;
    asked.methods = {MethodName::fully_discrete, MethodName::finite_difference};
    RandomScene scene = *scenes(asked);
    scene.restitution = *sixteenths(1, 16);
    scene.outputs = 4;
    scene.end = 64 * scene.length;
    scene.steps_per_output = scene.elements * *rc::gen::map(rc::gen::inRange(0, 9), [](int k) { return 1 << k; });
    for (const char* impact : {"paoli_schatzman", "moreau"}) {
      scene.impact = impact;
      const Statistics done = record(scene.read().run).statistics;
      const EnergyAccount& account = *done.energy;
      RC_ASSERT(account.final <= account.initial + account.growth + rounding(done));
      RC_ASSERT(std::abs(account.balance_error()) <= rounding(done));
      RC_ASSERT(scene.impact != "moreau" || account.growth <= rounding(done));
      const bool gains = account.growth > 0.001 * account.initial;
      RC_CLASSIFY(gains, "gains a thousandth");
      gained += gains;
    }
  });
  EXPECT_GE(gained, tried / 50) << "of " << tried << " scenes; too few to say anything";
}

TEST(Energy, AccountBalancesUnderAnyLoad) {
  expect_always([] {
    const RandomScene scene = *scenes();
    const Case run = scene.read().run;
    const Recording recording = record(run);
    const EnergyAccount account = recording.statistics.energy.value();
    const double largest_energy = account.initial + account.final + account.dissipated + std::abs(account.work);
    const double d = displacement_error(run, largest(recording.u));
    // The scheme's account is exact step by step, so only rounding is left.
    const double bound = is_scheme(run.method)
                             ? 1e-12 * static_cast<double>(recording.statistics.steps) * largest_energy
                             : 2.0 * energy_error(run, largest_energy, d);
    if (std::abs(account.balance_error()) > bound)
      RC_FAIL(fmt::format("balance error {} above {}", account.balance_error(), bound));
  });
}

}  // namespace
}  // namespace viscobar::properties
