#include "studies/accuracy/quick_estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "case/regime.hpp"
#include "dynamics/jump_filter.hpp"
#include "studies/accuracy/data_error.hpp"
#include "studies/accuracy/space_error.hpp"
#include "studies/parallel.hpp"

namespace viscobar::accuracy {

namespace {

constexpr std::size_t fewest = 3;  // elements of the coarsest mesh
constexpr double least_seconds = 0.5;
constexpr double worth_a_thread = 0.02;  // seconds; a thread costs as much as a small bar

// Of half and of a quarter as many elements; for a scheme, the latter with twice the step, too. An eighth where it is
// asked for and enough.
struct Coarser {
  Sample half, quarter;
  std::optional<Sample> longer_steps, eighth;
  std::size_t elements_half = 0, elements_quarter = 0, elements_eighth = 0;
  double seconds = 0.0;
};

/// Why there is no estimate.
struct None {
  std::string why;
};

/// @throws None
Coarser coarser_runs(const Case& run, double seconds, bool down_to_an_eighth, const std::function<bool()>& stop) {
  Coarser result;
  result.elements_half = (run.elements + 1) / 2;
  result.elements_quarter = (result.elements_half + 1) / 2;
  if (result.elements_quarter < fewest)
    throw None{fmt::format("it needs {} elements or more, whose mesh can be halved twice", 4 * fewest - 3)};
  result.elements_eighth = (result.elements_quarter + 1) / 2;
  const bool eighth = down_to_an_eighth && result.elements_eighth >= fewest;
  std::vector<Case> cases(eighth ? 3 : 2, run);
  cases[0].elements = result.elements_half;
  cases[1].elements = result.elements_quarter;
  if (eighth) cases[2].elements = result.elements_eighth;
  for (Case& one : cases) {
    if (is_penalised(run.method)) one.epsilon = effective_epsilon(run);
    one.mass = effective_mass(run);
    if (is_scheme(run.method)) one.step = scheme_step(run);
  }
  if (is_scheme(run.method)) {
    cases.push_back(cases[1]);
    *cases.back().step *= 2.0;
  }
  for (const Case& one : cases)
    if (const auto found = validate(one); !found.empty())
      throw None{fmt::format("with {} elements {}: {}", one.elements, found[0].key, found[0].problem)};
  const double most = std::max(seconds, least_seconds);
  const auto began = std::chrono::steady_clock::now();
  const auto passed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count(); };
  std::vector<std::optional<Sample>> found(cases.size());
  parallel_for(
      cases.size(),
      [&](std::size_t i) {
        try {
          found[i] = sample_of(cases[i], [&] { return (stop && stop()) || passed() > most; });
        } catch (const IntegrationError& error) {
          throw None{fmt::format("the run on {} elements failed: {}", cases[i].elements, error.what())};
        }
      },
      seconds < worth_a_thread ? 1 : 0);
  if (!std::all_of(found.begin(), found.end(), [](const auto& one) { return one.has_value(); }))
    throw None{stop && stop() ? "it was interrupted"
                              : fmt::format("runs on coarser meshes took longer than {:.2g} s", most)};
  result.half = std::move(*found[0]);
  result.quarter = std::move(*found[1]);
  if (eighth) result.eighth = std::move(found[2]);
  if (is_scheme(run.method)) result.longer_steps = std::move(found.back());
  result.seconds = passed();
  return result;
}

double time_error(const Case& run, const Coarser& runs, double largest_u) {
  if (runs.longer_steps) return difference(runs.quarter, *runs.longer_steps, Goal::displacement);
  if (!is_adaptive(run.method)) return 0.0;
  const double absolute = allowance(run.tolerance, make_system(run), run.end).displacement;
  const double steps_alone = run.tolerance.control == ErrorControl::local ? 1000.0 : 2.0;
  return steps_alone * (run.tolerance.relative * largest_u + absolute);
}

ErrorEstimate estimate_of(const Case& run, const Coarser& runs, const Sample& finest) {
  ErrorEstimate estimate;
  estimate.largest = largest(finest, Goal::displacement);
  estimate.time = time_error(run, runs, estimate.largest);
  if (is_penalised(run.method)) estimate.penalty = finest.statistics.max_penetration;
  if (is_penalised(run.method) && meets_obstacle(run.scene)) estimate.reasons.push_back(contact_law(run));
  estimate.seconds = runs.seconds;
  for (const auto& [elements, sample] :
       {std::pair{runs.elements_quarter, &runs.quarter}, {runs.elements_half, &runs.half}}) {
    ErrorEstimate::Run made;
    made.elements = elements;
    if (is_adaptive(run.method)) made.setting = run.tolerance.relative;
    if (is_scheme(run.method)) made.setting = scheme_step(run);
    if (is_penalised(run.method)) made.epsilon = effective_epsilon(run);
    made.seconds = sample->statistics.integration_seconds;
    made.changes = sample->statistics.events;
    estimate.runs.push_back(made);
  }
  return estimate;
}

ErrorEstimate of_waves(const Representation& waves, const Sample& solution) {
  ErrorEstimate estimate;
  estimate.largest = largest(solution, Goal::displacement);
  estimate.space = waves.error;
  estimate.time = waves.rounding;
  estimate.total = estimate.space + estimate.time;
  return estimate;
}

}  // namespace

