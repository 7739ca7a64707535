#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "studies/precision/solved.hpp"

namespace viscobar::precision {

namespace {

// Beyond this, dense matrix exponentials take longer than everything else together.
constexpr std::size_t most_exponential_elements = 100;

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
    if (validate(run).empty()) all.push_back(std::move(run));
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
      for (const double coarser : {1.0, 2.0, 4.0}) add(MethodName::fully_discrete, coarser);
      break;
  }
  return all;
}

/// The limit of a scheme from three steps, by the order that they show; its error by what the smallest step changed.
SemiDiscrete limit_of_steps(const std::vector<Case>& runs, std::span<const Mesh> mesh, double seconds) {
  std::vector<Field> fields;
  for (const Case& run : runs) fields.push_back(std::move(fields_of(run, mesh, seconds).front()));
  const double here = distance(fields[0], fields[1]), before = distance(fields[1], fields[2]);
  const double order = here > 0.0 ? std::clamp(std::log2(before / here), 1.0, 2.0) : 2.0;
  SemiDiscrete result;
  result.field = extrapolated(fields[0], fields[1], std::exp2(order));
  result.error = distance(*result.field, extrapolated(fields[1], fields[2], std::exp2(order)));
  result.what =
      fmt::format("{0} extrapolated from steps {1:.3g}, 2 and 4 times that", name(runs[0].method), *runs[0].step);
  return result;
}

}  // namespace

System system_of(const Case& run) {
  if (run.method == MethodName::characteristics)
    return {run.elements, effective_mass(run), System::Law::continuous, 0.0};
  const BarSystem system = make_system(run);
  System::Law law = System::Law::penalised;
  if (!system.contacts().empty() && !is_penalised(run.method))
    law = system.has_massless() || run.method == MethodName::rigid ? System::Law::rigid : System::Law::impact;
  const bool penalised = !system.contacts().empty() && law == System::Law::penalised;
  return {run.elements, system.mass(), law, penalised ? effective_epsilon(run) : 0.0};
}

SemiDiscrete solve_in_time(const Case& scene, const System& system, const Fineness& fineness, double seconds) {
  SemiDiscrete result;
  if (system.law == System::Law::continuous) {
    result.problem = "the method has no mesh";
    return result;
  }
  std::string problems;
  Mesh mesh = scene.mesh();
  mesh.elements = system.elements;
  const std::vector<Case> runs = routes(scene, system, fineness);
  if (system.law == System::Law::impact) {
    try {
      return limit_of_steps(runs, std::span(&mesh, 1), seconds);
    } catch (const std::exception& error) {
      result.problem = fmt::format("{}: {}", described(runs.front()), error.what());
      return result;
    }
  }
  for (const Case& run : runs) {
    try {
      Field field = std::move(fields_of(run, std::span(&mesh, 1), seconds).front());
      if (result.field) {
        result.error = distance(*result.field, field);
        result.what += fmt::format(", checked by {}", described(run));
        return result;
      }
      result.what = described(run);
      result.field = std::move(field);
    } catch (const std::exception& error) {
      problems += fmt::format("{}{}: {}", problems.empty() ? "" : "; ", described(run), error.what());
      // The others would take as long, but for those that a dense exponential was too slow for.
      if (dynamic_cast<const TooLong*>(&error) && run.method != MethodName::exponential) break;
    }
  }
  // What nothing has checked is no reference.
  result.field.reset();
  result.problem = problems.empty() ? "no method gives it" : problems;
  return result;
}

}  // namespace viscobar::precision
