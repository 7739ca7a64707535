#include <stdexcept>

#include "benchmark/baselines.hpp"
#include "benchmark/odeint.hpp"
#include "viscobar/dynamics/load_vector.hpp"

namespace viscobar::baseline {

Interleaved::Interleaved(const Problem& problem)
    : problem_(problem),
      nodes_(problem.system.size()),
      stiffness_(problem.system.bar().modulus / problem.system.mesh().spacing()),
      damping_(problem.system.bar().viscosity / problem.system.mesh().spacing()),
      penalty_(1.0 / problem.epsilon),
      gap_(problem.system.contacts().front().gap),
      load_(nodes_, 0.0) {
  if (!problem.system.inertia().matrix().off_diagonal.empty())
    throw std::invalid_argument("baselines need the lumped mass");
  for (const double mass : problem.system.inertia().matrix().diagonal) inverse_mass_.push_back(1.0 / mass);
  if (problem.system.loaded()) {
    LoadVector load(problem.system);
    const auto values = load.at(0.0);
    load_.assign(values.begin(), values.end());
  }
}

std::vector<double> Interleaved::start() const {
  const State state = problem_.system.initial_state();
  std::vector<double> y(size());
  for (std::size_t i = 0; i < nodes_; ++i) y[2 * i] = state.u[i], y[2 * i + 1] = state.v[i];
  return y;
}

void Interleaved::rates(const double* y, double* out) const {
  double before = 0.0;
  for (std::size_t i = 0; i < nodes_; ++i) {
    const double* here = y + 2 * i;
    const double behind = i + 1 < nodes_ ? stiffness_ * (here[2] - here[0]) + damping_ * (here[3] - here[1]) : 0.0;
    out[2 * i] = here[1];
    out[2 * i + 1] = (behind - before + load_[i]) * inverse_mass_[i];
    before = behind;
  }
  for (const std::size_t i : {std::size_t{0}, nodes_ - 1})
    if (y[2 * i] < -gap_) out[2 * i + 1] -= penalty_ * (y[2 * i] + gap_) * inverse_mass_[i];
}

namespace {

OrdinarySystem ordinary(const Interleaved& system, const Problem& problem) {
  const std::size_t n = system.size();
  return {system.start(), problem.times, [&system](const double* y, double* rate) { system.rates(y, rate); },
          [&system, n](const double* y, double* matrix) {
            system.jacobian(y, [&](std::size_t i, std::size_t j, double value) { matrix[i * n + j] = value; });
          }};
}

}  // namespace

Trace rosenbrock4(const Problem& problem, double relative, double absolute) {
  const Interleaved system(problem);
  Trace trace;
  trace.steps = odeint_rosenbrock4(ordinary(system, problem), relative, absolute, trace.left);
  return trace;
}

Trace dopri5(const Problem& problem, double relative, double absolute) {
  const Interleaved system(problem);
  Trace trace;
  trace.steps = odeint_dopri5(ordinary(system, problem), relative, absolute, trace.left);
  return trace;
}

}  // namespace viscobar::baseline
