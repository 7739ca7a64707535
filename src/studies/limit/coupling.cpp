#include "viscobar/studies/limit/coupling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "studies/parallel.hpp"
#include "viscobar/case/recording.hpp"

namespace viscobar {

namespace {

constexpr double lowest_order = 0.1, highest_order = 4.0;

/// The case whose solution the penalised ones tend to, with the output times of the study.
Case limit_case(const LimitStudy& study, const LimitOrders& orders, bool rigid) {
  Case run = study.scene;
  run.directions.clear();
  run.elements = orders.elements;
  run.mass = common_mass(run);
  run.method = rigid ? MethodName::rigid : MethodName::fully_discrete;
  run.step = orders.scheme_step;
  run.tolerance = run.tolerance.with_relative(std::min(run.tolerance.relative, 1e-10));
  run.output_every = run.end / 2000.0;
  return run;
}

double largest_end_difference(const Recording& a, const Recording& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.times.size(); ++k) {
    const auto u = a.displacement(k), v = b.displacement(k);
    largest = std::max({largest, std::abs(u.front() - v.front()), std::abs(u.back() - v.back())});
  }
  return largest;
}

/// Where the difference, falling with epsilon, equals `level`: epsilon and the local power.
struct Crossing {
  double epsilon, order;
};
std::optional<Crossing> crossing(std::span<const LimitRow> rows, bool rigid, double level, double floor) {
  const auto value = [&](const LimitRow& row) { return rigid ? *row.difference_to_rigid : row.difference_to_scheme; };
  for (std::size_t k = 0; k + 1 < rows.size(); ++k) {
    const double above = value(rows[k]), below = value(rows[k + 1]);
    if (!(above >= level && level >= below && above > below && below > floor)) continue;
    const double order = std::log(above / below) / std::log(rows[k].epsilon / rows[k + 1].epsilon);
    return Crossing{rows[k].epsilon * std::pow(level / above, 1.0 / order), order};
  }
  return std::nullopt;
}

CouplingResult no(std::string reason) { return {std::nullopt, std::move(reason)}; }

}  // namespace

std::optional<MeshError> mesh_error(const std::vector<double>& spacings, const std::vector<double>& differences) {
  if (differences.size() < 2) return std::nullopt;
  const auto n = static_cast<double>(differences.size());
  std::optional<MeshError> best;
  double least = std::numeric_limits<double>::infinity();
  constexpr int candidates = 3900;
  int best_index = 0;
  for (int i = 0; i <= candidates; ++i) {
    const double q = lowest_order + (highest_order - lowest_order) * i / candidates;
    double sum = 0.0, squares = 0.0;
    for (std::size_t k = 0; k < differences.size(); ++k) {
      const double ratio = std::log(differences[k] / (std::pow(spacings[k], q) - std::pow(spacings[k + 1], q)));
      sum += ratio;
      squares += ratio * ratio;
    }
    const double scatter = squares / n - sum * sum / (n * n);
    if (!(scatter < least)) continue;
    least = scatter;
    best = MeshError{q, std::exp(sum / n)};
    best_index = i;
  }
  // At a border of the range the data have no power in it.
  if (best_index == 0 || best_index == candidates) return std::nullopt;
  return best;
}

CouplingResult balance_errors(const LimitStudy& study, const LimitResult& result) {
  if (result.orders.size() < 3)
    return no("the error of the mesh and its order need three meshes or more (--elements 27,54,108)");
  std::vector<std::size_t> by_mesh(result.orders.size());
  std::iota(by_mesh.begin(), by_mesh.end(), std::size_t{0});
  std::ranges::sort(by_mesh, {}, [&](std::size_t i) { return result.orders[i].elements; });
  const bool rigid = common_mass(study.scene) == Mass::redistributed;
  for (const LimitOrders& orders : result.orders)
    if (!rigid && orders.verdict == Verdict::plateau)
      return no(fmt::format("on {} elements the difference has a plateau, so no epsilon balances it", orders.elements));

  std::vector<Recording> limits(by_mesh.size());
  parallel_for(
      by_mesh.size(), [&](std::size_t i) { limits[i] = record(limit_case(study, result.orders[by_mesh[i]], rigid)); },
      study.threads);

  std::vector<double> spacings, differences;
  for (std::size_t i = 0; i < by_mesh.size(); ++i) {
    spacings.push_back(limits[i].mesh.spacing());
    if (i == 0) continue;
    if (limits[i].mesh.elements == limits[i - 1].mesh.elements) return no("two of the meshes are the same");
    const double difference = largest_end_difference(limits[i - 1], limits[i]);
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
    const auto rows = std::span(result.rows).subspan(orders.first_row, orders.row_count);
    if (const auto found =
            crossing(rows, rigid, mesh.mesh_error, rigid ? orders.tolerance_error : orders.scheme_error)) {
      mesh.epsilon = found->epsilon;
      mesh.local_order = found->order;
      h.push_back(mesh.spacing);
      epsilon.push_back(found->epsilon);
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
