#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "viscobar/case/recording.hpp"

namespace viscobar {

/// A free bar, rho = E = L = 1, with random data in x and t that have kinks, jumps, patches, pulses and short waves,
/// and its exact motion by the cosine series,
///
///     a_k'' + eta w a_k' + w a_k = f_k g(t),    w = (k pi)^2,    u = sum a_k cos(k pi x).
///
/// The remainder of the series of u_0 fades as exp(-t/eta), up to 1/(eta^2 w), and is added.
class BrokenData {
 public:
  explicit BrokenData(unsigned seed) : random_(seed) {
    viscosity_ = std::pow(10.0, uniform(-2.0, 0.0));
    end_ = uniform(0.5, 4.0);
    if (chance(0.5))
      grid_ = std::array{10.0, 16.0, 20.0, 50.0, 100.0}[std::uniform_int_distribution<std::size_t>(0, 4)(random_)];
    if (chance(0.3)) add_tent();
    if (chance(0.6) || displacement_.empty()) add_velocity();
    if (chance(0.5)) add_load();
    error = std::pow(10.0, uniform(-4.5, -2.0));
    whole_ = chance(0.5);
  }

  double error;  ///< asked for

  std::string text() const {
    std::string all = fmt::format("[bar]\nlength = 1.0\nviscosity = {}\n[initial]\n", viscosity_);
    if (!displacement_.empty()) all += "displacement = \"" + displacement_ + "\"\n";
    all += "velocity = \"" + (velocity_.empty() ? "0" : velocity_) + "\"\n";
    if (!load_.empty())
      all += whole_ ? fmt::format("[load]\ndensity = \"({})*({})\"\n", load_, history_)
                    : fmt::format("[load]\nprofile = \"{}\"\nhistory = \"{}\"\n", load_, history_);
    return all + fmt::format("[time]\nend = {}\n[accuracy]\nerror = {}\n", end_, error);
  }

  /// The largest error of the displacement of a recording at eight places, from a fifth of its times on.
  double wrong(const Recording& recording) const {
    const std::size_t last = recording.mesh.elements;
    double worst = 0.0;
    for (std::size_t i = 0; i <= 7; ++i) {
      const std::size_t node = i * last / 7;
      const double x = recording.mesh.node(node);
      std::vector<double> cosines(modes);
      for (std::size_t k = 0; k < modes; ++k) cosines[k] = std::cos(std::numbers::pi * static_cast<double>(k) * x);
      for (std::size_t n = recording.times.size() / 5; n < recording.times.size(); n += 8)
        worst = std::max(worst, std::abs(at(x, cosines, recording.times[n]) - recording.displacement(n)[node]));
    }
    return worst;
  }

 private:
  static constexpr std::size_t modes = 1500;
  struct Coefficients {
    std::vector<double> of = std::vector<double>(modes);
    void add_box(double a, double b, double height) {
      of[0] += height * (b - a);
      for (std::size_t k = 1; k < modes; ++k) {
        const double w = std::numbers::pi * static_cast<double>(k);
        of[k] += 2.0 * height * (std::sin(w * b) - std::sin(w * a)) / w;
      }
    }
    void add_tent(double middle, double half, double slope) {
      of[0] += slope * half * half;
      for (std::size_t k = 1; k < modes; ++k) {
        const double w = std::numbers::pi * static_cast<double>(k);
        of[k] -= 2.0 * slope *
                 (std::cos(w * (middle - half)) - 2.0 * std::cos(w * middle) + std::cos(w * (middle + half))) / (w * w);
      }
    }
    void add_pulse(double middle, double width, double height) {
      const double area = height * width * std::sqrt(std::numbers::pi);
      of[0] += area;
      for (std::size_t k = 1; k < modes; ++k) {
        const double w = std::numbers::pi * static_cast<double>(k);
        of[k] += 2.0 * area * std::exp(-w * w * width * width / 4.0) * std::cos(w * middle);
      }
    }
  };

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  bool chance(double share) { return uniform(0.0, 1.0) < share; }
  // Half of the scenes break at round places, which meshes may have nodes at.
  double place(double low, double high) { return rounded(uniform(low, high)); }
  double rounded(double x) const { return grid_ > 0.0 ? std::max(1.0, std::round(x * grid_)) / grid_ : x; }
  double width() { return std::pow(10.0, uniform(-2.5, -0.7)); }

