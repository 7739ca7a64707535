#include "studies/limit/limit_fault.hpp"

#include <fmt/format.h>

namespace viscobar {

std::optional<Finding> limit_fault(const Scene& scene) {
  const auto of_stop = [](const std::optional<Stop>& stop, const std::string& where) -> std::optional<Finding> {
    if (!stop) return std::nullopt;
    return Finding{stop->key(where, "law"),
                   "limit studies the penalty, and this stop has a law of its own, which is no limit's; leave the law "
                   "out"};
  };
  if (auto left = of_stop(scene.left_input.stop, "left")) return left;
  if (auto right = of_stop(scene.right_input.stop, "right")) return right;
  for (std::size_t k = 1; k < scene.chain.size(); ++k)
    if (auto joint = of_stop(scene.chain[k - 1].joint.stop, fmt::format("joint.{}", k))) return joint;
  if (!meets_obstacle(scene)) return Finding{"", "the scene has no obstacle, so there is nothing to penalise"};
  return std::nullopt;
}

}  // namespace viscobar
