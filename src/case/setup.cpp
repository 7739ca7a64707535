#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "case/method_table.hpp"
#include "case/regime.hpp"
#include "discretisation/gauss.hpp"
#include "dynamics/pieces.hpp"
#include "scene/end_kinds.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

namespace {

// A dashpot at a joint, which makes a chain of elastic bars a damped one, is no viscosity of theirs.
bool has_viscous_bar(const Scene& scene) {
  return std::ranges::any_of(scene_bars(scene), [](const SceneBar& one) { return one.bar.viscosity > 0.0; });
}

bool redistributes(const Case& run) {
  const std::size_t massless = bare_obstacles(run.scene);
  return massless > 0 && !run.scene.span && run.scene.chain.empty() && run.elements > massless;
}

// Under a span obstacle neighbours meet it one after the other. Where what they do then does not die out, for they are
// thrown back or nothing damps them, a mass that couples them spreads the impact of one over the others, and finer
// meshes bring the run no nearer (docs/methods.md).
bool impacts_stay(const Case& run) {
  return run.scene.span && is_scheme(run.method) &&
         (run.restitution.value_or(0.0) > 0.0 || run.scene.bar.viscosity == 0.0);
}

}  // namespace

bool fourth_order_fits(const Case& run) {
  if (run.elements < 3) return false;
  if (run.rows_alike()) return true;
  const auto fits = [](const Mesh& mesh, const SpaceFunction& section) {
    const auto stretch = [&](std::size_t j) {
      const double half = 0.5 * mesh.element(j), middle = mesh.node(j) + half;
      if (!section) return 2.0 * half;
      double sum = 0.0;
      for (const auto [node, weight] : gauss(10)) sum += half * weight / section(middle + half * node);
      return sum;
    };
    double before = stretch(0);
    for (std::size_t j = 1; j < mesh.elements && !(mesh.uniform() && !section); ++j) {
      const double next = stretch(j);
      if (!(std::max(before, next) <= largest_jump * std::min(before, next))) return false;
      before = next;
    }
    return mesh.elements >= 3;
  };
  const Mesh mesh = run.mesh();
  const std::vector<Member>& chain = run.scene.chain;
  for (std::size_t m = 0; m < chain.size(); ++m)
    if (!chain[m].rigid() && !fits((*mesh.members)[m], chain[m].section)) return false;
  return !chain.empty() || fits(mesh, run.scene.section);
}

namespace {

template <class Value>
struct Chosen {
  Value value;
  std::string_view why;
};
constexpr std::string_view asked = "asked for";

Chosen<Mass> mass_of(const Case& run) {
  if (const auto own = method_row(run.method).mass) return {own(run), "the method has no other"};
  if (run.mass) return {*run.mass, asked};
  if (impacts_stay(run)) return {Mass::lumped, "impacts under a span obstacle stay with their nodes"};
  const bool penalised = is_penalised(run.method) && has_penalty(run.scene);
  if (!penalised && fourth_order_fits(run))
    return {Mass::fourth_order, "the most accurate, and no contact is penalised"};
  if (redistributes(run) && !(penalised && !method_row(run.method).takes_massless(run)))
    return {Mass::redistributed, "contact nodes without mass do not bounce"};
  return {Mass::consistent, "of the elements; the scene and the method take no better one"};
}

Chosen<double> epsilon_of(const Case& run, const Mesh& mesh) {
  if (run.epsilon) return {*run.epsilon, asked};
  Bar bar = whole_section(run.scene.bar, largest_end(run.scene));
  if (!has_viscous_bar(run.scene)) bar.viscosity = 0.0;
  const double h = mesh.spacing(), share = h / bar.length, wanted = share * share / 8.0;
  const double unit = natural_epsilon(run.scene), speed = bar.wave_speed();
  // A mass that strikes an obstacle is (m epsilon)^(1/2) times its speed deep before it stops.
  double mass = 0.0;
  for (const auto& [end, input] :
       {std::pair{&run.scene.left, &run.scene.left_input}, {&run.scene.right, &run.scene.right_input}})
    if (is_obstacle(*end)) mass = std::max(mass, input->mass);
  const auto penetration = [&](double epsilon) {
    const double deepest = run.scene.span ? speed * std::sqrt(bar.density * epsilon)
                                          : predict_impact(bar, h, 0.0, epsilon, speed).penetration;
    return std::max(deepest, speed * std::sqrt(mass * epsilon)) / bar.length;
  };
  constexpr int least = 40;
  double epsilon = unit;
  for (int k = 1; k <= least && penetration(epsilon) > wanted; ++k) epsilon = unit * std::pow(10.0, -k);
  return {epsilon, "an impact penetrates by less than the error of the mesh"};
}

Chosen<double> step_of(const Case& run, const Mesh& mesh) {
  if (run.step) return {*run.step, asked};
  const double wave = mesh.spacing() / (100.0 * run.scene.bar.wave_speed());
  // A bar so soft that no wave crosses an element within the run still moves as a whole.
  if (wave > run.end / 1000.0) return {run.end / 1000.0, "a thousandth of the run"};
  return {wave, "a hundredth of the time of a wave through an element"};
}

}  // namespace

