#pragma once

#include <cmath>
#include <type_traits>

#include "input/interval.hpp"

namespace viscobar {

using std::cos, std::exp, std::log, std::sin, std::sqrt, std::tan;

inline bool is_zero(double a) { return a == 0.0; }

/// The value alone, which conditions look at.
inline double plain(double a) { return a; }

/// a b, where b = 0 makes 0 even of an infinite a: what does not change makes no derivative.
inline double times(double a, double b) { return b == 0.0 ? 0.0 : a * b; }
inline Interval times(Interval a, Interval b) { return a * b; }

/// f and f' with respect to one name, by the rules of calculus: they have the digits that a value has. Duals of duals
/// have further derivatives, each with respect to a name of its own; those of intervals are bounds.
template <class N>
struct Dual {
  using Part = N;
  N value, slope;
  Dual() = default;
  explicit Dual(double constant) : value(constant), slope() {}
  Dual(const N& f, const N& of_f) : value(f), slope(of_f) {}

  friend bool is_zero(const Dual& a) { return is_zero(a.value) && is_zero(a.slope); }
  friend double plain(const Dual& a) { return plain(a.value); }
  friend Dual times(const Dual& a, const Dual& b) {
    return {times(a.value, b.value), times(a.slope, b.value) + times(a.value, b.slope)};
  }

  friend Dual operator-(const Dual& a) { return {-a.value, -a.slope}; }
  friend Dual operator+(const Dual& a, const Dual& b) { return {a.value + b.value, a.slope + b.slope}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.value - b.value, a.slope - b.slope}; }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.slope * b.value + a.value * b.slope};
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const N value = a.value / b.value;
    return {value, (a.slope - value * b.slope) / b.value};
  }

  /// g(a), of g and g'.
  static Dual chain(const Dual& a, const N& g, const N& slope) { return {g, times(slope, a.slope)}; }
  friend Dual sin(const Dual& a) { return chain(a, sin(a.value), cos(a.value)); }
  friend Dual cos(const Dual& a) { return chain(a, cos(a.value), -sin(a.value)); }
  friend Dual tan(const Dual& a) { return chain(a, tan(a.value), N(1.0) + power(tan(a.value), N(2.0))); }
  friend Dual log(const Dual& a) { return chain(a, log(a.value), N(1.0) / a.value); }
  friend Dual sqrt(const Dual& a) { return chain(a, sqrt(a.value), N(0.5) / sqrt(a.value)); }
  friend Dual exp(const Dual& a) {
    const N value = exp(a.value);
    return chain(a, value, value);
  }
  /// A base 0 has a slope of 0 by the exponent, where the logarithm has no end.
  friend Dual power(const Dual& a, const Dual& b) {
    const N value = power(a.value, b.value);
    Dual result = chain(a, value, times(power(a.value, b.value - N(1.0)), b.value));
    if (!is_zero(b.slope) && !is_zero(value)) result.slope = result.slope + value * log(a.value) * b.slope;
    return result;
  }

  // Bounds do not always tell which side is taken.
  static constexpr bool bounds = std::is_same_v<N, Interval>;
  friend Dual abs(const Dual& a) {
    if constexpr (!bounds) return plain(a) < 0.0 ? -a : a;
    if constexpr (bounds) {
      if (a.value.low >= 0.0) return a;
      return a.value.high <= 0.0 ? -a : Dual(abs(a.value), hull(a.slope, -a.slope));
    }
  }
  friend Dual min(const Dual& a, const Dual& b) {
    if constexpr (!bounds) return plain(b) < plain(a) ? b : a;
    if constexpr (bounds) {
      if (a.value.high <= b.value.low) return a;
      return b.value.high <= a.value.low ? b : Dual(min(a.value, b.value), hull(a.slope, b.slope));
    }
  }
  friend Dual max(const Dual& a, const Dual& b) { return -min(-a, -b); }
};

/// Bounds of a function and of its derivative over an interval of x or t.
using Jet = Dual<Interval>;

/// 1 where a comparison holds, or && or ||, else 0.
template <class Condition, class N>
N compared(Condition holds, const N& a, const N& b) {
  return N(holds(plain(a), plain(b)));
}
template <class Condition, class N>
N joined(Condition holds, const N& a, const N& b) {
  return compared(holds, a, b);
}
template <class N>
const N& chosen(const N& condition, const N& then, const N& otherwise) {
  return plain(condition) != 0.0 ? then : otherwise;
}

/// A condition that does not move does not jump, though it may be true for some values of the other variable alone.
inline Jet of_truth(bool sure, Interval holds, bool rests) {
  return sure ? Jet(holds.low) : Jet({0.0, 1.0}, rests ? Interval{} : any_number);
}
template <class Comparison>
Jet compared(Comparison holds, const Jet& a, const Jet& b) {
  const Jet d = a - b;
  const Interval at_ends(holds(d.value.low, 0.0), holds(d.value.high, 0.0));
  const bool sure = at_ends.is(at_ends.low) && (!d.value.holds(0.0) || at_ends.is(holds(0.0, 0.0)));
  return of_truth(sure, at_ends, is_zero(d.slope));
}
template <class Junction>
Jet joined(Junction holds, const Jet& a, const Jet& b) {
  const Interval of_a = truth(a.value), of_b = truth(b.value);
  const Interval both(holds(of_a.low, of_b.low), holds(of_a.high, of_b.high));
  return of_truth(both.is(both.low), both, is_zero(a.slope) && is_zero(b.slope));
}
inline Jet chosen(const Jet& condition, const Jet& then, const Jet& otherwise) {
  const Interval holds = truth(condition.value);
  if (holds.is(holds.low)) return holds.is(1.0) ? then : otherwise;
  return {hull(then.value, otherwise.value), is_zero(condition.slope) ? hull(then.slope, otherwise.slope) : any_number};
}

}  // namespace viscobar
