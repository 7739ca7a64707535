#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "characteristics/run.hpp"
#include "scene/end_kinds.hpp"
#include "scene/times.hpp"
#include "viscobar/characteristics/characteristics.hpp"

namespace viscobar {

namespace {

// A(x) that varies anywhere that one looks.
bool varies(const SpaceFunction& section, const Places& places, double length) {
  if (!section) return false;
  if (!(section(0.0) > 0.0)) return true;  // it is none
  constexpr int looks = 200;
  const auto inside = [&](const NextBreak& breaks) { return breaks && breaks(0.0, length); };
  if (inside(places.breaks) || inside(places.detail)) return true;
  for (int k = 1; k <= looks; ++k)
    if (section(length * k / looks) != section(0.0)) return true;
  return false;
}

// A bar whose waves change on their way; `table` is bar, or bar.2.
std::optional<Finding> bar_refusal(const std::string& table, const Bar& bar, bool section_varies) {
  if (bar.viscosity > 0.0)
    return Finding{"method.name", fmt::format("characteristics carries waves unchanged, and {}.viscosity = {} changes "
                                              "them; use rigid, or one of the penalised methods",
                                              table, bar.viscosity)};
  if (section_varies)
    return Finding{table + ".section",
                   "is not for characteristics: a section that varies reflects waves at every place; use "
                   "rigid, or fully_discrete"};
  return std::nullopt;
}

std::optional<Finding> chain_refusal(const Scene& scene) {
  const std::vector<Member>& chain = scene.chain;
  for (std::size_t m = 0; m < chain.size(); ++m)
    if (!chain[m].rigid())
      if (auto why = bar_refusal(fmt::format("bar.{}", m + 1), chain[m].bar,
                                 varies(chain[m].section, chain[m].section_places, chain[m].bar.length)))
        return why;
  if (std::ranges::all_of(chain, &Member::rigid))
    return Finding{"method.name",
                   "characteristics follows the waves of bars, and there are rigid bodies alone; use "
                   "fully_discrete"};
  for (std::size_t m = 0; m + 1 < chain.size(); ++m)
    if (const auto& stop = chain[m].joint.stop; chain[m].joint.kind == JointKind::contact && stop && !stop->linear())
      return law_refusal("characteristics", *stop, fmt::format("joint.{}", m + 1));
  return std::nullopt;
}

// Masses and springs are followed by pieces of two of their own times.
std::optional<Finding> rate_refusal(const Scene& scene) {
  constexpr double most_rate = 1e3;
  const std::vector<characteristics::LineBar> bars = characteristics::bars_of(scene);
  const double window = characteristics::window_of(bars);
  for (const characteristics::Junction& junction :
       characteristics::junctions_of(scene, bars, window, 0.0, nullptr, nullptr))
    if (const auto [rate, key] = junction.fastest(); rate > most_rate)
      return Finding{key, fmt::format("makes for a motion that is over {:.2g} times while a wave crosses {}, and "
                                      "characteristics follows none that is faster than {:.2g}; {}, or use rigid",
                                      rate, scene.chain.empty() ? "the bar" : "the shortest bar", most_rate,
                                      key.ends_with("mass") ? "leave the mass out" : "take a contact or a bond")};
  return std::nullopt;
}

}  // namespace

std::optional<Finding> refusal(const Scene& scene, double end, const Characteristics& method) {
  if (auto why = law_refusal("characteristics", scene.left_input, scene.right_input, true)) return why;
  if (scene.chain.empty()) {
    if (auto why = bar_refusal("bar", scene.bar, varies(scene.section, scene.section_places, scene.bar.length)))
      return why;
  } else if (auto why = chain_refusal(scene)) {
    return why;
  }
  if (scene.side)
    return Finding{scene.side->stiffness ? "side.stiffness" : "side.drag",
                   "is not for characteristics: what resists along the bar changes its waves as they travel; use "
                   "rigid, or fully_discrete"};
  if (scene.span)
    return Finding{
        "method.name",
        "characteristics knows obstacles at the ends, and under a span obstacle the whole bar may touch; use "
        "fully_discrete, or one of the penalised methods"};
  if (method.restitution > 0.0 && keeps_restitution(scene))
    return Finding{"contact.restitution",
                   fmt::format("is {}, and of masses that strike an obstacle or each other characteristics knows "
                               "impacts without rebound alone; leave it out, or use rigid",
                               method.restitution)};
  if (auto why = rate_refusal(scene)) return why;
  for (const bool right : {false, true}) {
    const EndInput& input = right ? scene.right_input : scene.left_input;
    if (!input.motion || !input.motion->breaks) continue;
    const EndMotion& motion = *input.motion;
    const bool of_body = !scene.chain.empty() && (right ? scene.chain.back() : scene.chain.front()).rigid();
    const double apart = rounding_of_times(0.0, end);
    // How far f moves at t beyond what it does at its rate.
    const auto jumps = [&](double t, const TimeFunction& f, const TimeFunction& rate) {
      const double before = f(t - apart), after = f(t + apart);
      const double rates = std::abs(rate(t - apart)) + std::abs(rate(t + apart));
      return std::abs(after - before) > 16.0 * rates * apart + 1e-12 * (std::abs(before) + std::abs(after));
    };
    const auto refused = [&](double t, std::string_view what) {
      const bool obstacle = is_obstacle(right ? scene.right : scene.left);
      return Finding{fmt::format("{}.{}", right ? "right" : "left", obstacle ? "gap" : "motion"),
                     fmt::format("{} at t = {}, and characteristics does not follow it; use rigid", what, t)};
    };
    for (auto at = motion.breaks(0.0, end); at; at = motion.breaks(*at + apart, end)) {
      if (jumps(*at, motion.displacement, motion.velocity)) return refused(*at, "jumps");
      if ((input.mass > 0.0 || of_body) && jumps(*at, motion.velocity, motion.acceleration))
        return refused(*at, "has a kink, by which a mass is struck,");
    }
  }
  const double passages = end / characteristics::window_of(characteristics::bars_of(scene));
  if (!(passages <= Characteristics::most_passages))
    return Finding{
        "time.end",
        fmt::format("characteristics follows a wave from passage to passage through {}, here {:.2g} of them, at most "
                    "{:.0g}; choose an earlier end{}",
                    scene.chain.empty() ? "the bar" : "the shortest bar", passages, Characteristics::most_passages,
                    scene.chain.empty() ? "" : ", or a rigid body for a bar so short")};
  return std::nullopt;
}

}  // namespace viscobar
