#include <algorithm>
#include <cmath>

#include "cli/commands.hpp"
#include "report/number_text.hpp"
#include "report/run/run_page.hpp"
#include "report/scene_check.hpp"
#include "text/table.hpp"

namespace viscobar::cli {

namespace {

std::string method_text(const Setup& setup, const BarSystem& system) {
  const Case& run = setup.run;
  if (run.method != MethodName::odeint) return method_words(run);
  const OdeintPlan what = plan(system, run.end, std::get<Odeint>(setup.method));
  return fmt::format("odeint, {}{}", viscobar::name(what.stepper),
                     what.least_steps > 1e4 ? fmt::format(", at least {:.1e} steps", what.least_steps) : "");
}

std::string events(const Case& run, const BarSystem& system) {
  if (system.contacts().empty()) return "none";
  if (is_scheme(run.method)) return "none: the constraint is solved in every step";
  return fmt::format("{}, one for each contact node", system.contacts().size());
}

/// So many digits as its error leaves, and `most` at most.
std::string with_digits(const NumberText& number, double value, double error, Dimension quantity, int most) {
  if (!(error > 0.0) || value == 0.0) return number(value, quantity, most);
  const double digits = std::floor(std::log10(std::abs(value))) + 1.0 - std::ceil(std::log10(error));
  if (digits >= most) return number(value, quantity, most);
  return "about " + number(value, quantity, std::max(1, static_cast<int>(digits)));
}

std::string impact_text(const Case& run, const std::optional<Foresight>& foreseen) {
  if (!foreseen) return "not predicted, the scene is large";
  const NumberText number = NumberText::terminal(run.scene);
  if (foreseen->impacts.empty()) return "none to t = " + number(run.end, Dimension::time, 6);
  std::string text;
  for (const FirstImpact& impact : foreseen->impacts)
    text += fmt::format("{}{}{} at t = {}, speed {}", text.empty() ? "" : "; ", name(impact.where),
                        impact.joint > 0 ? fmt::format(" {}", impact.joint) : "",
                        with_digits(number, impact.time, impact.time_error, Dimension::time, 4),
                        with_digits(number, impact.speed, impact.speed_error, Dimension::velocity, 3));
  return text;
}

std::string to_text(const ContactRegime& regime, const NumberText& number) {
  if (regime.stop) {
    const auto& found = regime.forecast;
    if (!found) return fmt::format("by {}; no impact is predicted", viscobar::name(regime.stop->law));
    return fmt::format(
        "by {}, damping ratio zeta = {:.3g}: a lone mass leaves with {:.3g} of its speed; impact at speed {}, predicted "
        "penetration {}, peak {}",
        viscobar::name(regime.stop->law), found->damping_ratio, found->restitution,
        number(found->speed, Dimension::velocity), number(found->penetration, Dimension::length, 2),
        number(found->force, Dimension::force, 2));
  }
  const bool rebounds = regime.damping_ratio && *regime.damping_ratio < 1.0;
  std::string text = "massless node, no bounce";
  if (regime.damping_ratio)
    text = fmt::format("damping ratio zeta = {:.3g}, {}", *regime.damping_ratio,
                       regime.chatters ? "chatter expected"
                       : rebounds      ? "no chatter"
                                       : "no bounce");
  if (regime.impact)
    text += fmt::format("; impact at speed {}, predicted penetration {} ({})",
                        number(regime.impact->speed, Dimension::velocity),
                        number(regime.impact->penetration, Dimension::length, 2), name(regime.impact->layer));
  return text;
}

std::string model_text(const Case& run, const BarSystem& system) {
  const std::size_t nodes = system.mesh().nodes();
  if (run.method == MethodName::characteristics) {
    double passage = run.scene.bar.transit();
    for (const Member& member : run.scene.chain)
      if (const Bar& bar = member.bar; !member.rigid()) passage = std::min(passage, bar.transit());
    return row("unknowns", "polynomial pieces of two waves{}; the {} nodes are for output only",
               run.scene.chain.empty() ? "" : " a bar", nodes) +
           row("passages", "{:.4g} of a wave through the {}bar, each L/c = {}", run.end / passage,
               run.scene.chain.empty() ? "" : "shortest ",
               NumberText::terminal(run.scene)(passage, Dimension::time, 4));
  }
  return row("unknowns", "{} nodes of {}, displacement and velocity", system.size(), nodes) +
         row("inertia", "{} mass{}", viscobar::name(system.mass()),
             system.inertia().has_massless() ? ", massless contact nodes" : "");
}

std::string check_text(const SceneCheck& check) {
  const Case& run = check.setup.run;
  const BarSystem& system = check.system;
  const Scene& scene = run.scene;
  const Mesh& mesh = system.mesh();
  const NumberText number = NumberText::terminal(scene);
  std::string text = row("method", method_text(check.setup, system)) + model_text(run, system);
  for (const std::string& words : member_texts(scene)) text += row("member", words);
  text += row("elasticity", "{}{}",
              scene.chain.empty() ? fmt::format("E = {}, ", number(scene.bar.modulus, Dimension::stress, 10)) : "",
              element_size(mesh, number));
  if (scene.section) text += row("section", section_text(scene));
  text += row("damping", !system.bar().damped() ? "none"
                         : scene.chain.empty()
                             ? "eta = " + number(scene.bar.viscosity, unit_powers("stress x time").value(), 10)
                             : "of each bar its own");
  text += row("load", load_kind(scene));
  if (scene.side) text += row("side", side_text(scene));
  for (const SceneEnd& end : ends_of(scene))
    for (const std::string& words : inputs_text(scene, system.bar(), end))
      text += row(fmt::format("{} end", end.name), words);
  text += row("contact", system.contacts().empty() ? "none" : contact_kind(check.setup));
  text += row("event functions", events(run, system));
  text += row("memory", "about {} vectors of {} numbers, {}", check.memory.vectors, system.size(),
              byte_number(check.memory.bytes));
  if (!system.contacts().empty()) text += row("first impacts", impact_text(run, check.foreseen));
  if (check.error) {
    const auto rows = estimate_rows(scene, *check.error);
    text += row(rows.front().first,
                rows.front().second + (check.error_elements == run.elements
                                           ? ""
                                           : fmt::format(" on {} elements; runs on {} take longer than a check",
                                                         check.error_elements, run.elements)));
    for (std::size_t i = 1; check.scene.accuracy && i < rows.size(); ++i) text += row(rows[i].first, rows[i].second);
  }
  if (!check.no_error.empty()) text += row("error, estimated", "there is no estimate: " + check.no_error);
  for (const ContactRegime& regime : check.regimes)
    text += row(fmt::format("{} contact", name(regime.where)), to_text(regime, number));
  return text;
}

}  // namespace

Action check_command(CLI::App& command) {
  return [scene_options = std::make_shared<SceneOptions>(command)] {
    const SceneFile scene = scene_options->read();
    const SceneCheck check = check_scene(scene);
    if (scene_options->json) {
      print(check_json(check));
      return success;
    }
    print(fmt::format("{}: sound\n{}", heading(scene.run.scene.title, scene_options->file), check_text(check)));
    for (const std::string& caution : check.warnings) warn(caution);
    return success;
  };
}

}  // namespace viscobar::cli
