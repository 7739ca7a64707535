#include "viscobar/case/case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <type_traits>

#include "case/method_table.hpp"
#include "case/regime.hpp"
#include "dynamics/natural_scales.hpp"

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

namespace {

// An end whose spring or dashpot wants its mass.
bool mounts_a_contact(const Scene& scene) {
  const auto mounted = [](const EndCondition& end, const EndInput& input) {
    return is_obstacle(end) && (input.stiffness > 0.0 || input.dashpot > 0.0);
  };
  return mounted(scene.left, scene.left_input) || mounted(scene.right, scene.right_input);
}

bool redistributes(const Case& run) {
  const Scene& scene = run.scene;
  if (mounts_a_contact(scene)) return false;
  const std::size_t contacts = end_obstacles(scene);
  return contacts > 0 && !scene.span && run.elements > contacts;
}

// Under a span obstacle neighbours meet it one after the other. Where what they do then does not die out, for they are
// thrown back or nothing damps them, a mass that couples them spreads the impact of one over the others, and finer
// meshes bring the run no nearer (docs/methods.md).
bool impacts_stay(const Case& run) {
  return run.scene.span && is_scheme(run.method) &&
         (run.restitution.value_or(0.0) > 0.0 || run.scene.bar.viscosity == 0.0);
}

Mass quiet_mass(const Case& run) {
  if (impacts_stay(run)) return Mass::lumped;
  if (is_penalised(run.method) && meets_obstacle(run.scene))
    return redistributes(run) && method_row(run.method).takes_massless(run) ? Mass::redistributed : Mass::consistent;
  if (run.elements >= 3 && run.grading == 1.0) return Mass::fourth_order;
  return redistributes(run) ? Mass::redistributed : Mass::consistent;
}

}  // namespace

Mass effective_mass(const Case& run) {
  if (const auto own = method_row(run.method).mass) return own(run);
  return run.mass ? *run.mass : quiet_mass(run);
}

Method method_of(const Case& run) { return method_row(run.method).options(run); }

Mass common_mass(const Case& run) {
  Case study = run;
  study.method = penalised_method(run);
  return effective_mass(study);
}

double natural_epsilon(const Scene& scene) {
  const double unit = scene.bar.length / scene.bar.modulus;
  return scene.span && end_obstacles(scene) == 0 ? unit * scene.bar.length : unit;
}

double effective_epsilon(const Case& run) {
  if (run.epsilon) return *run.epsilon;
  const Bar& bar = run.scene.bar;
  const double h = run.mesh().spacing(), share = h / bar.length, wanted = share * share / 8.0;
  const double unit = natural_epsilon(run.scene), speed = std::sqrt(bar.modulus / bar.density);
  const auto penetration = [&](double epsilon) {
    const double deepest = run.scene.span ? speed * std::sqrt(bar.density * epsilon)
                                          : predict_impact(bar, h, 0.0, epsilon, speed).penetration;
    return deepest / bar.length;
  };
  constexpr int least = 40;
  double epsilon = unit;
  for (int k = 1; k <= least && penetration(epsilon) > wanted; ++k) epsilon = unit * std::pow(10.0, -k);
  return epsilon;
}

double scheme_step(const Case& run) {
  if (run.step) return *run.step;
  return run.mesh().spacing() / (100.0 * std::sqrt(run.scene.bar.modulus / run.scene.bar.density));
}

Odeint odeint(const Case& run) {
  return {{effective_epsilon(run), run.restitution.value_or(1.0)}, run.tolerance, run.stepper};
}

AutomaticMethod automatic_method(const Case& run) {
  const Scene& scene = run.scene;
  if (scene.span && !run.epsilon) return {MethodName::fully_discrete, ""};
  if (run.epsilon) {
    const bool massless = run.mass ? end_obstacles(scene) > 0 && run.mass == Mass::redistributed : redistributes(run);
    return {scene.bar.viscosity > 0.0 || massless ? MethodName::arkode : MethodName::cvode, ""};
  }
  if (scene.bar.viscosity > 0.0) return {MethodName::rigid, ""};
  if (!validate(scene).empty()) return {MethodName::characteristics, ""};
  const auto rigid_because = [](const std::string& why) {
    return AutomaticMethod{
        MethodName::rigid,
        fmt::format("automatic chose rigid, which has the errors of a mesh, and not characteristics: {}", why)};
  };
  try {
    if (const auto time = roughens(scene, run.end))
      return rigid_because(fmt::format(
          "contact changes break the waves without end, into more than 10,000 pieces at t = {:.4g}; no mesh "
          "follows such a motion for long: a positive bar.viscosity has a smooth one",
          *time));
  } catch (const std::invalid_argument& misfit) {
    return rigid_because(misfit.what());
  } catch (const IntegrationError& error) {
    // Another failure of the load is one that each method meets.
    if (error.failure == Failure::detail) return rigid_because(error.what());
  }
  return {MethodName::characteristics, ""};
}

std::string method_words(const Case& run) {
  return std::string(name(run.method)) + (run.automatic ? ", chosen for the scene" : "");
}

MethodName penalised_method(const Case& run) {
  Case study = run;
  if (!is_penalised(study.method))
    study.method = study.scene.bar.viscosity > 0.0 ? MethodName::arkode : MethodName::cvode;
  if (!study.mass && redistributes(study)) study.mass = Mass::redistributed;
  return has_algebraic_rows(study) && !method_row(study.method).takes_algebraic_rows ? MethodName::arkode
                                                                                     : study.method;
}

BarSystem make_system(const Case& run) { return BarSystem(run.scene, run.mesh(), effective_mass(run)); }

namespace {

/// The squares of what is smaller than this, energies among them, have no digits left.
constexpr double least_displacement = 1e-100;

/// @throws IntegrationError where the data move the bar, but by less than that
void require_size(const State& start, const BarSystem& system, double end) {
  const auto any = [](const std::vector<double>& values) {
    return std::ranges::any_of(values, [](double value) { return std::abs(value) >= least_displacement; });
  };
  if (any(start.u) || any(start.v)) return;
  const double moved = displacement_of_data(system, end);
  if (moved > 0.0 && moved < least_displacement)
    throw IntegrationError(Failure::overflow,
                           fmt::format("the data move the bar by some {:.1e}, which is too small for the squares of "
                                       "double precision: write 0, or take other units",
                                       moved),
                           {});
}

Statistics simulate_from(const StartingPoint& start, const Case& run, const BarSystem& system,
                         std::span<const double> times, const Observers& observers) {
  try {
    if (const auto* state = std::get_if<State>(&start)) require_size(*state, system, run.end);
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
