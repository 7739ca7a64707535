#include <fmt/format.h>

#include <cmath>

#include "cli/commands.hpp"
#include "cli/messages.hpp"
#include "report/scene_check.hpp"
#include "text/table.hpp"

namespace viscobar::cli {

namespace {

std::string method_text(const Case& run, const BarSystem& system) {
  if (run.method != MethodName::odeint) return method_words(run);
  const OdeintPlan what = plan(system, run.end, odeint(run));
  return fmt::format("odeint, {}{}", viscobar::name(what.stepper),
                     what.least_steps > 1e4 ? fmt::format(", at least {:.1e} steps", what.least_steps) : "");
}

std::string events(const Case& run, const BarSystem& system) {
  if (system.contacts().empty()) return "none";
  if (is_scheme(run.method)) return "none: the constraint is solved in every step";
  return fmt::format("{}, one for each contact node", system.contacts().size());
}

std::string impact_text(const Case& run, const std::optional<std::vector<FirstImpact>>& hits) {
  if (!hits) return "not predicted, the scene is large";
  if (hits->empty()) return fmt::format("none to t = {}", run.end);
  std::string text;
  for (const FirstImpact& impact : *hits)
    text += fmt::format("{}{} at t = {:.4g}, speed {:.3g}", text.empty() ? "" : "; ", name(impact.where), impact.time,
                        impact.speed);
  return text;
}

std::string to_text(const ContactRegime& regime) {
  std::string text;
  if (!regime.damping_ratio)
    text = "massless node, no bounce";
  else
    text = fmt::format("damping ratio zeta = {:.3g}, {}", *regime.damping_ratio,
                       regime.chatters ? "chatter expected" : "no bounce");
  if (regime.impact)
    text += fmt::format("; impact at speed {:.3g}, predicted penetration {:.2g} ({})", regime.impact->speed,
                        regime.impact->penetration, name(regime.impact->layer));
  return text;
}

}  // namespace

CheckCommand::CheckCommand(CLI::App& app)
    : Command(app, "check", "Validate a scene, describe its model and predict its first impacts"), scene_(command_) {}

int CheckCommand::operator()() const {
  const SceneFile scene = scene_.read();
  const Case& run = scene.run;
  const SceneCheck check = check_scene(run);
  const BarSystem& system = check.system;
  const bool waves = run.method == MethodName::characteristics;
  const double passage = run.scene.bar.length * std::sqrt(run.scene.bar.density / run.scene.bar.modulus);
  const double passages = run.end / passage;

  if (scene_.json) {
    print(check_json(scene, check));
    return success;
  }

  std::string text = fmt::format("{}: sound\n", heading(run.scene.title, scene_.file));
  text += row("method", method_text(run, system));
  if (waves) {
    text += row("unknowns",
                fmt::format("polynomial pieces of two waves; the {} nodes are for output only", system.mesh().nodes()));
    text += row("passages", fmt::format("{:.4g} of a wave through the bar, each L/c = {:.4g}", passages, passage));
  } else {
    text +=
        row("unknowns", fmt::format("{} nodes of {}, displacement and velocity", system.size(), system.mesh().nodes()));
    text += row("inertia", fmt::format("{} mass{}", viscobar::name(system.mass()),
                                       system.has_massless() ? ", massless contact nodes" : ""));
  }
  text += row("elasticity", fmt::format("E = {}, h = {:.4g}{}", run.scene.bar.modulus, system.mesh().spacing(),
                                        system.mesh().uniform() ? ""
                                                                : fmt::format(" on average, {:.4g} at the contacts",
                                                                              system.mesh().smallest())));
  text += row("damping", system.damped() ? fmt::format("eta = {}", run.scene.bar.viscosity) : "none");
  text += row("load", load_kind(run.scene));
  for (const std::string& words : inputs_text(system.bar(), run.scene.left, run.scene.left_input))
    text += row("left end", words);
  for (const std::string& words : inputs_text(system.bar(), run.scene.right, run.scene.right_input))
    text += row("right end", words);
  text += row("contact", system.contacts().empty() ? "none" : contact_kind(run));
  text += row("event functions", events(run, system));
  text += row("memory", fmt::format("about {} vectors of {} numbers, {}", check.memory.vectors, system.size(),
                                    byte_number(check.memory.bytes)));
  if (!system.contacts().empty()) text += row("first impacts", impact_text(run, check.impacts));
  if (check.error)
    text +=
        row("error", fmt::format("up to about {:.1g} of displacements (space {:.1g}, penalty {:.1g}, time {:.1g}), by "
                                 "runs on coarser meshes",
                                 check.error->total, check.error->space, check.error->penalty, check.error->time));
  if (!check.no_error.empty()) text += row("error", "there is no estimate: " + check.no_error);
  for (const ContactRegime& regime : check.regimes)
    text += row(fmt::format("{} contact", name(regime.where)), to_text(regime));
  print(text);
  for (const std::string& caution : check.warnings) warn(caution);
  return success;
}

}  // namespace viscobar::cli
