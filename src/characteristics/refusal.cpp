#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "viscobar/characteristics/characteristics.hpp"

namespace viscobar {

std::optional<Finding> refusal(const Scene& scene, double end, const Characteristics&) {
  const Bar& bar = scene.bar;
  if (auto law = law_refusal("characteristics", scene.left_input, scene.right_input)) return law;
  if (bar.viscosity > 0.0)
    return Finding{"method.name", fmt::format("characteristics carries waves unchanged, and bar.viscosity = {} changes "
                                              "them; use rigid, or one of the penalised methods",
                                              bar.viscosity)};
  if (!scene.chain.empty())
    return Finding{"method.name", "characteristics takes one bar; for several in line use rigid"};
  if (scene.section)
    return Finding{"bar.section",
                   "is not for characteristics: a section that varies reflects waves at every place; use "
                   "rigid, or fully_discrete"};
  if (scene.side)
    return Finding{scene.side->stiffness ? "side.stiffness" : "side.drag",
                   "is not for characteristics: what resists along the bar changes its waves as they travel; use "
                   "rigid, or fully_discrete"};
  if (scene.span)
    return Finding{
        "method.name",
        "characteristics knows obstacles at the ends, and under a span obstacle the whole bar may touch; use "
        "fully_discrete, or one of the penalised methods"};
  if (scene.left_input.stiffness != 0.0 || scene.right_input.stiffness != 0.0)
    return Finding{scene.left_input.stiffness != 0.0 ? "left.stiffness" : "right.stiffness",
                   "is not for characteristics: a spring remembers what has arrived, and waves return as no "
                   "polynomials; use rigid, or fully_discrete"};
  for (const auto& [input, key] : {std::pair{&scene.left_input, "left.mass"}, {&scene.right_input, "right.mass"}}) {
    if (input->mass == 0.0) continue;
    if (input->motion)
      return Finding{key,
                     "is not for characteristics where the obstacle before it moves; use rigid, or fully_discrete"};
    // It is followed by pieces in which it lags by at most two of its own times.
    constexpr double least_share = 1e-3;
    const double impedance = std::sqrt(bar.density * bar.modulus), share = input->mass / (bar.density * bar.length);
    if (share < least_share * (1.0 + input->dashpot / impedance))
      return Finding{key,
                     fmt::format("is {:.2g} of the bar's mass, and characteristics follows none below {:.2g}; leave "
                                 "it out, or use rigid",
                                 share, least_share * (1.0 + input->dashpot / impedance))};
  }
  for (const auto& [input, condition, key] :
       {std::tuple{&scene.left_input, &scene.left, "left"}, {&scene.right_input, &scene.right, "right"}}) {
    if (!input->motion || !input->motion->breaks) continue;
    const EndMotion& motion = *input->motion;
    const double apart = 64.0 * std::numeric_limits<double>::epsilon() * end;
    for (auto at = motion.breaks(0.0, end); at; at = motion.breaks(*at + apart, end)) {
      const double before = motion.displacement(*at - apart), after = motion.displacement(*at + apart);
      const double rates = std::abs(motion.velocity(*at - apart)) + std::abs(motion.velocity(*at + apart));
      if (std::abs(after - before) > 16.0 * rates * apart + 1e-12 * (std::abs(before) + std::abs(after)))
        return Finding{fmt::format("{}.{}", key, is_obstacle(*condition) ? "gap" : "motion"),
                       fmt::format("jumps at t = {}, and characteristics does not follow it; use rigid", *at)};
    }
  }
  const double passages = end * std::sqrt(bar.modulus / bar.density) / bar.length;
  if (!(passages <= Characteristics::most_passages))
    return Finding{"time.end",
                   fmt::format("characteristics follows a wave from passage to passage through the bar, here {:.2g} of "
                               "them, at most {:.0g}; choose an earlier end",
                               passages, Characteristics::most_passages)};
  return std::nullopt;
}

}  // namespace viscobar
