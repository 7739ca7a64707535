#include "viscobar/studies/limit/coupling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "case/massless.hpp"
#include "studies/limit/mesh_runs.hpp"
#include "studies/parallel.hpp"

namespace viscobar {

namespace {

constexpr double lowest_order = 0.1, highest_order = 4.0;

/// The case whose solution the penalised ones tend to.
Case limit_case(const LimitStudy& study, const LimitOrders& orders, bool rigid) {
  Case run = study.scene;
  run.elements = orders.elements;
  run.mass = common_mass(run);
  run.method = rigid ? MethodName::rigid : MethodName::fully_discrete;
  run.step = orders.scheme_step;
  run.tolerance = run.tolerance.with_relative(std::min(run.tolerance.relative, 1e-10));
  return run;
}

CouplingResult no(std::string reason) { return {std::nullopt, std::move(reason)}; }

}  // namespace

std::optional<MeshError> mesh_error(const std::vector<double>& spacings, const std::vector<double>& differences) {
  const std::size_t n = differences.size();
  if (n < 2) return std::nullopt;
  const auto order = power_of_changes(spacings[n - 2] / spacings[n - 1], spacings[n - 1] / spacings[n],
                                      differences[n - 2], differences[n - 1]);
  if (!order || *order < lowest_order || *order > highest_order) return std::nullopt;
  return MeshError{*order, differences[n - 1] / (std::pow(spacings[n - 1], *order) - std::pow(spacings[n], *order))};
}

CouplingResult balance_errors(const LimitStudy& asked, const LimitResult& result) {
  const LimitStudy study = limit::by_one_factor(asked);
  if (result.orders.size() < 3)
    return no("the error of the mesh and its order need three meshes or more (--elements 27,54,108)");
  std::vector<std::size_t> by_mesh(result.orders.size());
  std::iota(by_mesh.begin(), by_mesh.end(), std::size_t{0});
  std::ranges::sort(by_mesh, {}, [&](std::size_t i) { return result.orders[i].elements; });
  const bool rigid = are_massless(study.scene.scene, common_mass(study.scene));
  for (const LimitOrders& orders : result.orders)
    if (!rigid && orders.verdict == Verdict::plateau)
      return no(fmt::format("on {} elements the difference has a plateau, so no epsilon balances it", orders.elements));

  std::vector<limit::Run> limits;
  for (const std::size_t i : by_mesh) limits.push_back({limit_case(study, result.orders[i], rigid)});
  constexpr int intervals = 2000;
  std::vector<double> times;
  for (int k = 0; k <= intervals; ++k) times.push_back(study.scene.end * k / intervals);
  limit::Purse purse(study);
  parallel_for(
      limits.size(), [&](std::size_t i) { limits[i].trace(times, purse); }, study.threads);
  for (const limit::Run& run : limits) {
    if (run.error) throw *run.error;
    if (!run.complete)
      return no(purse.interrupted() ? "it was interrupted" : "the runs of the limits take longer than the budget");
  }

  std::vector<double> spacings, differences;
  for (std::size_t i = 0; i < by_mesh.size(); ++i) {
    spacings.push_back(limits[i].run.mesh().spacing());
    if (i == 0) continue;
    if (limits[i].run.elements == limits[i - 1].run.elements) return no("two of the meshes are the same");
    const double difference = largest_difference(limits[i - 1].traces, limits[i].traces);
    const LimitOrders &coarse = result.orders[by_mesh[i - 1]], &fine = result.orders[by_mesh[i]];
    const double noise =
        rigid ? coarse.tolerance_error + fine.tolerance_error : coarse.scheme_error + fine.scheme_error;
    if (!(difference > 3.0 * noise))
      return no(
          fmt::format("meshes of {} and {} elements differ by {:.2g}, too little beside {:.2g} of the time "
                      "integration",
                      coarse.elements, fine.elements, difference, noise));
    differences.push_back(difference);
  }
  const double finest = spacings.back(), scale = differences.back();
  std::vector<double> sizes, parts;  // beside those of the finest mesh, so that no unit is raised to a power
  for (const double h : spacings) sizes.push_back(h / finest);
  for (const double difference : differences) parts.push_back(difference / scale);
  const std::optional<MeshError> error = mesh_error(sizes, parts);
  if (!error)
    return no(fmt::format("from mesh to mesh the limits differ by {:.2g}, which is no power of h",
                          fmt::join(differences, ", ")));

  Coupling coupling;
  coupling.mesh_order = error->order;
  coupling.limit = rigid ? "rigid" : "scheme";
  std::vector<double> h, epsilon;
  for (std::size_t i = 0; i < by_mesh.size(); ++i) {
    const LimitOrders& orders = result.orders[by_mesh[i]];
    Coupling::Mesh mesh{
        orders.elements, spacings[i], scale * error->constant * std::pow(sizes[i], error->order), {}, 0.0};
    Sequence distances;
    for (const LimitRow& row : std::span(result.rows).subspan(orders.first_row, orders.row_count))
      distances.add(row.epsilon, rigid ? *row.difference_to_scheme_limit : row.difference_to_scheme,
                    rigid ? orders.tolerance_error : orders.scheme_error);
    if (const auto row = distances.around(mesh.mesh_error)) {
      mesh.epsilon = distances.where(mesh.mesh_error);
      mesh.local_order = *distances.power(*row);
      h.push_back(mesh.spacing);
      epsilon.push_back(*mesh.epsilon);
    }
    coupling.meshes.push_back(mesh);
  }
  if (epsilon.empty())
    return no(
        fmt::format("the mesh error, {:.2g} to {:.2g}, lies outside the differences of the study; another range "
                    "of epsilon may enclose it",
                    coupling.meshes.back().mesh_error, coupling.meshes.front().mesh_error));
  coupling.law = observed_order(h, epsilon);
  return {coupling, {}};
}

}  // namespace viscobar