  void add_tent() {
    tent_half_ = place(0.05, 0.25);
    tent_middle_ = place(tent_half_, 1.0 - tent_half_);
    tent_slope_ = uniform(-1.0, 1.0);
    displacement_ = fmt::format("{}*max(0, {} - abs(x - {}))", tent_slope_, tent_half_, tent_middle_);
    u_0.add_tent(tent_middle_, tent_half_, tent_slope_);
  }
  // A box, a pulse or a wave beside a constant.
  std::string shape(Coefficients& of) {
    const double height = uniform(-2.0, 2.0);
    switch (std::uniform_int_distribution(0, 3)(random_)) {
      case 0: {
        const double b = place(0.35, 0.95), a = place(0.05, 0.3);
        of.add_box(a, b, height);
        return fmt::format("x > {} && x < {} ? {} : 0", a, b, height);
      }
      case 1: {
        const double size = rounded(width()), a = place(0.05, 0.75), strong = height * 0.2 / size;
        of.add_box(a, a + size, strong);
        return fmt::format("x > {} && x < {} ? {} : 0", a, a + size, strong);
      }
      case 2: {
        const double size = width() / 10.0, middle = uniform(0.2, 0.8), strong = height * 0.1 / size;
        of.add_pulse(middle, size, strong);
        return fmt::format("{}*exp(-((x - {})/{})^2)", strong, middle, size);
      }
      default: {
        const int wave = 1 << std::uniform_int_distribution(1, 7)(random_);
        of.of[0] += height;
        of.of[static_cast<std::size_t>(wave)] += height;
        return fmt::format("{}*(1 + cos({}*pi*x))", height, wave);
      }
    }
  }
  void add_velocity() { velocity_ = shape(u_1); }
  void add_load() {
    load_ = shape(f);
    switch (std::uniform_int_distribution(0, 2)(random_)) {
      case 0:
        history_ = "1";
        steps_ = {{0.0, 1.0}};
        break;
      case 1: {
        const double a = uniform(0.0, 0.4) * end_, b = a + std::pow(10.0, uniform(-2.0, -0.5)) * end_;
        history_ = fmt::format("t > {} && t < {} ? 1 : 0", a, b);
        steps_ = {{a, 1.0}, {b, -1.0}};
        break;
      }
      default: {
        // A smooth pulse, as the 160 impulses of its middle rule, which converges like exp(-(pi s/h)^2).
        const double size = std::pow(10.0, uniform(-4.0, -1.5)) * end_, middle = uniform(0.2, 0.7) * end_;
        history_ = fmt::format("{}*exp(-((t - {})/{})^2)", 0.1 / size, middle, size);
        for (int i = -80; i < 80; ++i) {
          const double s = (i + 0.5) / 80.0 * 6.0;
          if (middle + s * size > 0.0) impulses_.push_back({middle + s * size, 0.1 * std::exp(-s * s) * 6.0 / 80.0});
        }
      }
    }
  }

  struct Response {
    double kept, thrown, pushed;  // of a displacement, of a velocity, of a force since then
  };
  Response response(std::size_t k, double t) const {
    if (k == 0) return {1.0, t, t * t / 2.0};
    const double w = std::pow(std::numbers::pi * static_cast<double>(k), 2.0), decay = viscosity_ * w / 2.0;
    const double square = decay * decay - w;
    Response r{};
    if (square > 0.0) {
      const double root = std::sqrt(square), fast = -decay - root, slow = w / fast;
      const double of_fast = std::exp(fast * t), of_slow = std::exp(slow * t);
      r.thrown = (of_slow - of_fast) / (2.0 * root);
      r.kept = (slow * of_fast - fast * of_slow) / (2.0 * root);
    } else {
      const double root = std::sqrt(-square), fading = std::exp(-decay * t);
      r.thrown = fading * (root == 0.0 ? t : std::sin(root * t) / root);
      r.kept = fading * std::cos(root * t) + decay * r.thrown;
    }
    r.pushed = (1.0 - r.kept) / w;
    return r;
  }

  double at(double x, const std::vector<double>& cosines, double t) const {
    double sum = 0.0, start = 0.0;
    const bool loaded = !load_.empty();
    for (std::size_t k = 0; k < modes; ++k) {
      const Response r = response(k, t);
      double a = u_0.of[k] * r.kept + u_1.of[k] * r.thrown;
      if (loaded) {
        for (const auto& [since, size] : steps_)
          if (t > since) a += f.of[k] * size * response(k, t - since).pushed;
        for (const auto& [when, size] : impulses_)
          if (t > when) a += f.of[k] * size * response(k, t - when).thrown;
      }
      sum += a * cosines[k];
      start += u_0.of[k] * cosines[k];
    }
    const double whole = tent_slope_ * std::max(0.0, tent_half_ - std::abs(x - tent_middle_));
    return sum + (whole - start) * std::exp(-t / viscosity_);
  }

  std::mt19937 random_;
  double grid_ = 0.0;  // of places
  double viscosity_ = 1.0, end_ = 1.0, tent_middle_ = 0.0, tent_half_ = 0.0, tent_slope_ = 0.0;
  std::string displacement_, velocity_, load_, history_;
  bool whole_ = false;  // true if the load is written as one function of x and t
  struct Event {
    double time, size;
  };
  std::vector<Event> steps_, impulses_;
  Coefficients u_0, u_1, f;
};

}  // namespace viscobar
