#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <optional>

namespace viscobar {

/// The numbers from low to high. What an operation does not know it takes for any number. Not rounded outwards: a bound
/// may be wrong by the rounding of the operations.
struct Interval {
  double low = 0.0, high = 0.0;
  bool is(double value) const { return low == value && high == value; }
  bool holds(double value) const { return low <= value && value <= high; }
};

inline constexpr Interval any_number{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};

inline Interval hull(std::initializer_list<double> values) {
  for (const double value : values)
    if (std::isnan(value)) return any_number;
  return {std::min(values), std::max(values)};
}
inline Interval hull(Interval a, Interval b) { return {std::min(a.low, b.low), std::max(a.high, b.high)}; }

/// The part that two bounds of one number share; the first one where roundings keep them apart.
inline Interval common(Interval a, Interval b) {
  const Interval result{std::max(a.low, b.low), std::min(a.high, b.high)};
  return result.low <= result.high ? result : a;
}

inline Interval operator+(Interval a, Interval b) { return hull({a.low + b.low, a.high + b.high}); }
inline Interval operator-(Interval a) { return {-a.high, -a.low}; }
inline Interval operator-(Interval a, Interval b) { return a + -b; }
inline Interval operator*(Interval a, Interval b) {
  if (a.is(0.0) || b.is(0.0)) return {};
  return hull({a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high});
}
inline Interval operator/(Interval a, Interval b) {
  if (b.holds(0.0)) return any_number;
  return hull({a.low / b.low, a.low / b.high, a.high / b.low, a.high / b.high});
}

inline Interval exp(Interval a) { return {std::exp(a.low), std::exp(a.high)}; }
inline Interval log(Interval a) { return a.low > 0.0 ? Interval{std::log(a.low), std::log(a.high)} : any_number; }
inline Interval sqrt(Interval a) {
  return a.high < 0.0 ? any_number : Interval{std::sqrt(std::max(a.low, 0.0)), std::sqrt(a.high)};
}
inline Interval abs(Interval a) {
  const Interval ends = hull({std::abs(a.low), std::abs(a.high)});
  return a.holds(0.0) ? Interval{0.0, ends.high} : ends;
}
inline Interval min(Interval a, Interval b) { return {std::min(a.low, b.low), std::min(a.high, b.high)}; }
inline Interval max(Interval a, Interval b) { return {std::max(a.low, b.low), std::max(a.high, b.high)}; }

/// Whether a + k period is in the interval for some whole k.
inline bool holds_multiple(Interval interval, double a, double period) {
  return a + std::ceil((interval.low - a) / period) * period <= interval.high;
}
inline Interval wave(Interval a, double (*function)(double), double peak) {
  constexpr double period = 2.0 * std::numbers::pi;
  if (!(a.high - a.low < period)) return {-1.0, 1.0};
  const Interval ends = hull({function(a.low), function(a.high)});
  return {holds_multiple(a, peak + std::numbers::pi, period) ? -1.0 : ends.low,
          holds_multiple(a, peak, period) ? 1.0 : ends.high};
}
inline Interval sin(Interval a) { return wave(a, std::sin, std::numbers::pi / 2); }
inline Interval cos(Interval a) { return wave(a, std::cos, 0.0); }
inline Interval tan(Interval a) {
  const bool pole = !(a.high - a.low < std::numbers::pi) || holds_multiple(a, std::numbers::pi / 2, std::numbers::pi);
  return pole ? any_number : hull({std::tan(a.low), std::tan(a.high)});
}

/// a^n for a whole n.
inline Interval power(Interval a, double n) {
  if (n < 0.0 && a.holds(0.0)) return any_number;
  const Interval ends = hull({std::pow(a.low, n), std::pow(a.high, n)});
  return n > 0.0 && std::fmod(n, 2.0) == 0.0 && a.holds(0.0) ? Interval{0.0, ends.high} : ends;
}

/// Bounds of a function of t and of its derivative over an interval of t.
struct Jet {
  Interval value, slope;
};

inline Jet operator-(const Jet& a) { return {-a.value, -a.slope}; }
inline Jet operator+(const Jet& a, const Jet& b) { return {a.value + b.value, a.slope + b.slope}; }
inline Jet operator-(const Jet& a, const Jet& b) { return {a.value - b.value, a.slope - b.slope}; }
inline Jet operator*(const Jet& a, const Jet& b) { return {a.value * b.value, a.slope * b.value + a.value * b.slope}; }
inline Jet operator/(const Jet& a, const Jet& b) {
  const Interval quotient = a.value / b.value;
  return {quotient, b.slope.is(0.0) ? a.slope / b.value : (a.slope - quotient * b.slope) / b.value};
}

inline Jet sin(const Jet& a) { return {sin(a.value), cos(a.value) * a.slope}; }
inline Jet cos(const Jet& a) { return {cos(a.value), -sin(a.value) * a.slope}; }
inline Jet tan(const Jet& a) {
  const Interval value = tan(a.value);
  return {value, (Interval{1.0, 1.0} + power(value, 2.0)) * a.slope};
}
inline Jet exp(const Jet& a) {
  const Interval value = exp(a.value);
  return {value, value * a.slope};
}
inline Jet log(const Jet& a) { return {log(a.value), a.slope.is(0.0) ? Interval{} : a.slope / a.value}; }
inline Jet sqrt(const Jet& a) {
  const Interval value = sqrt(a.value);
  return {value, a.slope.is(0.0) ? Interval{} : a.slope / (value + value)};
}
inline Jet abs(const Jet& a) {
  if (a.value.low >= 0.0) return a;
  return a.value.high <= 0.0 ? -a : Jet{abs(a.value), hull(a.slope, -a.slope)};
}
inline Jet min(const Jet& a, const Jet& b) {
  if (a.value.high <= b.value.low) return a;
  return b.value.high <= a.value.low ? b : Jet{min(a.value, b.value), hull(a.slope, b.slope)};
}
inline Jet max(const Jet& a, const Jet& b) { return -min(-a, -b); }
inline Jet power(const Jet& a, const Jet& b) {
  if (b.value.is(b.value.low) && b.slope.is(0.0) && b.value.low == std::trunc(b.value.low)) {
    const double n = b.value.low;
    const Interval factor = n == 0.0 ? Interval{} : Interval{n, n} * power(a.value, n - 1.0);
    return {power(a.value, n), factor * a.slope};
  }
  if (a.value.low < 0.0) return {any_number, any_number};
  const Interval value = hull({std::pow(a.value.low, b.value.low), std::pow(a.value.low, b.value.high),
                               std::pow(a.value.high, b.value.low), std::pow(a.value.high, b.value.high)});
  const Interval of_base = a.slope.is(0.0) ? Interval{} : b.value * a.slope / a.value;
  return {value, value * (b.slope * log(a.value) + of_base)};
}

/// Whether a number of the interval is true, that is not 0; nothing where some are and some are not.
inline std::optional<bool> truth(Interval a) {
  if (!a.holds(0.0)) return true;
  return a.is(0.0) ? std::optional(false) : std::nullopt;
}

}  // namespace viscobar
