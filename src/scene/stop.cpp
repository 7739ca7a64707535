#include "viscobar/scene/stop.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

namespace viscobar {

namespace {

/// How a law damps: not at all, beside its spring, or in proportion to the force of that.
enum class Damper { none, beside, proportional };

/// All that is said about one law: N = k d^n + c d', or k d^n (1 + lambda d').
struct LawRow {
  std::string_view name, meaning;
  double power;  ///< n
  Damper damper;
};

constexpr LawRow rows[] = {
    {"spring_damper", "a spring and a damper beside it, k d + c d', which open where the force is zero", 1.0,
     Damper::beside},
    {"hertz", "k d^(3/2), a round body pressed on a plane [Hertz 1881]", 1.5, Damper::none},
    {"hunt_crossley", "k d^(3/2) (1 + lambda d'), with damping in proportion to the force", 1.5, Damper::proportional},
};
static_assert(std::size(rows) == std::size(all_laws));

const LawRow& row(Law law) { return rows[static_cast<std::size_t>(law)]; }

// |d|^n with the sign of d, and its derivative.
double power(double depth, double n) { return n == 1.0 ? depth : std::copysign(std::pow(std::abs(depth), n), depth); }
double power_rate(double depth, double n) { return n == 1.0 ? 1.0 : n * std::pow(std::abs(depth), n - 1.0); }

}  // namespace

std::string_view name(Law law) { return row(law).name; }
std::string_view meaning(Law law) { return row(law).meaning; }
bool has_damper(Law law) { return row(law).damper != Damper::none; }

std::string Stop::key(std::string_view end, std::string_view leaf) const {
  if (shared) return fmt::format("contact.{}", leaf);
  return fmt::format("{}{}.{}", end, end.starts_with("joint.") ? "" : ".contact", leaf);
}

bool Stop::linear() const { return row(law).power == 1.0 && row(law).damper != Damper::proportional; }

double Stop::force(double depth, double rate) const {
  const auto& [name, meaning, n, damper] = row(law);
  const double spring = stiffness * power(depth, n);
  if (damper == Damper::proportional) return spring * (1.0 + damping * rate);
  return damper == Damper::beside ? spring + damping * rate : spring;
}

double Stop::by_depth(double depth, double rate) const {
  const double slope = stiffness * power_rate(depth, row(law).power);
  return row(law).damper == Damper::proportional ? slope * (1.0 + damping * rate) : slope;
}

double Stop::by_rate(double depth, double /*rate*/) const {
  const auto& [name, meaning, n, damper] = row(law);
  if (damper == Damper::proportional) return damping * stiffness * power(depth, n);
  return damper == Damper::beside ? damping : 0.0;
}

double Stop::by_stiffness(double depth, double rate) const {
  const double spring = power(depth, row(law).power);
  return row(law).damper == Damper::proportional ? spring * (1.0 + damping * rate) : spring;
}

double Stop::by_damping(double depth, double rate) const {
  const auto& [name, meaning, n, damper] = row(law);
  if (damper == Damper::proportional) return stiffness * power(depth, n) * rate;
  return damper == Damper::beside ? rate : 0.0;
}

double Stop::energy(double depth) const {
  const double n = row(law).power;
  return depth > 0.0 ? stiffness * depth * power(depth, n) / (n + 1.0) : 0.0;
}

std::optional<Stop::Push> Stop::push(double time) const {
  if (damping == 0.0 || !has_damper(law)) return std::nullopt;
  if (row(law).damper == Damper::proportional) return Push{0.0, time, time / damping};
  return Push{1.0, damping / stiffness, 0.0};
}

Stop::Push Stop::push_rate(double time, const Stop& rates) const {
  if (row(law).damper == Damper::proportional) return {0.0, 0.0, -time * rates.damping / (damping * damping)};
  return {0.0, (rates.damping - rates.stiffness * damping / stiffness) / stiffness, 0.0};
}

}  // namespace viscobar
