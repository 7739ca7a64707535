#include "case/method_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace viscobar {

namespace {

// There is none in the solution; of this one nothing is refused.
Mass consistent(const Case&) { return Mass::consistent; }

// (3.22) is (2.8) with a diagonal product.
Mass diagonal(const Case& run) {
  const Mass mass = run.mass.value_or(Mass::consistent);
  return mass == Mass::consistent ? Mass::lumped : mass;
}

Penalty penalty(const Case& run) { return {effective_epsilon(run), run.restitution.value_or(1.0)}; }

Method scheme(const Case& run) {
  return FullyDiscrete{scheme_step(run), run.start, run.restitution.value_or(0.0), run.impact};
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

// What its steppers cannot take follows from the whole system.
void refuse_odeint(const Case& run, Findings& findings) {
  if (!findings.sound_tables({"bar", "left", "right", "span", "initial", "time", "mesh", "contact"}) ||
      !findings.sound({"method.stepper"}))
    return;
  const BarSystem system = make_system(run);
  const OdeintPlan what = plan(system, run.end, odeint(run));
  if (!what.refusal) return;
  switch (*what.refusal) {
    case Refusal::many_unknowns:
      return findings.report("method.stepper",
                             "rosenbrock4 works with dense matrices, up to {} unknown nodes, here are {}; "
                             "use arkode, or dopri5",
                             Odeint::most_dense_unknowns, system.size());
    case Refusal::many_steps:
      return findings.report(
          "method.name",
          "{} would make at least {:.1e} steps: it is explicit, and the scene is stiff; use cvode or "
          "arkode",
          name(what.stepper), what.least_steps);
    default: return;  // algebraic rows are reported of every method that does not take them
  }
}

std::size_t fixed_ends(const Scene& scene) {
  return std::size_t{is_fixed(scene.left)} + std::size_t{is_fixed(scene.right)};
}

void refuse_exponential(const Case& run, Findings& findings) {
  if (run.elements + 1 > Exponential::most_unknowns + fixed_ends(run.scene))
    findings.report("mesh.elements",
                    "exponential works with dense matrices and takes up to {} unknown "
                    "nodes; take fewer elements, or another method",
                    Exponential::most_unknowns);
}

void refuse_characteristics(const Case& run, Findings& findings) {
  if (!findings.sound({"bar.length", "bar.density", "bar.modulus", "bar.viscosity", "time.end"})) return;
  const Bar& bar = run.scene.bar;
  const auto why = refusal(run.scene, run.end, Characteristics{});
  if (why == Refusal::viscosity)
    findings.report("method.name",
                    "characteristics carries waves unchanged, and bar.viscosity = {} changes them; use "
                    "rigid, or one of the penalised methods",
                    bar.viscosity);
  if (why == Refusal::span)
    findings.report("method.name",
                    "characteristics knows obstacles at the ends, and under a span obstacle the whole bar may touch; "
                    "use fully_discrete, or one of the penalised methods");
  if (why == Refusal::end_springs)
    findings.report(run.scene.left_input.stiffness != 0.0 ? "left.stiffness" : "right.stiffness",
                    "is not for characteristics: a spring remembers what has arrived, and waves return as no "
                    "polynomials; use rigid, or fully_discrete");
  if (why == Refusal::many_steps)
    findings.report("time.end",
                    "characteristics follows a wave from passage to passage through the bar, here {:.2g} of "
                    "them, at most {:.0g}; choose an earlier end",
                    run.end * std::sqrt(bar.modulus / bar.density) / bar.length, Characteristics::most_passages);
}

void refuse_rigid(const Case& run, Findings& findings) {
  if (run.scene.span)
    findings.report("method.name", "rigid stops one node at a time, and under a span obstacle several meet it at once");
  if (end_obstacles(run.scene) > 0 && run.elements < 1 + fixed_ends(run.scene))
    findings.report("mesh.elements", "rigid needs an unknown node beside that of a contact: one more element");
}

void refuse_finite_difference(const Case& run, Findings& findings) {
  if (run.mass == Mass::redistributed || run.mass == Mass::fourth_order)
    findings.report("mesh.mass",
                    "\"{}\" does not fit finite_difference, whose mass is diagonal; use \"lumped\" or "
                    "\"paper\", or fully_discrete",
                    name(*run.mass));
  if (run.grading != 1.0)
    findings.report("mesh.grading",
                    "does not fit finite_difference, whose elements are of equal length; leave it out, or use "
                    "fully_discrete with the mass \"lumped\"");
}

// The seconds are fits to tests/measurements/sweep.cpp; the table in docs/internals/sweep-balance.md has their errors.
constexpr StepSeconds multistep{1.6e-6, 12e-9}, step_of_scheme{0.18e-6, 1.3e-9};

// clang-format off
constexpr MethodRow rows[] = {
    {.method = MethodName::cvode, .name = "cvode",
     .meaning = "penalised bar, multistep formulas of SUNDIALS' CVODE",
     .penalised = true, .accuracy = Accuracy::tolerances, .seconds = multistep,
     .options = [](const Case& run) -> Method { return Cvode{penalty(run), run.tolerance, run.formulas}; },
     .vectors = [](const Case& run, double) { return multistep_vectors(run.scene.bar.viscosity > 0.0 ? 6 : 13); },
      .differentiates = true, .takes_algebraic_rows = false},
    {.method = MethodName::ida, .name = "ida",
     .meaning = "penalised bar as a differential-algebraic system, SUNDIALS' IDA: also massless nodes without viscosity",
     .penalised = true, .accuracy = Accuracy::tolerances, .seconds = {1.3e-6, 14e-9},
     .options = [](const Case& run) -> Method { return Ida{penalty(run), run.tolerance}; },
     .vectors = [](const Case&, double) { return multistep_vectors(6); }, .differentiates = true},
    {.method = MethodName::arkode, .name = "arkode",
     .meaning = "penalised bar, implicit Runge-Kutta formulas of order 5 of SUNDIALS' ARKODE: also massless nodes without viscosity",
     .penalised = true, .accuracy = Accuracy::tolerances, .seconds = multistep,
     .options = [](const Case& run) -> Method { return Arkode{penalty(run), run.tolerance}; },
     .vectors = [](const Case&, double) { return one_step_vectors(7 + 8); }, .differentiates = true},
    {.method = MethodName::odeint, .name = "odeint",
     .meaning = "penalised bar by Boost.Odeint's steppers, an independent integrator",
     .penalised = true, .accuracy = Accuracy::tolerances, .seconds = multistep,
     .options = [](const Case& run) -> Method { return odeint(run); },
     // The dense matrices of rosenbrock4, on few nodes, do not count.
     .vectors = [](const Case&, double) { return one_step_vectors(14); }, .takes_algebraic_rows = false, .refuse = refuse_odeint},
    {.method = MethodName::rigid, .name = "rigid",
     .meaning = "the limit epsilon = 0 itself; no span obstacle",
     .penalised = false, .accuracy = Accuracy::tolerances, .seconds = multistep,
     .options = [](const Case& run) -> Method { return Rigid{run.tolerance, run.restitution.value_or(0.0)}; },
     .vectors = rigid_vectors, .differentiates = true, .refuse = refuse_rigid},
    {.method = MethodName::exponential, .name = "exponential",
     .meaning = "penalised bar by matrix exponentials, a reference on small meshes",
     .penalised = true, .accuracy = Accuracy::rounding, .seconds = {},
     .options = [](const Case& run) -> Method { return Exponential{penalty(run)}; },
     // Propagators of several sub-steps, dense over displacement and velocity.
     .vectors = [](const Case&, double nodes) { return 4.0 * 4.0 * nodes; }, .refuse = refuse_exponential},
    {.method = MethodName::characteristics, .name = "characteristics",
     .meaning = "exact waves of an undamped bar, whatever the mesh; obstacles at its ends only",
     .penalised = false, .accuracy = Accuracy::rounding, .seconds = {0.5e-6, 60e-9},
     .options = [](const Case&) -> Method { return Characteristics{}; },
     .mass = consistent, .refuse = refuse_characteristics},
    {.method = MethodName::fully_discrete, .name = "fully_discrete",
     .meaning = "the paper's scheme (2.8), implicit in the constraint",
     .penalised = false, .accuracy = Accuracy::step, .seconds = step_of_scheme,
     .options = scheme},
    {.method = MethodName::finite_difference, .name = "finite_difference",
     .meaning = "the paper's scheme (3.22): (2.8) with a diagonal mass",
     .penalised = false, .accuracy = Accuracy::step, .seconds = step_of_scheme,
     .options = scheme, .mass = diagonal, .refuse = refuse_finite_difference},
};
// clang-format on
static_assert(std::ranges::equal(rows, all_methods, {}, &MethodRow::method), "a row for each method, in their order");

}  // namespace

bool has_algebraic_rows(const Case& run) {
  return run.mass == Mass::redistributed && end_obstacles(run.scene) > 0 && run.scene.bar.viscosity == 0.0;
}

std::span<const MethodRow> method_table() { return rows; }

const MethodRow& method_row(MethodName method) {
  const auto index = static_cast<std::size_t>(method);
  assert(rows[index].method == method);
  return rows[index];
}

}  // namespace viscobar
