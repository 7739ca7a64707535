#include "viscobar/case/case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>

#include "case/method_table.hpp"
#include "dynamics/natural_scales.hpp"

namespace viscobar {

std::string_view name(MethodName method) { return method_row(method).name; }

bool is_scheme(MethodName method) { return method_row(method).accuracy == Accuracy::step; }

bool is_penalised(MethodName method) { return method_row(method).penalised; }

bool is_adaptive(MethodName method) { return method_row(method).accuracy == Accuracy::tolerances; }

Mesh Case::mesh() const {
  if (scene.chain.empty())
    return {scene.bar.length, elements, {grading, is_obstacle(scene.left), is_obstacle(scene.right)}, nodes, {}};
  std::size_t sum = 0;
  for (const Mesh& own : bar_meshes) sum += own.elements;
  std::vector<Mesh> members = bar_meshes;
  std::vector<double> places{0.0};
  double begin = 0.0;
  for (std::size_t m = 0; m < members.size(); ++m) {
    Mesh& own = members[m];
    own.length = scene.chain[m].bar.length;
    if (m > 0 && scene.chain[m - 1].joint.kind != JointKind::bonded) places.push_back(places.back());
    if (scene.chain[m].rigid()) continue;
    own.grading.left = meets_contact(scene, m, false), own.grading.right = meets_contact(scene, m, true);
    if (sum != elements)
      own.elements = std::max<std::size_t>(1, std::llround(static_cast<double>(own.elements) *
                                                           static_cast<double>(elements) / static_cast<double>(sum)));
    for (std::size_t j = 1; j <= own.elements; ++j) places.push_back((begin + own.node(j)) / scene.bar.length);
    begin += own.length;
  }
  return {scene.bar.length,
          places.size() - 1,
          {},
          std::make_shared<const std::vector<double>>(std::move(places)),
          std::make_shared<const std::vector<Mesh>>(std::move(members))};
}

std::vector<double> Case::output_times() const {
  std::vector<double> times;
  // A multiple of `every` that misses the end by rounding only is the end.
  const auto count = static_cast<std::size_t>(std::ceil(end / output_every * (1.0 - 1e-12)));
  times.reserve(count + 1);
  for (std::size_t k = 0; k < count; ++k) times.push_back(static_cast<double>(k) * output_every);
  times.push_back(end);
  return times;
}

namespace {

Statistics simulate_from(const StartingPoint& start, const Setup& setup, const BarSystem& system,
                         std::span<const double> times, const Observers& observers) {
  const Case& run = setup.run;
  try {
    if (const auto* state = std::get_if<State>(&start))
      if (const auto words = too_small(*state, system, run.end)) throw IntegrationError(Failure::overflow, *words, {});
    const auto integrated = [&](const auto& method) {
      if constexpr (std::is_same_v<decltype(method), const Characteristics&>) {
        const auto* checkpoint = std::get_if<Checkpoint>(&start);
        const auto from = checkpoint ? std::optional(*checkpoint) : std::nullopt;
        return integrate(run.scene, setup.mesh, from, times, method, observers);
      } else {
        return integrate(system, start, times, method, observers);
      }
    };
    return std::visit(integrated, setup.method);
  } catch (const IntegrationError& error) {
    throw IntegrationError(error.failure, fmt::format("{}; {}", error.what(), remedy(run, error.failure)),
                           error.statistics);
  }
}

}  // namespace

Statistics simulate(const Setup& setup, const BarSystem& system, const Observers& observers) {
  return simulate_from(system.initial_state(), setup, system, setup.run.output_times(), observers);
}

Statistics simulate(const Setup& setup, const BarSystem& system, std::span<const double> times,
                    const Observers& observers) {
  return simulate_from(system.initial_state(), setup, system, times, observers);
}

Statistics simulate(const Setup& setup, const BarSystem& system, const Checkpoint& from, const Observers& observers) {
  return simulate_from(from, setup, system, setup.run.output_times(), observers);
}

}  // namespace viscobar
