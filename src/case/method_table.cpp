#include "case/method_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>

#include "viscobar/characteristics/characteristics.hpp"

namespace viscobar {

namespace {

// There is none in the solution; of this one nothing is refused.
Mass consistent(const Case&) { return Mass::consistent; }

// (3.22) is (2.8) with a diagonal product.
Mass diagonal(const Case& run) {
  const Mass mass = run.mass.value_or(Mass::consistent);
  return mass == Mass::consistent ? Mass::lumped : mass;
}

Statistics run_cvode(const Case& run, const BarSystem& system, const StartingPoint& start,
                     std::span<const double> times, const Observers& observers) {
  return integrate(system, start, times, Cvode{penalty(run), run.tolerance, run.formulas}, observers);
}

Statistics run_ida(const Case& run, const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                   const Observers& observers) {
  return integrate(system, start, times, Ida{penalty(run), run.tolerance}, observers);
}

Statistics run_arkode(const Case& run, const BarSystem& system, const StartingPoint& start,
                      std::span<const double> times, const Observers& observers) {
  return integrate(system, start, times, Arkode{penalty(run), run.tolerance}, observers);
}

Statistics run_odeint(const Case& run, const BarSystem& system, const StartingPoint& start,
                      std::span<const double> times, const Observers& observers) {
  return integrate(system, start, times, odeint(run), observers);
}

Statistics run_rigid(const Case& run, const BarSystem& system, const StartingPoint& start,
                     std::span<const double> times, const Observers& observers) {
  return integrate(system, start, times, Rigid{run.tolerance, run.restitution.value_or(0.0)}, observers);
}

Statistics run_exponential(const Case& run, const BarSystem& system, const StartingPoint& start,
                           std::span<const double> times, const Observers& observers) {
  return integrate(system, start, times, Exponential{penalty(run)}, observers);
}

Statistics run_characteristics(const Case& run, const BarSystem&, const StartingPoint& start,
                               std::span<const double> times, const Observers& observers) {
  const auto* checkpoint = std::get_if<Checkpoint>(&start);
  return integrate(run.scene, run.mesh(), checkpoint ? std::optional(*checkpoint) : std::nullopt, times,
                   Characteristics{}, observers);
}

Statistics run_scheme(const Case& run, const BarSystem& system, const StartingPoint& start,
                      std::span<const double> times, const Observers& observers) {
  return integrate(system, start, times,
                   FullyDiscrete{scheme_step(run), run.start, run.restitution.value_or(0.0), run.impact}, observers);
}

// A vector of a multistep method has displacement and velocity: its history and some eight more.
constexpr double multistep_vectors(int history) { return 2.0 * (history + 8); }

double cvode_vectors(const Case& run, double) { return multistep_vectors(run.scene.bar.viscosity > 0.0 ? 6 : 13); }

double bdf_vectors(const Case&, double) { return multistep_vectors(6); }

// The stages of a step and some eight more, and the step's two ends.
double arkode_vectors(const Case&, double) { return 2 * (7 + 8) + 2 * 3; }

// The stages of a step, and the step's two ends. The dense matrices of rosenbrock4, on few nodes, do not count.
double odeint_vectors(const Case&, double) { return 2 * 14 + 2 * 3; }

// Propagators of several sub-steps, dense over displacement and velocity.
double exponential_vectors(const Case&, double nodes) { return 4.0 * 4.0 * nodes; }

void refuse_cvode(const Case& run, Findings& findings) {
  if (run.mass == Mass::redistributed && (is_obstacle(run.scene.left) || is_obstacle(run.scene.right)) &&
      run.scene.bar.viscosity == 0.0 && findings.sound({"mesh.mass", "bar.viscosity"}))
    findings.report("method.name",
                    "cvode cannot take massless contact nodes without viscosity: their equations "
                    "are algebraic; use ida, or a positive bar.viscosity");
}

// What its steppers cannot take follows from the whole system.
void refuse_odeint(const Case& run, Findings& findings) {
  if (!findings.sound({"bar.length", "bar.density", "bar.modulus", "bar.viscosity", "left.kind", "left.gap",
                       "right.kind", "right.gap", "span.gap", "initial.displacement", "initial.velocity", "time.end",
                       "mesh.elements", "mesh.grading", "mesh.mass", "contact.epsilon", "contact.restitution",
                       "method.stepper", "method.step"}))
    return;
  if (const OdeintPlan what = plan(make_system(run), run.end, odeint(run)); what.refusal) findings.add({*what.refusal});
}

void refuse_exponential(const Case& run, Findings& findings) {
  const std::size_t fixed = std::size_t{is_fixed(run.scene.left)} + std::size_t{is_fixed(run.scene.right)};
  if (run.elements + 1 > Exponential::most_unknowns + fixed)
    findings.report("mesh.elements", fmt::format("exponential works with dense matrices and takes up to {} unknown "
                                                 "nodes; take fewer elements, or another method",
                                                 Exponential::most_unknowns));
}

void refuse_characteristics(const Case& run, Findings& findings) {
  if (!findings.sound({"bar.length", "bar.density", "bar.modulus", "bar.viscosity", "time.end"})) return;
  const Bar& bar = run.scene.bar;
  if (const auto problem = misfit(run.scene, Characteristics{})) findings.report("method.name", *problem);
  if (const double passages = run.end * std::sqrt(bar.modulus / bar.density) / bar.length;
      !(passages <= Characteristics::most_passages))
    findings.report(
        "time.end",
        fmt::format("characteristics follows a wave from passage to passage through the bar, here {:.2g} of "
                    "them, at most {:.0g}; choose an earlier end",
                    passages, Characteristics::most_passages));
}

void refuse_rigid(const Case& run, Findings& findings) {
  if (run.scene.span)
    findings.report("method.name", "rigid stops one node at a time, and under a span obstacle several meet it at once");
  const std::size_t fixed = std::size_t{is_fixed(run.scene.left)} + std::size_t{is_fixed(run.scene.right)};
  const bool obstacle = is_obstacle(run.scene.left) || is_obstacle(run.scene.right);
  if (obstacle && run.elements < 1 + fixed)
    findings.report("mesh.elements", "rigid needs an unknown node beside that of a contact: one more element");
}

void refuse_finite_difference(const Case& run, Findings& findings) {
  if (run.mass == Mass::redistributed)
    findings.report("mesh.mass",
                    "\"redistributed\" does not fit finite_difference, whose mass is diagonal; use "
                    "\"lumped\" or \"paper\", or fully_discrete");
  if (run.mass == Mass::fourth_order)
    findings.report("mesh.mass",
                    "\"fourth_order\" does not fit finite_difference, whose mass is diagonal; use \"lumped\" or "
                    "\"paper\", or fully_discrete");
  if (run.grading != 1.0)
    findings.report("mesh.grading",
                    "does not fit finite_difference, whose elements are of equal length; leave it out, or use "
                    "fully_discrete with the mass \"lumped\"");
}

// The seconds are fits to tests/measurements/sweep.cpp; the table in docs/internals/sweep-balance.md has their errors.
constexpr StepSeconds multistep{1.6e-6, 12e-9}, scheme{0.18e-6, 1.3e-9};

// clang-format off
constexpr MethodRow rows[] = {
    {.method = MethodName::cvode, .name = "cvode",
     .meaning = "penalised bar, multistep formulas of SUNDIALS' CVODE",
     .penalised = true, .accuracy = Accuracy::tolerances, .seconds = multistep,
     .run = run_cvode, .vectors = cvode_vectors, .refuse = refuse_cvode},
    {.method = MethodName::ida, .name = "ida",
     .meaning = "penalised bar as a differential-algebraic system, SUNDIALS' IDA: also massless nodes without viscosity",
     .penalised = true, .accuracy = Accuracy::tolerances, .seconds = {1.3e-6, 14e-9},
     .run = run_ida, .vectors = bdf_vectors, .algebraic = true},
    {.method = MethodName::arkode, .name = "arkode",
     .meaning = "penalised bar, implicit Runge-Kutta formulas of order 5 of SUNDIALS' ARKODE: also massless nodes without viscosity",
     .penalised = true, .accuracy = Accuracy::tolerances, .seconds = multistep,
     .run = run_arkode, .vectors = arkode_vectors, .algebraic = true},
    {.method = MethodName::odeint, .name = "odeint",
     .meaning = "penalised bar by Boost.Odeint's steppers, an independent integrator",
     .penalised = true, .accuracy = Accuracy::tolerances, .seconds = multistep,
     .run = run_odeint, .vectors = odeint_vectors, .refuse = refuse_odeint},
    {.method = MethodName::rigid, .name = "rigid",
     .meaning = "the limit epsilon = 0 itself; no span obstacle",
     .penalised = false, .accuracy = Accuracy::tolerances, .seconds = multistep,
     .run = run_rigid, .vectors = bdf_vectors, .refuse = refuse_rigid},
    {.method = MethodName::exponential, .name = "exponential",
     .meaning = "penalised bar by matrix exponentials, a reference on small meshes",
     .penalised = true, .accuracy = Accuracy::rounding, .seconds = {},
     .run = run_exponential, .vectors = exponential_vectors, .algebraic = true, .refuse = refuse_exponential},
    {.method = MethodName::characteristics, .name = "characteristics",
     .meaning = "exact waves of an undamped bar, whatever the mesh; obstacles at its ends only",
     .penalised = false, .accuracy = Accuracy::rounding, .seconds = {0.5e-6, 60e-9},
     .run = run_characteristics, .mass = consistent, .refuse = refuse_characteristics},
    {.method = MethodName::fully_discrete, .name = "fully_discrete",
     .meaning = "the paper's scheme (2.8), implicit in the constraint",
     .penalised = false, .accuracy = Accuracy::step, .seconds = scheme,
     .run = run_scheme},
    {.method = MethodName::finite_difference, .name = "finite_difference",
     .meaning = "the paper's scheme (3.22): (2.8) with a diagonal mass",
     .penalised = false, .accuracy = Accuracy::step, .seconds = scheme,
     .run = run_scheme, .mass = diagonal, .refuse = refuse_finite_difference},
};
// clang-format on
static_assert(std::ranges::equal(rows, all_methods, {}, &MethodRow::method), "a row for each method, in their order");

}  // namespace

std::span<const MethodRow> method_table() { return rows; }

const MethodRow& method_row(MethodName method) {
  const auto index = static_cast<std::size_t>(method);
  assert(rows[index].method == method);
  return rows[index];
}

}  // namespace viscobar
