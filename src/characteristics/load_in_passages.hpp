#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar::characteristics {

inline constexpr double sums = 8.0;  // roundings that a sum of some dozens of terms adds up

// Of a load at `place`, which says where and when.
inline double finite(double t, auto&& load, auto&& place) {
  double value = 0.0;
  try {
    value = load();
  } catch (const std::exception& error) {
    throw LoadError(t, fmt::format("{} cannot be evaluated: {}", place(), error.what()));
  }
  if (!std::isfinite(value))
    throw LoadError(t, fmt::format("{} is {}", place(), std::isnan(value) ? "not a number" : "infinite"));
  return value;
}

// The bar, in lengths of it and in passages.
struct Frame {
  double length, passage, start, factor;  // factor: L / (rho c)
  double x(double place) const { return length * place; }
  double t(double time) const { return start + passage * time; }
};

// Breaks of a load in time, in passages, of the present passage and the one before.
class Breaks {
 public:
  Breaks(NextBreak next, const Frame& frame) : next_(std::move(next)), frame_(frame) {}

  void enter(std::size_t passage) {
    const auto begin = static_cast<double>(passage);
    std::erase_if(times_, [&](double time) { return time < begin - 1.0; });
    if (passage == 0) times_.push_back(0.0);  // there the load begins
    if (!next_) return;
    const double until = frame_.t(begin + 1.0);
    const double apart = 64.0 * rounding * std::max(std::abs(until), std::abs(frame_.start));
    double after = frame_.t(begin) - (passage == 0 ? 0.0 : apart);
    for (std::size_t count = 0;; ++count) {
      const std::optional<double> at = next_(after, until);
      if (!at) return;
      if (count == most_breaks)
        throw LoadError(*at, fmt::format("the load breaks more than {} times in a passage of the wave", most_breaks));
      after = *at + apart;
      const double time = (*at - frame_.start) / frame_.passage;
      if (times_.empty() || time > times_.back()) times_.push_back(time);
    }
  }
  std::span<const double> times() const { return times_; }

 private:
  static constexpr std::size_t most_breaks = 10'000;  // of a load, in one passage

  NextBreak next_;
  Frame frame_;
  std::vector<double> times_;
};

}  // namespace viscobar::characteristics
