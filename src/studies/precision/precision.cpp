#include "viscobar/studies/precision/precision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "studies/accuracy/sample.hpp"
#include "studies/parallel.hpp"
#include "studies/precision/references.hpp"

namespace viscobar {

namespace {

using namespace precision;

/// Errors are taken at the ends of equal parts of the run, whatever its output times are: those at which an estimate of
/// a run looks, and up to seven between, for an impact on a stiff penalty is short; fewer where fields would fill the
/// memory.
double error_interval(const Case& scene, const std::vector<Mesh>& meshes) {
  constexpr double most_times = 16'000.0;  // of one node
  std::size_t nodes = 0;
  for (const Mesh& mesh : meshes) nodes = std::max(nodes, mesh.nodes());
  const auto parts = static_cast<double>(accuracy::times_of_errors(scene.end).size() - 1);
  return scene.end / (parts * std::clamp(std::floor(most_times / static_cast<double>(nodes)), 1.0, 8.0));
}

std::vector<Timed> timed_rows(const PrecisionStudy& study, const Case& scene, const std::vector<std::size_t>& counts,
                              PrecisionResult& result) {
  Spent spent;
  std::vector<MethodName> methods = study.methods;
  if (methods.empty())
    std::copy_if(std::begin(all_methods), std::end(all_methods), std::back_inserter(methods),
                 [](MethodName method) { return is_scheme(method) || is_adaptive(method); });
  std::vector<Timed> all;
  for (const std::size_t count : counts)
    for (const MethodName method : methods) {
      Case run = scene;
      run.elements = count;
      run.method = method;
      if (const auto reason = fault_in_words(resolve(run))) {
        if (!study.methods.empty())
          throw std::invalid_argument(fmt::format("{} does not fit the scene: {}", name(method), *reason));
        result.left_out.push_back({method, count, "", *reason});
        continue;
      }
      std::vector<Timed> rows = settings_of(study, run);
      time_rows(study, rows, result.left_out, spent);
      std::move(rows.begin(), rows.end(), std::back_inserter(all));
    }
  if (spent.wall > 0.0) result.core_share = std::min(1.0, spent.processor / spent.wall);
  if (!all.empty()) return all;
  std::string text = "no method has a run to show";
  for (const auto& [method, elements, what, reason] : result.left_out)
    text += fmt::format("\n  {} on {} elements: {}", name(method), elements, reason);
  throw std::invalid_argument(text);
}

void measure_errors(const PrecisionStudy& study, Timed& timed, const References& references) {
  PrecisionRow& row = timed.row;
  if (!row.failure.empty()) return;
  const Field* exact = references.exact(timed.run);
  const Field* semi_discrete = references.semi_discrete(timed.run);
  if (exact) row.error = 0.0;
  if (semi_discrete) row.time_error = 0.0;
  std::size_t k = 0;
  Observers observers;
  observers.off_the_clock = false;
  observers.snapshot = [&](const Snapshot& now) {
    if (k > 0 && exact) row.error = std::max(*row.error, largest_difference(now.u, exact->at(k)));
    if (k > 0 && semi_discrete)
      row.time_error = std::max(*row.time_error, largest_difference(now.u, semi_discrete->at(k)));
    ++k;
  };
  try {
    const Setup setup = resolve(timed.run);
    simulate_within({.stop = study.stop}, setup, setup.system(), observers);
  } catch (const std::exception& failure) {
    row.failure = failure.what();
    row.error = row.time_error = std::nullopt;
  }
}

}  // namespace

const ErrorParts& PrecisionResult::parts_of(const PrecisionRow& row) const {
  return *std::ranges::find_if(
      parts, [&](const ErrorParts& of) { return of.method == row.method && of.elements == row.elements; });
}

PrecisionResult precision_of(const PrecisionStudy& study) {
  Case scene = study.scene;
  std::vector<std::size_t> counts = study.elements.empty() ? std::vector<std::size_t>{scene.elements} : study.elements;
  const auto refined = accuracy::refine_by_one_factor(scene, counts);
  if (!refined)
    throw std::invalid_argument(
        fmt::format("mesh.elements: {} are not all multiples of {}, and bars in line are refined by one factor",
                    fmt::join(counts, ", "), std::ranges::min(counts)));
  counts = *refined;
  std::vector<Mesh> meshes;
  for (const std::size_t count : counts) meshes.push_back(mesh_of(scene, count));
  scene.output_every = error_interval(scene, meshes);

  PrecisionResult result;
  result.times = scene.output_times().size();
  result.every = scene.output_every;
  std::vector<Timed> rows = timed_rows(study, scene, counts, result);
  if (study.progress) study.progress("references");
  const References references(study, scene, meshes, rows);
  if (study.progress) study.progress("errors");
  parallel_for(
      rows.size(), [&](std::size_t i) { measure_errors(study, rows[i], references); }, study.threads);

  for (Timed& timed : rows) {
    const bool same = !result.rows.empty() && result.rows.back().method == timed.row.method &&
                      result.rows.back().elements == timed.row.elements;
    if (!same) result.parts.push_back(references.parts(timed));
    result.rows.push_back(std::move(timed.row));
  }
  result.reference = references.continuous().reference;
  result.no_reference = references.continuous().problem;
  return result;
}

}  // namespace viscobar
