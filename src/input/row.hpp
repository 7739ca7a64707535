#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "input/interval.hpp"

namespace viscobar {

/// A formula's values at many x side by side, or the one value of what does not use x. Each operation is that of a
/// number, so that a value has the digits that it has alone.
struct Row {
  static constexpr std::size_t count = 32;

  std::array<double, count> values;
  bool same;  ///< the first value is that of all

  Row() = default;
  explicit Row(double value) : same(true) { values[0] = value; }

  friend Row each(auto&& f, const Row& a) {
    Row of;
    of.same = a.same;
    if (a.same)
      of.values[0] = f(a.values[0]);
    else
      for (std::size_t i = 0; i < count; ++i) of.values[i] = f(a.values[i]);
    return of;
  }
  friend Row each(auto&& f, const Row& a, const Row& b) {
    if (b.same) return each([&f, second = b.values[0]](double first) { return f(first, second); }, a);
    if (a.same) return each([&f, first = a.values[0]](double second) { return f(first, second); }, b);
    Row of;
    of.same = false;
    for (std::size_t i = 0; i < count; ++i) of.values[i] = f(a.values[i], b.values[i]);
    return of;
  }

  friend Row operator-(const Row& a) {
    return each([](double x) { return -x; }, a);
  }
  friend Row operator+(const Row& a, const Row& b) {
    return each([](double x, double y) { return x + y; }, a, b);
  }
  friend Row operator-(const Row& a, const Row& b) {
    return each([](double x, double y) { return x - y; }, a, b);
  }
  friend Row operator*(const Row& a, const Row& b) {
    return each([](double x, double y) { return x * y; }, a, b);
  }
  friend Row operator/(const Row& a, const Row& b) {
    return each([](double x, double y) { return x / y; }, a, b);
  }
  friend Row power(const Row& a, const Row& b) {
    return each([](double x, double y) { return viscobar::power(x, y); }, a, b);
  }
  friend Row min(const Row& a, const Row& b) {
    return each([](double x, double y) { return std::min(x, y); }, a, b);
  }
  friend Row max(const Row& a, const Row& b) {
    return each([](double x, double y) { return std::max(x, y); }, a, b);
  }
  friend Row sin(const Row& a) {
    return each([](double x) { return std::sin(x); }, a);
  }
  friend Row cos(const Row& a) {
    return each([](double x) { return std::cos(x); }, a);
  }
  friend Row tan(const Row& a) {
    return each([](double x) { return std::tan(x); }, a);
  }
  friend Row exp(const Row& a) {
    return each([](double x) { return std::exp(x); }, a);
  }
  friend Row log(const Row& a) {
    return each([](double x) { return std::log(x); }, a);
  }
  friend Row sqrt(const Row& a) {
    return each([](double x) { return std::sqrt(x); }, a);
  }
  friend Row abs(const Row& a) {
    return each([](double x) { return std::abs(x); }, a);
  }

  friend Row compared(auto holds, const Row& a, const Row& b) {
    return each([holds](double x, double y) { return holds(x, y) ? 1.0 : 0.0; }, a, b);
  }
  friend Row joined(auto holds, const Row& a, const Row& b) { return compared(holds, a, b); }
  friend Row chosen(const Row& condition, const Row& then, const Row& otherwise) {
    if (condition.same) return condition.values[0] != 0.0 ? then : otherwise;
    Row of;
    of.same = false;
    for (std::size_t i = 0; i < count; ++i) {
      const Row& taken = condition.values[i] != 0.0 ? then : otherwise;
      of.values[i] = taken.values[taken.same ? 0 : i];
    }
    return of;
  }
};

}  // namespace viscobar
