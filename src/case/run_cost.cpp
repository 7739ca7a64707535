#include "case/run_cost.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "case/method_table.hpp"
#include "case/regime.hpp"

namespace viscobar {

namespace {

// All constants, and the seconds in the table of methods, are fits to tests/measurements/sweep.cpp.
constexpr double start_seconds = 3e-4;  // reading, building the system

// int min(c/h, E/eta, c sqrt(2 rho / (eta t))) dt over [0, T]
double wave_phase(const Setup& setup) {
  const Case& run = setup.run;
  const Bar& bar = run.scene.bar;
  const double c = bar.wave_speed(), mesh = c / setup.mesh.spacing();
  if (bar.viscosity == 0.0) return mesh * run.end;
  const double cap = std::min(mesh, bar.modulus / bar.viscosity);
  const double slope = 2.0 * bar.modulus / bar.viscosity;  // c sqrt(2 rho / eta), squared
  const double bend = std::min(run.end, slope / (cap * cap));
  return cap * bend + 2.0 * (std::sqrt(slope * run.end) - std::sqrt(slope * bend));
}

// Closings and openings of one end beyond those of a quiet contact.
double bounces(const Setup& setup, const ContactRegime& contact) {
  if (!contact.chatters || !contact.damping_ratio || contact.effective_mass == 0.0) return 0.0;
  const Bar& bar = setup.run.scene.bar;
  const auto elements = static_cast<double>(setup.run.elements);
  const double h = setup.mesh.spacing();
  const double until_quiet = 1.5 / (std::numbers::pi * std::max(*contact.damping_ratio, 1e-12));
  const bool flies_with_the_wave = bar.viscosity < 0.2 * h * bar.impedance();
  const double half_periods = setup.run.end / (std::numbers::pi * std::sqrt(contact.effective_mass * setup.epsilon));
  return std::min({until_quiet, flies_with_the_wave ? elements : half_periods, half_periods});
}

// The contacts of the bar's first few elements: what an end node is and does is decided there. Bars in line are as long
// as they are.
std::vector<ContactRegime> contacts_of(const Setup& whole) {
  constexpr std::size_t enough = 32;
  if (!whole.run.scene.chain.empty()) return contact_regimes(whole, whole.system());
  Case part = whole.run;
  part.elements = std::min(part.elements, enough);
  part.scene.bar.length = whole.mesh.spacing() * static_cast<double>(part.elements);
  part.scene.displacement = part.scene.velocity = [](double) { return 0.0; };
  part.scene.load.reset();
  const Setup setup = resolve(std::move(part));
  return contact_regimes(setup, setup.system());
}

double adaptive_steps(const Setup& setup) {
  const Case& run = setup.run;
  constexpr double steps_of_a_start = 20.0, quiet_starts = 6.0, steps_a_radian = 8.0;
  const double modes = std::log(1.0 + static_cast<double>(run.elements));
  double contacts = 0.0;
  if (is_penalised(run.method))
    for (const ContactRegime& contact : contacts_of(setup)) contacts += bounces(setup, contact);
  const double growth = std::pow(run.tolerance.relative / 1e-4, -1.0 / 7.0);
  return growth * ((quiet_starts + contacts) * steps_of_a_start + 46.0 * modes + steps_a_radian * wave_phase(setup));
}

}  // namespace

double estimated_seconds(const Setup& setup) {
  const Case& run = setup.run;
  const auto nodes = static_cast<double>(setup.mesh.nodes());
  const StepSeconds seconds = method_row(run.method).seconds;
  if (is_scheme(run.method)) {
    const double searches = run.scene.span ? 3.0 : 1.0;
    return start_seconds + run.end / setup.step * (seconds.step + searches * seconds.node * nodes);
  }
  if (run.method == MethodName::characteristics) {
    const double passages = run.end * run.scene.bar.wave_speed() / run.scene.bar.length;
    return start_seconds + passages * seconds.step + run.end / run.output_every * nodes * seconds.node;
  }
  if (run.method == MethodName::exponential) {
    const double matrices = 1e-8 * nodes * nodes * nodes, sub_steps = 10.0 * wave_phase(setup);
    return start_seconds + matrices + sub_steps * 4e-9 * nodes * nodes;
  }
  return start_seconds + adaptive_steps(setup) * (seconds.step + seconds.node * nodes);
}

MemoryNeed memory_need(const Case& run) {
  const Scene& scene = run.scene;
  const double n = static_cast<double>(run.elements) + 1.0 - is_fixed(scene.left) - is_fixed(scene.right);
  double vectors = 12.0;  // the system itself: mass with its factor, initial data, two fields for output
  if (const auto own = method_row(run.method).vectors) vectors += own(run, n);
  vectors += 8.0;  // the matrix and its factor, right-hand sides
  return {vectors, (vectors * n + run.end / run.output_every) * sizeof(double)};
}

double memory_limit() {
  static const double of_machine =
      static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  double limit = of_machine;
  if (rlimit own{}; ::getrlimit(RLIMIT_AS, &own) == 0 && own.rlim_cur != RLIM_INFINITY)
    limit = std::min(limit, static_cast<double>(own.rlim_cur));
  static const double of_group = [] {
    double bytes = 0.0;  // the file says "max" where there is none
    return std::ifstream("/sys/fs/cgroup/memory.max") >> bytes ? bytes : std::numeric_limits<double>::infinity();
  }();
  return std::min(limit, of_group);
}

}  // namespace viscobar
