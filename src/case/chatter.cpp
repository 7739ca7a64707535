#include "case/chatter.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "scene/end_kinds.hpp"

namespace viscobar {

ChatterWatch::ChatterWatch(const BarSystem& system) : window_(2.0 * system.mesh().length * system.bar().slowness()) {
  std::vector<double> sides(system.size(), 0.0);
  for (const Contact& contact : system.contacts()) {
    if (contact.joint > 0)
      joints_.resize(2 * (contact.joint + 1));
    else
      (contact.where == Where::span ? span_ : ends_).resize(2 * system.mesh().nodes());
    between_ = between_ || sides[contact.unknown] * contact.sign < 0.0;
    sides[contact.unknown] = contact.sign;
  }
}

std::optional<ChatterWatch::Chatter> ChatterWatch::heard(const Event& event) {
  if (told_ || event.change == Change::opening) return std::nullopt;
  const std::size_t up = between_ && event.velocity > 0.0 ? 1 : 0;
  if (between_ && event.where != Where::joint)
    for (auto* bursts : {&ends_, &span_})
      if (!bursts->empty()) (*bursts)[2 * event.node + 1 - up] = {};
  Burst& burst = (event.where == Where::span    ? span_
                  : event.where == Where::joint ? joints_
                                                : ends_)[2 * event.node + up];
  if (burst.closings == 0 || event.time - burst.since > window_) burst = {event.time, 0};
  if (++burst.closings < closings) return std::nullopt;
  told_ = true;
  return Chatter{event.where, event.node, burst.since, event.time};
}

std::string chatter_remedies(const Setup& setup, const std::optional<ContactRegime>& regime, Where where) {
  const Case& run = setup.run;
  const bool elastic =
      is_penalised(run.method) ? !(run.restitution && *run.restitution == 0.0) : run.restitution.value_or(0.0) > 0.0;
  std::string remedies;
  const auto add = [&](const std::string& remedy) { remedies += (remedies.empty() ? "" : ", ") + remedy; };
  // A remedy must be possible by one --set.
  const auto offer = [&](const std::string& remedy, const Case& changed) {
    if (sound(changed)) add(remedy);
  };
  Case massless = run, other = run, inelastic = run;
  massless.mass = Mass::redistributed, other.method = MethodName::arkode, inelastic.restitution = 0.0;
  const Scene& scene = run.scene;
  if (setup.mass != Mass::redistributed &&
      ((where == Where::left && is_bare_obstacle(scene.left, scene.left_input)) ||
       (where == Where::right && is_bare_obstacle(scene.right, scene.right_input)))) {
    offer("mesh.mass = \"redistributed\"", massless);
    if (remedies.empty() && is_penalised(run.method) && resolve(other).mass == Mass::redistributed)
      offer("method.name = \"arkode\"", other);
  }
  if (elastic) offer("contact.restitution = 0", inelastic);
  if (regime && regime->quiet_epsilon > 0.0)
    add(fmt::format("contact.epsilon of at least {:.2g}", regime->quiet_epsilon));
  else if (is_penalised(run.method) && has_penalty(run.scene))
    add("a larger contact.epsilon");
  return remedies;
}

std::string chatter_warning(const Setup& setup, const BarSystem& system, const ChatterWatch::Chatter& chatter) {
  const std::vector<ContactRegime> regimes = contact_regimes(setup, system);
  const auto found = std::ranges::find(regimes, chatter.where, &ContactRegime::where);
  const std::optional<ContactRegime> regime = found == regimes.end() ? std::nullopt : std::optional(*found);
  const std::string place = chatter.where == Where::left    ? "the left end"
                            : chatter.where == Where::right ? "the right end"
                            : chatter.where == Where::joint ? fmt::format("joint {}", chatter.node)
                                                            : fmt::format("node {} of the span", chatter.node);
  const std::string ratio =
      regime && regime->damping_ratio ? fmt::format(", damping ratio zeta = {:.3g}", *regime->damping_ratio) : "";
  const std::string remedies = chatter_remedies(setup, regime, chatter.where);
  return fmt::format(
      "chatter: {} closed {} times from t = {:.6g} to {:.6g}, faster than a wave crosses the bar and returns: its node "
      "rebounds by itself{}; every bounce is computed, which costs steps{}{}",
      place, ChatterWatch::closings, chatter.since, chatter.until, ratio,
      remedies.empty() ? "" : "; remedies: ", remedies);
}

}  // namespace viscobar
