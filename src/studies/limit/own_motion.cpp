#include <algorithm>
#include <optional>
#include <utility>

#include "scene/end_kinds.hpp"
#include "studies/limit/mesh_runs.hpp"

namespace viscobar::limit {

namespace {

Case own_motion_case(const LimitStudy& study, std::size_t elements) {
  Case run = penalised_case(study, elements, study.epsilons.front());
  if (!keeps_restitution(run.scene)) run.restitution.reset();
  run.tolerance = run.tolerance.with_relative(1e-10);
  run.mass.reset();
  run.method = MethodName::characteristics;
  if (run.scene.bar.viscosity == 0.0 && sound(run)) return run;
  run.method = MethodName::rigid;
  run.mass = Mass::fourth_order;
  return run;
}

/// The bar's own motion, and the same on half as many elements, which tells its error.
struct Reference {
  Run half, fine;
};

// On twice the finest mesh, or as much finer as its error has to be for powers of h: a touch of unlike viscous bars has
// an error of order 2 on every mass.
std::optional<Reference> reference_of(const LimitStudy& study, std::size_t elements, const MeshRuns& finest,
                                      Purse& purse) {
  constexpr std::size_t most = 16;
  constexpr double above = 10.0, runs = 6.0;
  Reference found{{own_motion_case(study, elements)}, {own_motion_case(study, 2 * elements)}};
  if (!sound(found.fine.run) || !found.half.trace(finest.times, purse) || !found.fine.trace(finest.times, purse))
    return std::nullopt;
  for (std::size_t factor = 4; factor <= most; factor *= 2) {
    const EndTraces& own = found.fine.traces;
    const double nearest = std::min(largest_difference(finest.own_limit()->run.traces, own),
                                    largest_difference(finest.scheme_limit()->run.traces, own));
    Run finer{own_motion_case(study, factor * elements)};
    if (above * largest_difference(found.half.traces, own) < nearest ||
        !purse.allows(3.0 * runs * found.fine.seconds, false) || !finer.trace(finest.times, purse))
      break;
    found.half = std::exchange(found.fine, std::move(finer));
  }
  return found;
}

}  // namespace

std::optional<OwnMotion> own_motion_of(const LimitStudy& study, const LimitResult& result,
                                       std::span<const MeshRuns> meshes, Purse& purse) {
  const auto known = [](const MeshRuns& mesh) { return mesh.own_limit() && mesh.scheme_limit(); };
  if (meshes.size() < 3 || !std::ranges::all_of(meshes, known)) return std::nullopt;
  const std::size_t finest = static_cast<std::size_t>(
      std::ranges::max_element(result.orders, {}, &LimitOrders::elements) - result.orders.begin());
  OwnMotion motion;
  std::optional<Reference> found = reference_of(study, result.orders[finest].elements, meshes[finest], purse);
  if (!found) return std::nullopt;
  auto& [half, fine] = *found;
  motion.reference = fine.run.method == MethodName::characteristics
                         ? "characteristics"
                         : "the mass fourth_order on " + std::to_string(fine.run.elements) + " elements";
  Sequence penalty, scheme, apart;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const MeshRuns& mesh = meshes[m];
    const LimitOrders& orders = result.orders[m];
    if (!fine.trace(mesh.times, purse) || !half.trace(mesh.times, purse)) return std::nullopt;
    motion.error = std::max(motion.error, largest_difference(fine.traces, half.traces));
    OwnMotion::Mesh& row = motion.meshes.emplace_back();
    row.elements = orders.elements;
    row.spacing = study.scene.scene.bar.length / static_cast<double>(orders.elements);
    row.penalty = largest_difference(mesh.own_limit()->run.traces, fine.traces);
    row.scheme = largest_difference(mesh.scheme_limit()->run.traces, fine.traces);
    row.apart = orders.evidence.apart.value_or(0.0);
    Sequence epsilons, steps;
    for (const LimitRow& at : std::span(result.rows).subspan(orders.first_row, orders.row_count))
      epsilons.add(at.epsilon, at.difference_to_own_limit.value_or(0.0), 0.0);
    for (const SchemeRun& at : orders.scheme) steps.add(at.step, at.distance.value_or(0.0), 0.0);
    row.epsilon = epsilons.where(row.penalty);
    row.step = steps.where(row.scheme);
  }
  std::ranges::sort(motion.meshes, {}, &OwnMotion::Mesh::elements);
  for (const OwnMotion::Mesh& row : motion.meshes) {
    penalty.add(row.spacing, row.penalty, motion.error);
    scheme.add(row.spacing, row.scheme, motion.error);
    apart.add(row.spacing, row.apart, 0.0);
  }
  motion.penalty = penalty.order();
  motion.scheme = scheme.order();
  motion.apart = apart.order();
  return motion;
}

}  // namespace viscobar::limit
