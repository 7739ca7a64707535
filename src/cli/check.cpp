#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/commands.hpp"
#include "viscobar/analysis/regime.hpp"

namespace viscobar::cli {

namespace {

using Json = nlohmann::ordered_json;

std::string_view name(Where where) {
  switch (where) {
    case Where::left: return "left";
    case Where::right: return "right";
    case Where::span: return "span";
  }
  return {};
}

std::string_view name(ImpactPrediction::Layer layer) {
  switch (layer) {
    case ImpactPrediction::Layer::viscous: return "viscous layer";
    case ImpactPrediction::Layer::elastic: return "elastic wave";
    case ImpactPrediction::Layer::node: return "end node alone, the mesh is too coarse for the layer";
  }
  return {};
}

std::string_view load_kind(const Scene& scene) {
  if (!scene.load) return "none";
  if (std::holds_alternative<SteadyLoad>(*scene.load)) return "steady";
  return std::holds_alternative<SeparableLoad>(*scene.load) ? "profile times history" : "general";
}

std::string contact_kind(const Case& run) {
  if (is_penalised(run.method)) return fmt::format("penalty, epsilon = {}", *run.epsilon);
  return run.method == MethodName::rigid ? "rigid: closed nodes are held" : "exact constraint in every step";
}

std::string events(const Case& run, const BarSystem& system) {
  if (system.contacts().empty()) return "none";
  if (is_scheme(run.method)) return "none: the constraint is solved in every step";
  return fmt::format("{}, one for each contact node", system.contacts().size());
}

std::vector<std::string> warnings(const Case& run, const std::vector<ContactRegime>& regimes) {
  std::vector<std::string> found;
  const auto held = [&](const EndCondition& end, double x, const char* where) {
    if (const double v = run.scene.velocity(x); is_fixed(end) && v != 0.0)
      found.push_back(fmt::format("the {} end is fixed, but its initial velocity is {}: it is held still", where, v));
  };
  held(run.scene.left, 0.0, "left");
  held(run.scene.right, run.scene.bar.length, "right");
  for (const ContactRegime& regime : regimes) {
    if (!regime.chatters) continue;
    if (regime.where == Where::span) {
      found.push_back(
          fmt::format("span: the nodes rebound (zeta = {:.3g}), and the fully discrete scheme's do not; "
                      "contact.restitution = 0 makes the two agree",
                      *regime.damping_ratio));
      continue;
    }
    found.push_back(
        fmt::format("{}: the end node rebounds (zeta = {:.3g} < 1), so chatter is expected; what helps: "
                    "mesh.mass = \"redistributed\", contact.restitution = 0, or contact.epsilon of at least "
                    "{:.2g}",
                    name(regime.where), *regime.damping_ratio, regime.quiet_epsilon));
  }
  return found;
}

Json to_json(const ContactRegime& regime) {
  Json json = {{"where", name(regime.where)},
               {"effective_mass", regime.effective_mass},
               {"damping_ratio", regime.damping_ratio ? Json(*regime.damping_ratio) : Json(nullptr)},
               {"chatter_expected", regime.chatters}};
  json["impact"] = regime.impact ? Json{{"speed", regime.impact->speed},
                                        {"predicted_penetration", regime.impact->penetration},
                                        {"by", name(regime.impact->layer)}}
                                 : Json(nullptr);
  return json;
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
    : command_(*app.add_subcommand("check", "Validate a scene and say what model it needs")), scene_(command_) {}

int CheckCommand::operator()() const {
  const SceneFile scene = scene_.read();
  const Case& run = scene.run;
  const BarSystem system = make_system(run);
  const std::vector<ContactRegime> regimes = contact_regimes(run, system);
  const MemoryNeed memory = memory_need(run, system);

  Json json;
  json["title"] = run.scene.title;
  json["method"] = viscobar::name(run.method);
  json["nodes"] = system.mesh().nodes();
  json["unknown_nodes"] = system.size();
  json["spacing"] = system.mesh().spacing();
  json["mass"] = viscobar::name(system.mass());
  json["terms"] = {{"inertia", system.has_massless() ? "massless contact nodes" : "every node"},
                   {"elasticity", true},
                   {"damping", system.damped()},
                   {"load", load_kind(run.scene)},
                   {"contact", system.contacts().empty() ? Json(nullptr) : Json(contact_kind(run))}};
  json["contact_nodes"] = system.contacts().size();
  json["event_functions"] = is_scheme(run.method) ? 0 : system.contacts().size();
  json["memory"] = {{"vectors", memory.vectors}, {"bytes", memory.bytes}};
  json["contacts"] = Json::array();
  for (const ContactRegime& regime : regimes) json["contacts"].push_back(to_json(regime));
  const std::vector<std::string> cautions = warnings(run, regimes);
  json["warnings"] = cautions;
  json["scene"] = Json::parse(scene.description);
  if (scene_.json) {
    print(json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
    return success;
  }

  std::string text = fmt::format("{}: sound\n", run.scene.title.empty() ? scene_.file : run.scene.title);
  text += row("method", viscobar::name(run.method));
  text +=
      row("unknowns", fmt::format("{} nodes of {}, displacement and velocity", system.size(), system.mesh().nodes()));
  text += row("inertia", fmt::format("{} mass{}", viscobar::name(system.mass()),
                                     system.has_massless() ? ", massless contact nodes" : ""));
  text += row("elasticity", fmt::format("E = {}, h = {:.4g}", run.scene.bar.modulus, system.mesh().spacing()));
  text += row("damping", system.damped() ? fmt::format("eta = {}", run.scene.bar.viscosity) : "none");
  text += row("load", load_kind(run.scene));
  text += row("contact", system.contacts().empty() ? "none" : contact_kind(run));
  text += row("event functions", events(run, system));
  text += row("memory", fmt::format("about {} vectors of {} numbers, {:.3g} MB", memory.vectors, system.size(),
                                    static_cast<double>(memory.bytes) / 1e6));
  for (const ContactRegime& regime : regimes)
    text += row(fmt::format("{} contact", name(regime.where)), to_text(regime));
  print(text);
  for (const std::string& caution : cautions) fmt::print(stderr, "warning: {}\n", caution);
  return success;
}

}  // namespace viscobar::cli
