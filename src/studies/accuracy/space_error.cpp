#include "studies/accuracy/space_error.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "viscobar/studies/orders/observed_order.hpp"

namespace viscobar::accuracy {

namespace {

constexpr double agreement = 0.75;  // of orders
constexpr double safety = 1.4;      // of an error that relies on an order
constexpr double least_order = 0.3, least_believable = 1.0, much_faster = 1.5;

double ratio(const MeshStep& step) { return static_cast<double>(step.fine) / static_cast<double>(step.coarse); }

std::optional<double> observed(const MeshStep& first, const MeshStep& second) {
  return power_of_changes(ratio(first), ratio(second), first.distance, second.distance);
}

}  // namespace

double order_in_theory(const Case& run) {
  const double thrown_back = run.restitution.value_or(is_penalised(run.method) ? 1.0 : 0.0);
  if (run.scene.span && (thrown_back > 0.0 || run.scene.bar.viscosity == 0.0)) return 1.0;
  if (resolve(run).mass != Mass::fourth_order || run.scene.span) return 2.0;
  const bool given = run.nodes || std::ranges::any_of(run.bar_meshes, [](const Mesh& own) { return bool(own.given); });
  return given ? 3.0 : 4.0;  // docs/sections.md
}

SpaceError space_error(std::span<const MeshStep> ladder, double theory) {
  SpaceError result;
  result.order = theory;
  if (ladder.empty()) return result;
  const MeshStep& last = ladder.back();
  const double most = std::pow(ratio(last), theory) - 1.0;
  std::optional<double> late, early;
  if (ladder.size() >= 2) late = observed(ladder[ladder.size() - 2], last);
  if (ladder.size() >= 3) early = observed(ladder[ladder.size() - 3], ladder[ladder.size() - 2]);
  if (late) result.order = *late;
  constexpr double same_way = 0.9;
  result.settles = !(late && early && *late <= 0.0 && *early <= 0.0 && last.alignment >= same_way);
  // An order 4 trusted wrongly makes the estimate 15 times too small, an order 2 three times.
  const double least_alignment = theory > 2.0 ? 0.9 : 0.5;
  const bool steady =
      late && last.alignment >= least_alignment && (!early || *late >= std::min(*early, theory) - agreement);
  // An order above that of theory falls to it as meshes get finer: it is relied on where it does not fall yet.
  const double believed = early && late && *late >= *early ? *early : theory;
  const double order = steady ? std::min({*late, early.value_or(*late), believed}) : 0.0;
  const double seen = late ? std::clamp(*late, least_order, theory) : 1.0;
  double apart = last.distance;
  if (late) {
    const MeshStep& before = ladder[ladder.size() - 2];
    apart = std::max(apart, before.distance / fall_of_changes(ratio(before), ratio(last), theory));
  }
  const double q = std::pow(ratio(last), -std::min(seen, 1.0)), c = std::max(last.alignment, 0.0);
  result.error = apart * std::min(q / (1.0 - q), safety * q * std::sqrt((1.0 + c * q) / (1.0 - c * q) / (1.0 - q * q)));
  // Where changes point elsewhere, but not back, half of what is seen above order 1 is believed.
  if (late && last.alignment >= 0.0) {
    const double half = 0.5 * (least_believable + std::min({*late, early.value_or(*late), theory}));
    if (half > least_believable)
      result.error = std::min(result.error, safety * apart / (std::pow(ratio(last), half) - 1.0));
  }
  if (order >= least_believable) {
    const bool explained = *late <= theory + much_faster;
    result.trusted = order;
    result.error = std::min(result.error, (explained ? safety * last.distance : 2.0 * safety * apart) /
                                              (std::pow(ratio(last), order) - 1.0));
  }
  result.effectivity = last.distance > 0.0 ? result.error / (last.distance / most) : 1.0;
  return result;
}

double expected_order(std::span<const MeshStep> ladder, double theory) {
  return ladder.size() < 2 ? 1.0 : std::clamp(space_error(ladder, theory).order, least_order, theory);
}

std::vector<MeshStep> prolonged(std::vector<MeshStep> ladder, std::size_t elements, double order) {
  if (ladder.empty()) return ladder;
  MeshStep next{ladder.back().fine, elements};
  next.distance = ladder.back().distance / fall_of_changes(ratio(ladder.back()), ratio(next), order);
  ladder.push_back(next);
  return ladder;
}

}  // namespace viscobar::accuracy
