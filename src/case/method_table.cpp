#include "case/method_table.hpp"

#include <algorithm>
#include <cassert>

#include "scene/end_kinds.hpp"

namespace viscobar {

namespace {

// There is none in the solution; of this one nothing is refused.
Mass consistent(const Case&) { return Mass::consistent; }

// (3.22) is (2.8) with a diagonal product.
Mass diagonal(const Case& run) {
  const Mass mass = run.mass.value_or(Mass::consistent);
  return mass == Mass::consistent ? Mass::lumped : mass;
}

Characteristics waves(const Case& run) { return {.restitution = run.restitution.value_or(0.0)}; }

Penalty penalty(const Setup& setup) { return {setup.epsilon, setup.run.restitution.value_or(1.0)}; }

Method scheme(const Setup& setup) {
  const Case& run = setup.run;
  return FullyDiscrete{setup.step, run.start, run.restitution.value_or(0.0), run.impact};
}

// Vectors with an entry a node. One of a multistep method has displacement and velocity: its history and some eight
// more. One-step methods keep the stages of a step and its two ends.
constexpr double multistep_vectors(int history) { return 2.0 * (history + 8); }
constexpr double one_step_vectors(int stages) { return 2.0 * stages + 2.0 * 3.0; }

// With viscosity the factor of four complex systems, their right-hand sides, solution and its correction, matrices and
// some ten more; else ARKODE's.
double rigid_vectors(const Case& run, double) {
  return run.scene.bar.viscosity > 0.0 ? 24 + 4 * 8 + 6 + 12 : one_step_vectors(7 + 8);
}

// The seconds are fits to tests/measurements/sweep.cpp; the table in docs/internals/sweep-balance.md has their errors.
constexpr StepSeconds multistep{1.6e-6, 12e-9}, step_of_scheme{0.1e-6, 1.3e-9};

// clang-format off
constexpr MethodRow rows[] = {
    {.method = MethodName::cvode, .name = "cvode",
     .meaning = "penalised bar, multistep formulas of SUNDIALS' CVODE",
     .penalised = true, .accuracy = Accuracy::tolerances, .seconds = multistep,
     .options = [](const Setup& setup) -> Method { return Cvode{penalty(setup), setup.run.tolerance, setup.run.formulas}; },
     .vectors = [](const Case& run, double) { return multistep_vectors(run.scene.bar.viscosity > 0.0 ? 6 : 13); },
      .differentiates = true, .takes_algebraic_rows = false, .takes_laws = true},
    {.method = MethodName::ida, .name = "ida",
     .meaning = "penalised bar as a differential-algebraic system, SUNDIALS' IDA: also massless nodes without viscosity",
     .penalised = true, .accuracy = Accuracy::tolerances, .seconds = {1.3e-6, 14e-9},
     .options = [](const Setup& setup) -> Method { return Ida{penalty(setup), setup.run.tolerance}; },
     .vectors = [](const Case&, double) { return multistep_vectors(6); }, .differentiates = true, .takes_laws = true},
    {.method = MethodName::arkode, .name = "arkode",
     .meaning = "penalised bar, implicit Runge-Kutta formulas of order 5 of SUNDIALS' ARKODE: also massless nodes without viscosity",
     .penalised = true, .accuracy = Accuracy::tolerances, .seconds = multistep,
     .options = [](const Setup& setup) -> Method { return Arkode{penalty(setup), setup.run.tolerance}; },
     .vectors = [](const Case&, double) { return one_step_vectors(7 + 8); }, .differentiates = true, .takes_laws = true},
    {.method = MethodName::odeint, .name = "odeint",
     .meaning = "penalised bar by Boost.Odeint's steppers, an independent integrator",
     .penalised = true, .accuracy = Accuracy::tolerances, .seconds = multistep,
     .options = [](const Setup& setup) -> Method { return Odeint{penalty(setup), setup.run.tolerance, setup.run.stepper}; },
     .vectors = [](const Case&, double) { return one_step_vectors(14); }, .takes_algebraic_rows = false, .takes_laws = true},
    {.method = MethodName::rigid, .name = "rigid",
     .meaning = "the limit epsilon = 0 itself; no span obstacle",
     .penalised = false, .accuracy = Accuracy::tolerances, .seconds = multistep,
     .options = [](const Setup& setup) -> Method { return Rigid{setup.run.tolerance, setup.run.restitution.value_or(0.0)}; },
     .vectors = rigid_vectors, .differentiates = true},
    {.method = MethodName::exponential, .name = "exponential",
     .meaning = "penalised bar by matrix exponentials, a reference on small meshes",
     .penalised = true, .accuracy = Accuracy::rounding, .seconds = {},
     .options = [](const Setup& setup) -> Method { return Exponential{penalty(setup)}; },
     // Propagators of several sub-steps, dense over displacement and velocity.
     .vectors = [](const Case&, double nodes) { return 4.0 * 4.0 * nodes; }, .takes_laws = true},
    {.method = MethodName::characteristics, .name = "characteristics",
     .meaning = "exact waves of an undamped bar, whatever the mesh; obstacles at its ends only",
     .penalised = false, .accuracy = Accuracy::rounding, .seconds = {0.5e-6, 60e-9},
     .options = [](const Setup& setup) -> Method { return waves(setup.run); },
     .mass = consistent, .takes_laws = true},
    {.method = MethodName::fully_discrete, .name = "fully_discrete",
     .meaning = "the paper's scheme (2.8), implicit in the constraint",
     .penalised = false, .accuracy = Accuracy::step, .seconds = step_of_scheme,
     .options = scheme},
    {.method = MethodName::finite_difference, .name = "finite_difference",
     .meaning = "the paper's scheme (3.22): (2.8) with a diagonal mass",
     .penalised = false, .accuracy = Accuracy::step, .seconds = step_of_scheme,
     .options = scheme, .mass = diagonal},
};
// clang-format on
static_assert(std::ranges::equal(rows, all_methods, {}, &MethodRow::method), "a row for each method, in their order");

}  // namespace

std::optional<Finding> refusal_by_characteristics(const Case& run) { return refusal(run.scene, run.end, waves(run)); }

bool has_algebraic_rows(const Case& run) {
  return run.mass == Mass::redistributed && bare_obstacles(run.scene) > 0 && run.scene.bar.viscosity == 0.0;
}

std::span<const MethodRow> method_table() { return rows; }

const MethodRow& method_row(MethodName method) {
  const auto index = static_cast<std::size_t>(method);
  assert(rows[index].method == method);
  return rows[index];
}

}  // namespace viscobar