QuickEstimate quick_estimate(const Case& run, const Sample& solution, double seconds,
                             const std::function<bool()>& stop) try {
  if (const auto& waves = solution.statistics.representation) return {of_waves(*waves, solution), {}};
  const Coarser runs = coarser_runs(run, seconds, false, stop);
  ErrorEstimate estimate = estimate_of(run, runs, solution);
  const double first = difference(runs.quarter, runs.half, Goal::displacement);
  const double last = difference(runs.half, solution, Goal::displacement);
  const MeshStep steps[] = {
      {runs.elements_quarter, runs.elements_half, first},
      {runs.elements_half, run.elements, last, alignment(runs.quarter, runs.half, solution, Goal::displacement, {})}};
  const SpaceError space = DataError(run).of(space_error(steps, order_in_theory(run)), steps);
  estimate.space = space.error;
  estimate.order = space.trusted;
  estimate.effectivity = space.effectivity;
  estimate.total = estimate.space + estimate.penalty + estimate.time;
  return {estimate, {}};
} catch (const None& none) {
  return {std::nullopt, none.why};
}

namespace {

bool puts_modes_at_rest(const Case& run) {
  const BarSystem system = make_system(run);
  return JumpFilter(system).acts();
}

}  // namespace

QuickEstimate forecast(const Case& run, double seconds) try {
  if (run.method == MethodName::characteristics) return {};
  const Coarser runs = coarser_runs(run, seconds, true, {});
  ErrorEstimate estimate = estimate_of(run, runs, runs.half);
  std::vector<MeshStep> steps;
  if (runs.eighth)
    steps.push_back(
        {runs.elements_eighth, runs.elements_quarter, difference(*runs.eighth, runs.quarter, Goal::displacement)});
  steps.push_back({runs.elements_quarter, runs.elements_half, difference(runs.quarter, runs.half, Goal::displacement)});
  // Without viscosity kinks stay kinks; two meshes show no order, nor do those of which some put high modes at rest.
  const bool alike = runs.elements_eighth >= JumpFilter::fewest_elements || !puts_modes_at_rest(run);
  const bool smooth = runs.eighth && run.scene.bar.viscosity > 0.0 && alike;
  const double theory = smooth ? order_in_theory(run) : 1.0;
  const std::vector<MeshStep> all = prolonged(steps, run.elements, expected_order(steps, theory));
  estimate.space = DataError(run).of(space_error(all, theory), all).error;
  estimate.total = estimate.space + estimate.penalty + estimate.time;
  return {estimate, {}};
} catch (const None& none) {
  return {std::nullopt, none.why};
}

}  // namespace viscobar::accuracy
