#include "viscobar/case/case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "case/method_table.hpp"

namespace viscobar {

std::string_view name(MethodName method) { return method_row(method).name; }

bool is_scheme(MethodName method) { return method_row(method).accuracy == Accuracy::step; }

bool is_penalised(MethodName method) { return method_row(method).penalised; }

bool is_adaptive(MethodName method) { return method_row(method).accuracy == Accuracy::tolerances; }

std::vector<double> Case::output_times() const {
  std::vector<double> times;
  // A multiple of `every` that misses the end by rounding only is the end.
  const auto count = static_cast<std::size_t>(std::ceil(end / output_every * (1.0 - 1e-12)));
  times.reserve(count + 1);
  for (std::size_t k = 0; k < count; ++k) times.push_back(static_cast<double>(k) * output_every);
  times.push_back(end);
  return times;
}

Mass effective_mass(const Case& run) {
  const auto mass = method_row(run.method).mass;
  return mass ? mass(run) : run.mass.value_or(Mass::consistent);
}

Method method_of(const Case& run) { return method_row(run.method).options(run); }

Odeint odeint(const Case& run) {
  return {{run.epsilon, run.restitution.value_or(1.0)}, run.tolerance, run.stepper, run.step};
}

MethodName automatic_method(const Case& run) {
  const bool ends = is_obstacle(run.scene.left) || is_obstacle(run.scene.right);
  if (ends && !run.scene.span && !run.epsilon) return MethodName::rigid;
  const bool massless = ends && run.mass == Mass::redistributed;
  return run.scene.bar.viscosity > 0.0 || massless ? MethodName::arkode : MethodName::cvode;
}

std::string method_words(const Case& run) {
  return std::string(name(run.method)) + (run.automatic ? ", chosen for the scene" : "");
}

MethodName penalised_method(const Case& run) {
  const MethodName method = is_penalised(run.method) ? run.method : MethodName::cvode;
  return has_algebraic_rows(run) && !method_row(method).takes_algebraic_rows ? MethodName::ida : method;
}

BarSystem make_system(const Case& run) { return BarSystem(run.scene, run.mesh(), effective_mass(run)); }

namespace {

Statistics simulate_from(const StartingPoint& start, const Case& run, const BarSystem& system,
                         std::span<const double> times, const Observers& observers) {
  try {
    const auto integrated = [&](const auto& method) {
      if constexpr (std::is_same_v<decltype(method), const Characteristics&>) {
        const auto* checkpoint = std::get_if<Checkpoint>(&start);
        const auto from = checkpoint ? std::optional(*checkpoint) : std::nullopt;
        return integrate(run.scene, run.mesh(), from, times, method, observers);
      } else {
        return integrate(system, start, times, method, observers);
      }
    };
    return std::visit(integrated, method_of(run));
  } catch (const IntegrationError& error) {
    throw IntegrationError(error.failure, fmt::format("{}; {}", error.what(), remedy(run, error.failure)),
                           error.statistics);
  }
}

}  // namespace

Statistics simulate(const Case& run, const BarSystem& system, const Observers& observers) {
  return simulate_from(system.initial_state(), run, system, run.output_times(), observers);
}

Statistics simulate(const Case& run, const BarSystem& system, std::span<const double> times,
                    const Observers& observers) {
  return simulate_from(system.initial_state(), run, system, times, observers);
}

Statistics simulate(const Case& run, const BarSystem& system, const Checkpoint& from, const Observers& observers) {
  return simulate_from(from, run, system, run.output_times(), observers);
}

}  // namespace viscobar
