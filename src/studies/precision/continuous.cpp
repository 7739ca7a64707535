#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene/end_kinds.hpp"
#include "studies/accuracy/sample.hpp"
#include "studies/precision/solved.hpp"
#include "viscobar/studies/orders/observed_order.hpp"

namespace viscobar::precision {

namespace {

constexpr double tolerance = 1e-9;     // of the error; a run with a tenth of it keeps it, where two meshes cannot tell
constexpr double usual_error = 0.005;  // of it, what the methods leave (docs/accuracy-on-request.md)
// A mesh is the last when it has so many elements, or differs from the one before by what its tolerance leaves, after
// so many doublings: the last three of four meshes show an order.
constexpr std::size_t fine = 1000, least_doublings = 3;

Case on_mesh(const Case& scene, std::size_t elements) {
  Case run = scene;
  run.elements = elements;
  if (!keeps_restitution(run.scene)) run.restitution.reset();
  run.tolerance = run.tolerance.with_relative(0.1 * tolerance);
  // Stops with laws of their own are what they are in the bar itself.
  const MethodName by_laws = scene.scene.bar.viscosity > 0.0 ? MethodName::arkode : MethodName::cvode;
  for (const MethodName method : {MethodName::rigid, by_laws})
    for (const Mass mass : {Mass::fourth_order, Mass::redistributed}) {
      run.method = method;
      run.mass = mass;
      if ((method == MethodName::rigid || !has_penalty(scene.scene)) && sound(run)) return run;
    }
  run.mass = scene.mass;
  run.restitution = scene.restitution;
  run.method = MethodName::fully_discrete;
  run.start = Start::second_order;
  run.step = run.mesh().spacing() / (16.0 * run.scene.bar.wave_speed());
  return run;
}

double largest(const std::vector<Field>& fields) {
  double size = 0.0;
  for (const Field& field : fields)
    for (const double u : field.u) size = std::max(size, std::abs(u));
  return size;
}

Continuous known(const std::string& what, double error, std::vector<Field> fields) {
  PrecisionReference reference;
  reference.what = what;
  reference.closed_form = true;
  reference.error = error;
  reference.largest_displacement = largest(fields);
  return {std::move(reference), {}, std::move(fields)};
}

}  // namespace

Continuous refine(const Case& scene, std::span<const Mesh> meshes, std::size_t elements, const RunLimits& limits) {
  Continuous result;
  PrecisionReference reference;
  double difference = std::numeric_limits<double>::infinity();
  const auto enough = [&] { return elements / 2 >= fine || difference <= tolerance * largest(result.fields); };
  for (std::size_t doublings = 0; doublings <= least_doublings || !enough(); ++doublings, elements *= 2) {
    const Case run = on_mesh(scene, elements);
    try {
      std::vector<Field> fields = fields_of(run, meshes, limits);
      if (!result.fields.empty()) {
        difference = 0.0;
        for (std::size_t m = 0; m < meshes.size(); ++m)
          difference = std::max(difference, largest_difference(result.fields[m], fields[m]));
        reference.levels.back().difference = difference;
      }
      result.fields = std::move(fields);
      reference.levels.push_back({elements, std::nullopt});
      reference.what = fmt::format("{} on {} elements", name(run.method), elements);
      reference.what += is_scheme(run.method) ? fmt::format(", step {:.3g}", *run.step)
                                              : fmt::format(", tolerance {:.3g}", run.tolerance.relative);
    } catch (const std::exception& error) {
      result.problem = fmt::format("{} on {} elements: {}", name(run.method), elements, error.what());
      break;
    }
  }
  const auto& levels = reference.levels;
  if (levels.size() < 2) {
    result.fields.clear();
    return result;
  }
  reference.largest_displacement = largest(result.fields);
  Sequence changes;
  changes.within = Sequence::by_few;
  for (const auto& level : levels)
    if (level.difference)
      changes.add(1.0 / static_cast<double>(level.elements), *level.difference,
                  usual_error * tolerance * reference.largest_displacement);
  if (const auto order = changes.order()) reference.order = order->order;
  // Neighbouring meshes differ by (2^q - 1) times the error of the finer one; what is not settled is not above 1.
  const std::size_t count = changes.x.size();
  const double last = count > 1 ? changes.power(count - 2).value_or(1.0) : 1.0;
  const double order = std::clamp(reference.order.value_or(std::min(last, 1.0)), 0.3, 4.0);
  reference.error = difference / (std::exp2(order) - 1.0) + tolerance * reference.largest_displacement;
  const auto grows = [&](std::size_t i) { return changes.power(i).value_or(1.0) <= 0.0; };
  constexpr double far = 10.0;  // above what the tolerance leaves
  if (count > 2 && grows(count - 2) && grows(count - 3) &&
      difference > far * tolerance * reference.largest_displacement) {
    reference.settles = false;
    reference.error = std::max(reference.error, reference.largest_displacement);
  }
  result.reference = std::move(reference);
  return result;
}

Continuous closed_form(const KnownSolution& solution, const Case& scene, std::span<const Mesh> meshes) {
  const std::vector<double> times = scene.output_times();
  std::vector<Field> fields;
  for (const Mesh& mesh : meshes) fields.push_back(field_of(solution.u, mesh, times));
  return known(solution.name, 0.0, std::move(fields));
}

Continuous by_characteristics(const Case& scene, std::span<const Mesh> meshes, const RunLimits& limits) {
  std::vector<Field> fields;
  double error = 0.0;
  for (const Mesh& mesh : meshes) {
    Case run = accuracy::on_mesh(scene, mesh);
    run.method = MethodName::characteristics;
    Statistics done;
    fields.push_back(field_of(run, mesh, limits, &done));
    if (done.representation) error = std::max(error, done.representation->error);
  }
  return known(fmt::format("characteristics, which know the bar itself to {:.1e}", error), error, std::move(fields));
}

}  // namespace viscobar::precision
