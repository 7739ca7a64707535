#include "viscobar/studies/limit/limit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

#include "studies/limit/mesh_runs.hpp"

namespace viscobar {

using namespace limit;

std::vector<double> decades(double first, double last, std::size_t per_decade) {
  std::vector<double> values;
  const double count = std::round(std::log10(first / last) * static_cast<double>(per_decade));
  for (double k = 0.0; k <= count; ++k) values.push_back(first * std::pow(10.0, -k / static_cast<double>(per_decade)));
  return values;
}

std::vector<double> natural_penalties(const Scene& scene, std::size_t per_decade) {
  const double unit = natural_epsilon(scene);
  return decades(1e-2 * unit, 1e-8 * unit, per_decade);
}

namespace {

void tabulate(const MeshRuns& mesh, LimitResult& result) {
  for (const Run& penalised : mesh.penalised) {
    if (penalised.error) {
      result.failed.push_back({*penalised.run.epsilon, penalised.run.elements, penalised.error->what()});
    } else if (!penalised.complete) {
      result.left_out.push_back(*penalised.run.epsilon);
    } else {
      LimitRow row = row_of(mesh, penalised);
      if (!mesh.scheme.empty())
        row.difference_to_scheme = largest_difference(penalised.traces, mesh.scheme.back().traces);
      result.rows.push_back(row);
    }
  }
}

// A range that settles above theory's boundary of the regimes, and is not the one of small penalties.
std::optional<SequenceOrder> of_layer(const Sequence& sequence, const std::optional<double>& boundary) {
  if (!boundary) return std::nullopt;
  for (const SequenceOrder& range : sequence.settled())
    if (sequence.x[range.first] * sequence.x[range.last] > *boundary * *boundary && range.order < 0.85) return range;
  return std::nullopt;
}

// The order of small penalties: it has come well below the boundary.
std::optional<SequenceOrder> of_node(const Sequence& sequence, const std::optional<double>& boundary) {
  const auto found = sequence.order();
  return found && boundary && sequence.x[found->last] > part_of_boundary * *boundary ? std::nullopt : found;
}

LimitOrders orders_of(const MeshRuns& mesh, std::span<const LimitRow> rows) {
  LimitOrders orders;
  const Case& any = mesh.penalised.front().run;
  orders.elements = any.elements;
  orders.tolerance = any.tolerance.relative;
  orders.tolerance_error = tolerance_error(mesh);
  orders.verdict = mesh.judgement.verdict;
  orders.evidence = mesh.judgement.evidence;
  orders.lacking_seconds = mesh.lacking_seconds;
  orders.scheme_error = mesh.judgement.scheme_error;
  const KnownLimit *own = mesh.own_limit(), *other = mesh.scheme_limit();
  const double own_error = own ? own->error() : 0.0, other_error = other ? other->error() : 0.0;
  Sequence steps;
  for (std::size_t i = 0; i < mesh.scheme.size(); ++i) {
    const Run& run = mesh.scheme[i];
    SchemeRun& row = orders.scheme.emplace_back();
    row.step = *run.run.step;
    row.change = i > 0 ? largest_difference(run.traces, mesh.scheme[i - 1].traces) : 0.0;
    if (other) row.distance = largest_difference(run.traces, other->run.traces);
    row.events = run.traces.events.size();
    row.seconds = run.seconds;
    for (const Run& penalised : mesh.penalised)
      if (penalised.complete) row.differences.push_back(largest_difference(penalised.traces, run.traces));
    if (other) steps.add(row.step, *row.distance, other_error);
    orders.largest = std::max(orders.largest, largest_displacement(run.traces));
  }
  orders.of_step = steps.order();
  if (!mesh.scheme.empty()) {
    orders.scheme_step = mesh.step();
    orders.scheme_events = mesh.scheme.back().traces.events.size();
  }
  orders.boundary = boundary_of(any);
  Sequence penetration, to_scheme_limit, to_scheme, to_own;
  const double s = orders.evidence.scheme_error.value_or(orders.scheme_error);
  for (const LimitRow& row : rows) {
    penetration.add(row.epsilon, row.max_penetration, 0.01 * orders.tolerance_error);
    to_scheme.add(row.epsilon, row.difference_to_scheme, s);
    if (other)
      to_scheme_limit.add(row.epsilon, *row.difference_to_scheme_limit, other_error + 0.1 * orders.tolerance_error);
    if (own) to_own.add(row.epsilon, *row.difference_to_own_limit, own_error + 0.1 * orders.tolerance_error);
  }
  // Chatter that is out of step with the limit has powers of its own, and two of them may agree by chance.
  const auto in_step = [&](const std::optional<SequenceOrder>& order) {
    const bool few = order && order->last - order->first == 2;
    return few && rows[order->first].events != rows[order->last].events ? std::nullopt : order;
  };
  orders.penetration = of_node(penetration, orders.boundary);
  orders.to_own_limit = in_step(of_node(to_own, orders.boundary));
  // Differences that stop at a plateau have no order.
  if (orders.verdict != Verdict::plateau) {
    orders.to_scheme_limit = in_step(of_node(to_scheme_limit, orders.boundary));
    orders.to_scheme = own ? to_scheme.order_within(orders.to_own_limit) : of_node(to_scheme, orders.boundary);
  }
  if (mesh.magnifies) orders.to_own_limit = orders.to_scheme_limit = orders.to_scheme = orders.of_step = std::nullopt;
  if (!any.scene.span) {
    orders.penetration_layer = of_layer(penetration, orders.boundary);
    orders.to_scheme_limit_layer = of_layer(to_scheme_limit, orders.boundary);
  }
  return orders;
}

}  // namespace

std::optional<Finding> limit_fault(const Scene& scene) {
  const auto of_stop = [](const std::optional<Stop>& stop, const std::string& where) -> std::optional<Finding> {
    if (!stop) return std::nullopt;
    return Finding{stop->key(where, "law"),
                   "limit studies the penalty, and this stop has a law of its own, which is no limit's; leave the law "
                   "out"};
  };
  if (auto left = of_stop(scene.left_input.stop, "left")) return left;
  if (auto right = of_stop(scene.right_input.stop, "right")) return right;
  for (std::size_t k = 1; k < scene.chain.size(); ++k)
    if (auto joint = of_stop(scene.chain[k - 1].joint.stop, fmt::format("joint.{}", k))) return joint;
  if (!meets_obstacle(scene)) return Finding{"", "the scene has no obstacle, so there is nothing to penalise"};
  return std::nullopt;
}

LimitResult limit_of(const LimitStudy& asked) {
  const LimitStudy study = by_one_factor(asked);
  if (const auto fault = limit_fault(study.scene.scene)) throw std::invalid_argument(fault->problem);
  if (study.epsilons.empty()) throw std::invalid_argument("a limit study needs at least one epsilon");
  const std::vector<std::size_t> meshes =
      study.elements.empty() ? std::vector<std::size_t>{study.scene.elements} : study.elements;
  if (!study.steps.empty() && study.steps.size() != meshes.size())
    throw std::invalid_argument("one scheme step is needed for each mesh");

  Purse purse(study);
  LimitResult result;
  std::vector<MeshRuns> runs;
  runs.reserve(meshes.size());
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    Case probe = study.scene;
    probe.elements = meshes[m];
    MeshRuns& mesh = runs.emplace_back(
        runs_of(study, meshes[m], study.steps.empty() ? resolve(std::move(probe)).step : study.steps[m], purse));
    decide(mesh, study, purse);
    refine_scheme(mesh, study, purse);
    const std::size_t first = result.rows.size();
    tabulate(mesh, result);
    LimitOrders orders = orders_of(mesh, std::span(result.rows).subspan(first));
    orders.first_row = first;
    orders.row_count = result.rows.size() - first;
    orders.interrupted = purse.interrupted();
    orders.seconds = purse.spent();
    result.orders.push_back(orders);
    mesh.penalised.clear(), mesh.scheme.clear();  // from here on the limits are enough
  }
  result.own_motion = own_motion_of(study, result, runs, purse);
  return result;
}

AccuracyResult limit_to_accuracy(const LimitStudy& study, const AccuracyRequest& request) {
  AccuracyStudy inner;
  inner.scene = study.scene;
  inner.scene.mass = common_mass(study.scene);
  inner.scene.method = MethodName::rigid;
  if (!sound(inner.scene)) inner.scene.method = MethodName::fully_discrete;
  inner.request = request;
  inner.request.given.method = inner.request.given.mass = inner.request.given.restitution = true;
  inner.request.given.tolerance = inner.request.given.step = false;
  inner.threads = study.threads;
  return solve(inner);
}

}  // namespace viscobar
