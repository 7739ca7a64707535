#include "viscobar/scene/scene.hpp"

#include <fmt/format.h>

#include <cmath>

namespace viscobar {

namespace {

void require(std::vector<Finding>& findings, bool sound, std::string key, std::string problem) {
  if (!sound) findings.push_back({std::move(key), std::move(problem)});
}

void check_gap(std::vector<Finding>& findings, const std::string& table, const Obstacle& obstacle, const Scene& scene,
               double x) {
  if (!std::isfinite(obstacle.gap) || obstacle.gap < 0.0) {
    findings.push_back({table + ".gap", fmt::format("must be finite and not negative, is {}", obstacle.gap)});
    return;
  }
  const double u = scene.displacement ? scene.displacement(x) : 0.0;
  if (u < -obstacle.gap)
    findings.push_back({"initial.displacement", fmt::format("penetrates the obstacle of [{}]: u_0({}) = {} < -gap = {}",
                                                            table, x, u, -obstacle.gap)});
}

}  // namespace

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
  if (const auto* left = std::get_if<Obstacle>(&scene.left)) check_gap(findings, "left", *left, scene, 0.0);
  if (const auto* right = std::get_if<Obstacle>(&scene.right)) check_gap(findings, "right", *right, scene, bar.length);
  if (scene.span)
    require(findings, std::isfinite(scene.span->gap) && scene.span->gap >= 0.0, "span.gap",
            fmt::format("must be finite and not negative, is {}", scene.span->gap));
  return findings;
}

}  // namespace viscobar
