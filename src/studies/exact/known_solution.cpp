#include "viscobar/studies/exact/known_solution.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "viscobar/studies/exact/exact_solutions.hpp"

namespace viscobar {

namespace {

// A prime number of places, so that no formula that repeats itself along the bar hides between them.
constexpr int places = 1009;

/// Whether g is the linear function between its values at 0 and L, up to the rounding of a formula.
bool linear(const SpaceFunction& g, double length) {
  const double a = g(0.0), b = g(length);
  const double rounding = 8.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(a), std::abs(b));
  for (int k = 1; k < places; ++k) {
    const double y = static_cast<double>(k) / places;
    if (!(std::abs(g(y * length) - (a + (b - a) * y)) <= rounding)) return false;
  }
  return true;
}

bool constant(const SpaceFunction& g, double length) { return linear(g, length) && g(0.0) == g(length); }

bool is_free(const EndCondition& end) { return std::holds_alternative<Free>(end); }

/// When a bar that moves as a whole from u = a at velocity v first touches.
double first_touch(const Scene& scene, double a, double v) {
  double first = std::numeric_limits<double>::infinity();
  const auto meet = [&](const Obstacle& obstacle) {
    if (obstacle.bounds(Side::below) && v < 0.0) first = std::min(first, (a + obstacle.gap) / -v);
    if (obstacle.bounds(Side::above) && v > 0.0) first = std::min(first, (obstacle.gap - a) / v);
  };
  for (const EndCondition& end : {scene.left, scene.right})
    if (const auto* obstacle = std::get_if<Obstacle>(&end)) meet(*obstacle);
  if (scene.span) meet(*scene.span);
  return first;
}

double sign_of(const Obstacle& obstacle) { return obstacle.side == Side::above ? -1.0 : 1.0; }

std::optional<KnownSolution> translation(const Scene& scene, double end) {
  const double length = scene.bar.length;
  for (const EndCondition& condition : {scene.left, scene.right})
    if (!is_free(condition) && !is_obstacle(condition)) return std::nullopt;
  if (!constant(scene.displacement, length) || !constant(scene.velocity, length)) return std::nullopt;
  const double a = scene.displacement(0.0), v = scene.velocity(0.0);
  if (end <= first_touch(scene, a, v))
    return KnownSolution{"rigid flight, u = u_0 + u_1 t", [=](double, double t) { return a + v * t; }};

  const bool left = is_obstacle(scene.left) && is_free(scene.right);
  const bool right = is_obstacle(scene.right) && is_free(scene.left);
  if (scene.bar.viscosity > 0.0 || scene.span || left == right) return std::nullopt;
  const Obstacle& obstacle = std::get<Obstacle>(left ? scene.left : scene.right);
  const double sign = sign_of(obstacle);
  const exact::ElasticImpact impact{scene.bar, -sign * v, sign * a + obstacle.gap};
  return KnownSolution{"elastic impact of an unstrained bar",
                       [=](double x, double t) { return a + sign * impact.u(left ? x : length - x, t); }};
}

std::optional<KnownSolution> period_three(const Scene& scene) {
  const Bar& bar = scene.bar;
  const bool left = is_obstacle(scene.left) && is_fixed(scene.right);
  const bool right = is_obstacle(scene.right) && is_fixed(scene.left);
  if (bar.viscosity > 0.0 || scene.span || left == right) return std::nullopt;
  if (!linear(scene.displacement, bar.length) || !constant(scene.velocity, bar.length)) return std::nullopt;
  const Obstacle& obstacle = std::get<Obstacle>(left ? scene.left : scene.right);
  const double sign = sign_of(obstacle), gap = obstacle.gap;
  const double contact = sign * scene.displacement(left ? 0.0 : bar.length);
  const double held = sign * scene.displacement(left ? bar.length : 0.0);
  if (scene.velocity(0.0) != 0.0 || held != -gap || !(contact > held)) return std::nullopt;
  const double crossing = bar.length / std::sqrt(bar.modulus / bar.density);
  return KnownSolution{"period-3 bar", [=, length = bar.length, height = contact - held](double x, double t) {
                         const double y = left ? x / length : 1.0 - x / length;
                         const double tau = std::fmod(t / crossing, 3.0);
                         double shape = std::min(1.0 - y, tau < 1.0 ? 1.0 - tau : tau - 2.0);
                         if (tau >= 1.0 && tau < 2.0) shape = -std::min({tau - 1.0, y, 1.0 - y, 2.0 - tau});
                         return sign * (height * shape - gap);
                       }};
}

}  // namespace

std::optional<KnownSolution> known_solution(const Scene& scene, double end) {
  if (scene.load) return std::nullopt;
  if (auto found = translation(scene, end)) return found;
  return period_three(scene);
}

}  // namespace viscobar
