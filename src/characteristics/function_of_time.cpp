#include "characteristics/function_of_time.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
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

/// The number next to zero where all have one sign, else 0.
double least_of(std::initializer_list<double> all) {
  const auto [low, high] = std::minmax(all);
  return low > 0.0 ? low : high < 0.0 ? high : 0.0;
}

/// Limits the slopes m of a cubic spline through y(t): it rises, falls and stays where the samples do, and does not
/// swing beside a jump or a kink. Between chords of slopes d and d' that is so where m has their sign and is at most
/// 3 min(|d|, |d'|) [Fritsch and Carlson 1980]. It may leave that where the samples bend one way over five intervals
/// alike, as those of a smooth function do at a maximum: then it is no further from the parabolas of both sides than
/// they bend.
void limit_slopes(std::span<const double> t, std::span<const double> y, std::vector<double>& m) {
  constexpr double alike = 4.0;
  const std::size_t n = t.size();
  const auto length = [&](std::size_t i) { return t[i + 1] - t[i]; };
  const auto chord = [&](std::size_t i) { return (y[i + 1] - y[i]) / length(i); };
  // By how much slopes change over half of the i-th interval at least, 0 where the samples beside it do not bend alike.
  const auto bend = [&](std::size_t i) {
    double least = std::numeric_limits<double>::infinity(), sign = 0.0, shortest = length(i), longest = length(i);
    for (std::size_t k = std::max<std::size_t>(i, 2) - 1; k <= std::min(i + 2, n - 2); ++k) {
      const double second = (chord(k) - chord(k - 1)) / (t[k + 1] - t[k - 1]);
      if (sign * second < 0.0) return 0.0;
      sign = std::copysign(1.0, second);
      least = std::min(least, std::abs(second));
      shortest = std::min({shortest, length(k - 1), length(k)});
      longest = std::max({longest, length(k - 1), length(k)});
    }
    return longest <= alike * shortest ? sign * least * length(i) : 0.0;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = i > 0 ? i - 1 : 0, behind = std::min(i, n - 2);
    const double most = 3.0 * least_of({chord(before), chord(behind)});
    const double limited = std::clamp(m[i], std::min(most, 0.0), std::max(most, 0.0));
    if (limited == m[i]) continue;
    const double of_before = bend(before), of_behind = bend(behind), bends = std::abs(least_of({of_before, of_behind}));
    const double left = i > 0 ? chord(before) + of_before : chord(0) - of_behind;
    const double right = i + 1 < n ? chord(behind) - of_behind : left;
    m[i] = bends > 0.0 ? std::clamp(m[i], std::min(left, right) - bends, std::max(left, right) + bends) : limited;
  }
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
    const Piecewise& found = fit.of(of_s, {.argument = static_cast<double>(w) + 1.0});
    for (std::size_t i = 0; i < found.size(); ++i)
      pieces.push_back(piece_of(at(found[i].begin), at(found[i].end), at(found[i].middle - found[i].half),
                                at(found[i].middle + found[i].half), found.polynomial(i)));
  }
  return moved_by(std::move(pieces));
}

FunctionOfTime spline_through(std::span<const double> t, std::span<const double> y) {
  const std::size_t n = t.size();
  if (n < 4 || y.size() != n)
    throw std::invalid_argument(
        fmt::format("has {} times and {} values: four samples or more are needed", n, y.size()));
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isfinite(t[i])) throw std::invalid_argument(fmt::format("has the time {}", t[i]));
    sound(y[i], t[i]);
    if (i > 0 && !(t[i] > t[i - 1]))
      throw std::invalid_argument(fmt::format("has times that do not increase: {} after {}", t[i], t[i - 1]));
  }
  // Slopes m: m_{i-1} / h_{i-1} + 2 (1 / h_{i-1} + 1 / h_i) m_i + m_{i+1} / h_i = 3 (d_{i-1} / h_{i-1} + d_i / h_i), d
  // the slopes of the chords. At the ends those of the cubic through four values, by Newton's divided differences.
  const auto slope_at_end = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    const auto divided = [&](std::size_t i, std::size_t j) { return (y[j] - y[i]) / (t[j] - t[i]); };
    const double ab = divided(a, b), bc = divided(b, c), cd = divided(c, d);
    const double abc = (bc - ab) / (t[c] - t[a]), bcd = (cd - bc) / (t[d] - t[b]);
    const double abcd = (bcd - abc) / (t[d] - t[a]);
    return ab + abc * (t[a] - t[b]) + abcd * (t[a] - t[b]) * (t[a] - t[c]);
  };
  std::vector<double> m(n), upper(n);
  m[0] = slope_at_end(0, 1, 2, 3);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = t[i] - t[i - 1], behind = t[i + 1] - t[i];
    const double right =
        3.0 * ((y[i] - y[i - 1]) / (before * before) + (y[i + 1] - y[i]) / (behind * behind)) - m[i - 1] / before;
    const double pivot = 2.0 * (1.0 / before + 1.0 / behind) - upper[i - 1] / before;
    upper[i] = 1.0 / (behind * pivot);
    m[i] = right / pivot;
  }
  m[n - 1] = slope_at_end(n - 1, n - 2, n - 3, n - 4);
  for (std::size_t i = n - 1; i-- > 1;) m[i] -= upper[i] * m[i + 1];
  limit_slopes(t, y, m);
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double h = t[i + 1] - t[i];
    const auto hermite = [&](double z) {
      const double s = 0.5 * (1.0 + z), r = 1.0 - s;
      return r * r * ((1.0 + 2.0 * s) * y[i] + s * h * m[i]) + s * s * ((1.0 + 2.0 * r) * y[i + 1] - r * h * m[i + 1]);
    };
    pieces.push_back(piece_of(t[i], t[i + 1], t[i], t[i + 1], Chebyshev::of(4, hermite)));
  }
  return moved_by(std::move(pieces));
}

}  // namespace viscobar::characteristics
