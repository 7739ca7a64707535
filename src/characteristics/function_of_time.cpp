#include "characteristics/function_of_time.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "characteristics/piecewise_fit.hpp"

namespace viscobar::characteristics {

namespace {

/// A polynomial and its derivatives on an interval.
struct Piece {
  double begin, end;  // where it holds,
  double middle, half;
  Chebyshev of[3];

  double operator()(double t, std::size_t order) const {
    return of[order](std::clamp((t - middle) / half, -1.0, 1.0)) / std::pow(half, static_cast<double>(order));
  }
};

Piece piece_of(double begin, double end, double from, double to, const Chebyshev& p) {
  Piece piece{begin, end, 0.5 * (from + to), 0.5 * (to - from), {p, p.derivative(), {}}};
  piece.of[2] = piece.of[1].derivative();
  return piece;
}

FunctionOfTime moved_by(std::vector<Piece> pieces) {
  double size = 0.0, speed = 0.0;
  for (const Piece& piece : pieces) {
    size = std::max({size, std::abs(piece(piece.begin, 0)), std::abs(piece(piece.end, 0))});
    speed = std::max(
        {speed, std::abs(piece(piece.begin, 1)), std::abs(piece(piece.end, 1)), piece.of[1].bound() / piece.half});
  }
  std::vector<double> breaks;
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    const double at = pieces[i].begin;
    const auto jump = [&](std::size_t order) { return std::abs(pieces[i](at, order) - pieces[i - 1](at, order)); };
    if (jump(0) > 1e-10 * size || jump(1) > 1e-7 * speed) breaks.push_back(at);
  }
  const auto shared = std::make_shared<const std::vector<Piece>>(std::move(pieces));
  const auto at = [](const std::vector<Piece>& all, double t, std::size_t order) {
    const auto after = std::upper_bound(all.begin() + 1, all.end(), t,
                                        [](double time, const Piece& piece) { return time < piece.begin; });
    return (*(after - 1))(t, order);
  };
  const double start = at(*shared, 0.0, 0), speed_at_start = at(*shared, 0.0, 1), rate = at(*shared, 0.0, 2);
  // The run looks for a jump at the start, where roundings of f would be one: there by Taylor's series.
  const double early = 1e-9 * shared->back().end;
  EndMotion motion{
      [=](double t) { return t < early ? (speed_at_start + 0.5 * rate * t) * t : at(*shared, t, 0) - start; },
      [=](double t) { return t < early ? speed_at_start + rate * t : at(*shared, t, 1); },
      [=](double t) { return at(*shared, t, 2); },
      {}};
  if (!breaks.empty())
    motion.breaks = [breaks = std::move(breaks)](double after, double until) -> std::optional<double> {
      const auto next = std::upper_bound(breaks.begin(), breaks.end(), after);
      return next != breaks.end() && *next < until ? std::optional(*next) : std::nullopt;
    };
  return {start, std::move(motion)};
}

double sound(double value, double t) {
  if (!std::isfinite(value)) throw std::invalid_argument(fmt::format("is {} at t = {}", value, t));
  return value;
}

}  // namespace

FunctionOfTime function_through(const TimeFunction& f, double end, double window) {
  constexpr double most_windows = 1e4;
  const auto windows = static_cast<std::size_t>(std::clamp(std::ceil(end / window), 1.0, most_windows));
  const double length = end / static_cast<double>(windows);
  std::vector<Piece> pieces;
  PiecewiseFit fit;
  for (std::size_t w = 0; w < windows; ++w) {
    const double begin = length * static_cast<double>(w);
    const auto at = [&](double s) { return begin + length * s; };
    const std::function<double(double)> of_s = [&](double s) { return sound(f(at(s)), at(s)); };
    const Piecewise& found = [&]() -> const Piecewise& {
      try {
        return fit.of(of_s, {.argument = static_cast<double>(w) + 1.0, .what = "it"});
      } catch (const StepFailure& failure) {
        throw std::invalid_argument(
            fmt::format("cannot be followed from t = {:.6g} to {:.6g}: {}", begin, begin + length, failure.what()));
      }
    }();
    for (std::size_t i = 0; i < found.size(); ++i)
      pieces.push_back(piece_of(at(found[i].begin), at(found[i].end), at(found[i].middle - found[i].half),
                                at(found[i].middle + found[i].half), found.polynomial(i)));
  }
  return moved_by(std::move(pieces));
}

}  // namespace viscobar::characteristics