Setup resolve(Case run) {
  const Mesh mesh = run.mesh();
  const auto mass = mass_of(run);
  const auto epsilon = epsilon_of(run, mesh), step = step_of(run, mesh);
  const std::string_view method = run.automatic ? "chosen for the scene" : asked;
  Setup setup{
      std::move(run), mesh, mass.value, epsilon.value, step.value, {}, {method, mass.why, epsilon.why, step.why}};
  setup.method = method_row(setup.run.method).options(setup);
  return setup;
}

Case Setup::settled() const {
  Case all = run;
  if (all.method != MethodName::characteristics) all.mass = mass;
  if (is_penalised(all.method)) all.epsilon = epsilon;
  if (is_scheme(all.method)) all.step = step;
  return all;
}

Mass common_mass(const Case& run) {
  Case study = run;
  study.method = penalised_method(run);
  return mass_of(study).value;
}

double largest_end(const Scene& scene) {
  double largest = 0.0;
  for (const SceneBar& one : scene_bars(scene)) largest = std::max({largest, one.area(0.0), one.area(one.bar.length)});
  return largest;
}

double natural_epsilon(const Scene& scene) {
  const double unit = scene.bar.length / (scene.bar.modulus * largest_end(scene));
  return is_penalty_of_span(scene) ? unit * scene.bar.length : unit;
}

AutomaticMethod automatic_method(const Case& run) {
  const Scene& scene = run.scene;
  if (scene.span && !run.epsilon && !has_stops(scene)) return {MethodName::fully_discrete, ""};
  const bool by_law = run.epsilon || has_stops(scene);
  MethodName meshed = MethodName::rigid;
  if (by_law) {
    const bool massless = run.mass ? bare_obstacles(scene) > 0 && run.mass == Mass::redistributed : redistributes(run);
    meshed = scene.bar.viscosity > 0.0 || massless ? MethodName::arkode : MethodName::cvode;
  }
  if (run.epsilon || scene.span || has_stops(scene, [](const Stop& stop) { return !stop.linear(); }))
    return {meshed, ""};
  if (has_viscous_bar(scene)) return {meshed, ""};
  if (!validate(scene).empty()) return {MethodName::characteristics, ""};
  const auto meshed_because = [meshed](const std::string& why) {
    return AutomaticMethod{
        meshed, fmt::format("automatic chose {}, which has the errors of a mesh, and not characteristics: {}",
                            name(meshed), why)};
  };
  try {
    if (const auto why = refusal_by_characteristics(run)) return meshed_because(why->key + " " + why->problem);
    if (const auto time = roughens(scene, run.end))
      return meshed_because(fmt::format(
          "contact changes break the waves without end, into more than 10,000 pieces at t = {:.4g}; no mesh "
          "follows such a motion for long: a positive bar.viscosity has a smooth one",
          *time));
    constexpr double most = 3e7;  // evaluations, some seconds
    const double outputs = run.end / run.output_every;
    if (const double evaluations = outputs * evaluations_of_output(scene, run.end); evaluations > most)
      return meshed_because(fmt::format(
          "a load in x and t takes some {:.1g} evaluations for {:.0f} outputs; fewer outputs, or a product of a function "
          "of x and one of t, take less",
          evaluations, outputs));
  } catch (const Unfit& unfit) {
    return meshed_because(unfit.finding.key + " " + unfit.finding.problem);
  } catch (const std::invalid_argument& misfit) {
    return meshed_because(misfit.what());
  } catch (const IntegrationError& error) {
    // Another failure of the load is one that each method meets.
    if (error.failure == Failure::detail) return meshed_because(error.what());
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

}  // namespace viscobar
