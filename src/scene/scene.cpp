#include "viscobar/scene/scene.hpp"

#include <fmt/format.h>

#include <cmath>

#include "scene/bound_text.hpp"
#include "scene/end_kinds.hpp"

namespace viscobar {

namespace {

void require(std::vector<Finding>& findings, bool sound, std::string key, std::string problem) {
  if (!sound) findings.push_back({std::move(key), std::move(problem)});
}

void check_end(std::vector<Finding>& findings, const std::string& table, const Scene& scene, EndCondition end,
               double x) {
  const std::size_t before = findings.size();
  for (const EndNumber& number : end_kind(end).numbers) {
    const double value = number.of(end);
    require(findings, value >= number.low && value <= number.high, fmt::format("{}.{}", table, number.key),
            fmt::format("must be finite and {}, is {}", number.range, value));
  }
  if (findings.size() != before) return;
  const double u = scene.displacement ? scene.displacement(x) : 0.0;
  const auto obstacle = end_node(end, u).obstacle;
  if (!obstacle) return;
  require(findings, obstacle->side != Side::both, table + ".side",
          "is \"both\", which only a span can be; an end has one obstacle, below or above");
  if (obstacle->depth(u) > 0.0)
    findings.push_back({"initial.displacement", fmt::format("penetrates the obstacle of [{}]: u_0({}) = {} {}", table,
                                                            x, u, bound_text(*obstacle, u))});
}

}  // namespace

std::string_view name(Side side) {
  constexpr std::string_view names[] = {"below", "above", "both"};
  return names[static_cast<std::size_t>(side)];
}

std::vector<Finding> validate(const Scene& scene) {
  std::vector<Finding> findings;
  const Bar& bar = scene.bar;
  const auto positive = [&](const char* key, double value) {
    require(findings, std::isfinite(value) && value > 0.0, key,
            fmt::format("must be positive and finite, is {}", value));
  };
  positive("bar.length", bar.length);
  positive("bar.density", bar.density);
  positive("bar.modulus", bar.modulus);
  require(findings, std::isfinite(bar.viscosity) && bar.viscosity >= 0.0, "bar.viscosity",
          fmt::format("must be finite and not negative, is {}", bar.viscosity));
  check_end(findings, "left", scene, scene.left, 0.0);
  check_end(findings, "right", scene, scene.right, bar.length);
  if (scene.span)
    require(findings, std::isfinite(scene.span->gap) && scene.span->gap >= 0.0, "span.gap",
            fmt::format("must be finite and not negative, is {}", scene.span->gap));
  return findings;
}

}  // namespace viscobar
