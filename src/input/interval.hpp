#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>

namespace viscobar {

/// The numbers from low to high. What an operation does not know it takes for any number. Not rounded outwards: a bound
/// may be wrong by the rounding of the operations.
struct Interval {
  double low, high;
  Interval() = default;
  explicit constexpr Interval(double value) : low(value), high(value) {}
  constexpr Interval(double from, double to) : low(from), high(to) {}
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

inline bool is_zero(Interval a) { return a.is(0.0); }
inline Interval operator+(Interval a, Interval b) { return hull({a.low + b.low, a.high + b.high}); }
inline Interval operator-(Interval a) { return {-a.high, -a.low}; }
inline Interval operator-(Interval a, Interval b) { return a + -b; }
inline Interval operator*(Interval a, Interval b) {
  if (is_zero(a) || is_zero(b)) return {};
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

/// True if a + k period is in the interval for some whole k.
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

/// A square rounds less than a power of the library, and takes a tenth of its time.
inline double power(double a, double b) { return b == 2.0 ? a * a : b == 1.0 ? a : std::pow(a, b); }

inline Interval power(Interval a, Interval b) {
  const double n = b.low;
  if (b.is(n) && n == std::trunc(n)) {
    if (n < 0.0 && a.holds(0.0)) return any_number;
    const Interval ends = hull({power(a.low, n), power(a.high, n)});
    return n > 0.0 && n / 2.0 == std::trunc(n / 2.0) && a.holds(0.0) ? Interval{0.0, ends.high} : ends;
  }
  if (a.low < 0.0) return any_number;
  return hull({power(a.low, b.low), power(a.low, b.high), power(a.high, b.low), power(a.high, b.high)});
}

/// 1 where all numbers of the interval are true, that is not 0, 0 where none is, and both where some are.
inline Interval truth(Interval a) { return {a.holds(0.0) ? 0.0 : 1.0, a.is(0.0) ? 0.0 : 1.0}; }

}  // namespace viscobar
