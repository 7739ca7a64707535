#include "report/plot/axis.hpp"

#include <fmt/format.h>

#include "text/number.hpp"

namespace viscobar::plot {

namespace {

/// 1, 2 or 5 times a power of ten.
double rounded(double size) {
  const double power = std::pow(10.0, std::floor(std::log10(size))), ratio = size / power;
  return power * (ratio < 1.5 ? 1.0 : ratio < 3.5 ? 2.0 : ratio < 7.5 ? 5.0 : 10.0);
}

Ticks linear_ticks(const Axis& axis, int about) {
  const double range = axis.high - axis.low;
  const auto first = [&](double step) { return std::ceil(axis.low / step - 1e-9); };
  double step = rounded(range / about);
  // A single number tells no scale; a step below half of the range puts two into it.
  if ((first(step) + 1.0) * step > axis.high + 1e-9 * step) step = rounded(0.3 * range);
  const double largest = std::max(std::abs(axis.low), std::abs(axis.high));
  const int magnitude = static_cast<int>(std::floor(std::log10(largest)));
  Ticks result;
  if (magnitude >= 5 || magnitude <= -3) result.exponent = magnitude;
  const double factor = std::pow(10.0, -result.exponent);
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step * factor) - 1e-9)), 0, 12);
  for (double index = first(step); index * step <= axis.high + 1e-9 * step; ++index) {
    const double value = index * step;
    result.ticks.push_back(
        {value, with_true_minus(fmt::format("{:.{}f}", value == 0.0 ? 0.0 : value * factor, decimals))});
  }
  return result;
}

Ticks decade_ticks(const Axis& axis, int about) {
  const int first = static_cast<int>(std::floor(std::log10(axis.low) + 1e-9));
  const int last = static_cast<int>(std::ceil(std::log10(axis.high) - 1e-9));
  const int stride = std::max(1, (last - first + about - 1) / about);
  Ticks result;
  for (int decade = first; decade <= last; ++decade) {
    const double power = std::pow(10.0, decade);
    result.ticks.push_back({power, (decade - first) % stride == 0 ? power_of_ten(decade) : ""});
    if (stride == 1)
      for (int multiple = 2; multiple < 10; ++multiple) result.ticks.push_back({multiple * power, ""});
  }
  std::erase_if(result.ticks, [&](const Tick& tick) {
    return tick.value < axis.low * (1 - 1e-9) || tick.value > axis.high * (1 + 1e-9);
  });
  return result;
}

}  // namespace

double Axis::position(double value) const {
  return scale == Scale::linear ? (value - low) / (high - low) : std::log(value / low) / std::log(high / low);
}

int Axis::significant_digits(int digits) const {
  if (scale == Scale::logarithmic) return digits + 1;
  const double size = std::max(std::abs(low), std::abs(high)), range = std::abs(high - low);
  if (!(size > 0.0) || !(range > 0.0)) return digits + 1;
  const double needed = std::floor(std::log10(size)) + 1.0 - std::log10(range) + digits;
  return static_cast<int>(std::clamp(std::ceil(needed), 3.0, 17.0));
}

Axis fitted(std::string label, double low, double high) {
  const double size = std::max(std::abs(low), std::abs(high));
  // A range of rounding errors around a value shows the value.
  double margin = 0.05 * (high - low);
  if (high - low <= 1e-12 * size) margin = size > 0.0 ? 0.1 * size : 1.0;
  return {std::move(label), low - margin, high + margin, Scale::linear};
}

Axis fitted_decades(std::string label, double low, double high) {
  const double first = std::floor(std::log10(low) + 1e-9), last = std::ceil(std::log10(high) - 1e-9);
  return {std::move(label), std::pow(10.0, first), std::pow(10.0, std::max(last, first + 1)), Scale::logarithmic};
}

Ticks ticks(const Axis& axis, int about) {
  if (axis.bare) return {};
  return axis.scale == Scale::linear ? linear_ticks(axis, about) : decade_ticks(axis, about);
}

}  // namespace viscobar::plot
