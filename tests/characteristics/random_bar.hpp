#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "viscobar/scene/scene.hpp"

namespace viscobar::oracle {

/// Random undamped bars whose data are polynomials, or such with kinks and jumps.
class RandomBar {
 public:
  explicit RandomBar(std::uint32_t seed) : random_(seed) {}

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  int one_of(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }

  /// Continuous, of size 1: a polynomial in x / length, bent at up to two places.
  SpaceFunction bent(double length) {
    const std::vector<double> c = coefficients();
    std::vector<double> places, bends;
    for (int k = one_of(3); k > 0; --k) places.push_back(uniform(0.05, 0.95)), bends.push_back(uniform(-2.0, 2.0));
    return [=](double x) {
      const double s = x / length;
      double sum = polynomial(c, s);
      for (std::size_t k = 0; k < places.size(); ++k) sum += bends[k] * std::max(0.0, s - places[k]);
      return sum;
    };
  }
  /// The same with jumps.
  SpaceFunction broken(double length) {
    const SpaceFunction smooth = bent(length);
    std::vector<double> places, jumps;
    for (int k = one_of(3); k > 0; --k) places.push_back(uniform(0.05, 0.95)), jumps.push_back(uniform(-1.0, 1.0));
    return [=](double x) {
      double sum = smooth(x);
      for (std::size_t k = 0; k < places.size(); ++k) sum += x > places[k] * length ? jumps[k] : 0.0;
      return sum;
    };
  }

  enum class Loads { none, any };
  Scene scene(Loads loads) {
    Scene scene;
    scene.bar = {uniform(0.3, 3.0), uniform(0.3, 3.0), uniform(0.3, 3.0), 0.0};
    const double length = scene.bar.length;
    SpaceFunction u = bent(length);
    scene.velocity = broken(length);
    const auto end = [&](double displacement) -> EndCondition {
      switch (one_of(4)) {
        case 0: return Free{};
        case 1: return Fixed{};
        default: return Obstacle{std::max(0.0, -displacement) + (one_of(3) == 0 ? 0.0 : uniform(0.0, 1.0))};
      }
    };
    scene.left = end(u(0.0));
    scene.right = end(u(length));
    scene.displacement = u;
    if (loads == Loads::none) return scene;
    const SpaceFunction profile = broken(length);
    const double frequency = uniform(0.5, 5.0), pull = uniform(-2.0, 0.0), speed = uniform(-2.0, 2.0);
    switch (one_of(5)) {
      case 0: break;
      case 1: scene.load = SteadyLoad{[=](double x) { return profile(x) + pull; }}; break;
      case 2: scene.load = SeparableLoad{profile, [=](double t) { return std::cos(frequency * t) + pull; }}; break;
      case 3: {
        const double on = uniform(0.0, 3.0), off = on + uniform(0.1, 2.0);
        scene.load = SeparableLoad{profile, [=](double t) { return on < t && t < off ? 2.0 : pull; },
                                   [=](double after, double until) -> std::optional<double> {
                                     for (const double at : {on, off})
                                       if (at > after && at < until) return at;
                                     return std::nullopt;
                                   }};
        break;
      }
      default:
        scene.load = GeneralLoad{[=](double x, double t) { return std::sin(frequency * (x - speed * t)) + pull; }};
    }
    return scene;
  }

 private:
  std::vector<double> coefficients() {
    std::vector<double> c(1 + static_cast<std::size_t>(one_of(5)));
    for (double& one : c) one = uniform(-1.0, 1.0);
    return c;
  }
  static double polynomial(const std::vector<double>& c, double s) {
    double sum = 0.0;
    for (std::size_t k = c.size(); k-- > 0;) sum = sum * s + c[k];
    return sum;
  }

  std::mt19937 random_;
};

}  // namespace viscobar::oracle
