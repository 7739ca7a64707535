#include "studies/precision/solved.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/pieces.hpp"
#include "viscobar/studies/orders/observed_order.hpp"

namespace viscobar::precision {

void interpolate(const Mesh& from, std::span<const double> u, const Mesh& to, std::span<double> out) {
  for (std::size_t j = 0; j < to.nodes(); ++j) {
    const std::size_t scaled = j * from.elements, element = scaled / to.elements, rest = scaled % to.elements;
    out[j] = u[element];
    if (rest == 0) continue;
    if (from.uniform())
      out[j] += (u[element + 1] - u[element]) * static_cast<double>(rest) / static_cast<double>(to.elements);
    else
      out[j] += (u[element + 1] - u[element]) * (to.node(j) - from.node(element)) / from.element(element);
  }
}

std::vector<Field> fields_of(const Case& run, std::span<const Mesh> meshes, const RunLimits& limits, Statistics* done) {
  std::vector<Field> fields;
  for (const Mesh& mesh : meshes) fields.push_back({mesh, {}});
  const std::vector<Piece> own = pieces_of(run.scene, run.mesh());
  std::vector<std::vector<Piece>> pieces;
  for (const Mesh& mesh : meshes) pieces.push_back(pieces_of(run.scene, mesh));
  Observers observers;
  observers.off_the_clock = false;
  observers.snapshot = [&](const Snapshot& now) {
    for (std::size_t m = 0; m < fields.size(); ++m) {
      std::vector<double>& u = fields[m].u;
      const std::size_t begin = u.size();
      u.resize(begin + fields[m].mesh.nodes());
      for (std::size_t p = 0; p < own.size(); ++p) {
        const Piece &from = own[p], &to = pieces[m][p];
        if (to.rigid())
          u[begin + to.first] = now.u[from.first];
        else
          interpolate(from.mesh, now.u.subspan(from.first, from.mesh.nodes()), to.mesh,
                      std::span(u).subspan(begin + to.first, to.mesh.nodes()));
      }
    }
  };
  const Setup setup = resolve(run);
  const Statistics statistics = simulate_within(limits, setup, setup.system(), observers);
  if (done) *done = statistics;
  return fields;
}

Field field_of(const SpaceTimeFunction& u, const Mesh& mesh, std::span<const double> times) {
  Field field{mesh, {}};
  field.u.reserve(times.size() * mesh.nodes());
  for (const double t : times)
    for (std::size_t j = 0; j < mesh.nodes(); ++j) field.u.push_back(u(mesh.node(j), t));
  return field;
}

double largest_difference(const Field& a, const Field& b) {
  const std::size_t start = a.mesh.nodes();
  return viscobar::largest_difference(std::span(a.u).subspan(start), std::span(b.u).subspan(start));
}

Field extrapolated(const Field& fine, const Field& coarse, double ratio) {
  Field result = fine;
  for (std::size_t i = 0; i < result.u.size(); ++i) result.u[i] += (fine.u[i] - coarse.u[i]) / (ratio - 1.0);
  return result;
}

namespace {

std::string described(const Case& run) {
  if (is_scheme(run.method)) return fmt::format("{} at step {:.3g}", name(run.method), *run.step);
  if (is_adaptive(run.method)) return fmt::format("{} at tolerance {:.3g}", name(run.method), run.tolerance.relative);
  return std::string(name(run.method));
}

/// Ways to solve the system, the best first. Two neighbours differ in method or in fineness.
std::vector<Case> routes(const Case& scene, const System& system, const Fineness& fineness) {
  Case base = scene;
  base.elements = system.elements;
  base.mass = system.mass;
  if (system.epsilon > 0.0) base.epsilon = system.epsilon;
  std::vector<Case> all;
  const auto add = [&](MethodName method, double coarser) {
    Case run = base;
    run.method = method;
    run.tolerance = run.tolerance.with_relative(coarser * fineness.tolerance);
    if (is_scheme(method)) run.step = coarser * fineness.step;
    if (sound(run)) all.push_back(std::move(run));
  };
  switch (system.law) {
    case System::Law::penalised:
      if (system.elements <= most_exponential_elements) add(MethodName::exponential, 1.0);
      for (const MethodName method : {MethodName::cvode, MethodName::ida})
        for (const double coarser : {1.0, 10.0}) add(method, coarser);
      break;
    case System::Law::rigid:
      for (const double coarser : {1.0, 10.0}) add(MethodName::rigid, coarser);
      break;
    case System::Law::continuous: break;
    case System::Law::impact:
      for (const double coarser : {1.0, 2.0, 4.0, 8.0}) add(MethodName::fully_discrete, coarser);
      break;
  }
  return all;
}

/// The limit of a scheme from four steps. Where their changes settle to an order it is extrapolated, and its error is
/// what the smallest step changed of that; elsewhere it is the run at that step, off by as much again, as of order 1.
SemiDiscrete limit_of_steps(const std::vector<Case>& runs, const Mesh& mesh, const RunLimits& limits) {
  std::vector<Field> fields;
  for (const Case& run : runs) fields.push_back(field_of(run, mesh, limits));
  Sequence changes;
  changes.within = Sequence::by_few;
  for (std::size_t i = fields.size(); i-- > 1;)
    changes.add(*runs[i].step, largest_difference(fields[i - 1], fields[i]), 0.0);
  SemiDiscrete result;
  if (const auto order = changes.order()) {
    const double ratio = std::exp2(std::clamp(order->order, 1.0, 2.0));
    result.field = extrapolated(fields[0], fields[1], ratio);
    result.error = largest_difference(*result.field, extrapolated(fields[1], fields[2], ratio));
    result.what =
        fmt::format("{0} extrapolated from steps {1:.3g}, 2 and 4 times that", name(runs[0].method), *runs[0].step);
  } else {
    result.field = fields[0];
    result.error = changes.distance.back();
    result.what = fmt::format("{0} at step {1:.3g}, for its order is not settled", name(runs[0].method), *runs[0].step);
  }
  return result;
}

}  // namespace

System system_of(const Setup& setup) {
  const Case& run = setup.run;
  if (run.method == MethodName::characteristics) return {run.elements, setup.mass, System::Law::continuous, 0.0};
  const BarSystem system = setup.system();
  System::Law law = System::Law::penalised;
  if (!system.contacts().empty() && !is_penalised(run.method))
    law = system.inertia().has_massless() || run.method == MethodName::rigid ? System::Law::rigid : System::Law::impact;
  const bool penalised = has_penalty(run.scene) && law == System::Law::penalised;
  return {run.elements, system.mass(), law, penalised ? setup.epsilon : 0.0};
}

SemiDiscrete solve_in_time(const Case& scene, const System& system, const Fineness& fineness, const RunLimits& limits) {
  SemiDiscrete result;
  if (system.law == System::Law::continuous) {
    result.problem = "the method has no mesh";
    return result;
  }
  const Mesh mesh = mesh_of(scene, system.elements);
  const std::vector<Case> runs = routes(scene, system, fineness);
  const auto fail = [&](const Case& run, const std::exception& error) {
    result.problem += fmt::format("{}{}: {}", result.problem.empty() ? "" : "; ", described(run), error.what());
  };
  if (system.law == System::Law::impact) {
    try {
      return limit_of_steps(runs, mesh, limits);
    } catch (const std::exception& error) {
      fail(runs.front(), error);
      return result;
    }
  }
  for (const Case& run : runs) {
    try {
      Field field = field_of(run, mesh, limits);
      if (result.field) {
        result.error = largest_difference(*result.field, field);
        result.what += fmt::format(", checked by {}", described(run));
        result.problem.clear();
        return result;
      }
      result.what = described(run);
      result.field = std::move(field);
    } catch (const std::exception& error) {
      fail(run, error);
      // The others would take as long, but for those that a dense exponential was too slow for.
      if (dynamic_cast<const TooLong*>(&error) && run.method != MethodName::exponential) break;
    }
  }
  // A solution that no other run has checked is no reference.
  result.field.reset();
  if (result.problem.empty()) result.problem = "no method gives it";
  return result;
}

}  // namespace viscobar::precision
