#include "characteristics/piecewise_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace viscobar::characteristics {

namespace {

constexpr std::size_t guards = 61, few_guards = 5;
constexpr double brief = 1e-9;             // of a piece that is there for a break only
constexpr std::size_t most_pieces = 4000;  // beyond that a looser tolerance is tried
constexpr std::size_t most_of_all = 200'000;
// The share of the integral of |f| that brief pieces of halved ones may have: a jump has next to nothing there,
// |s|^(-1/2) 3e-5, a pole a third.
constexpr double most_in_brief = 0.01;

}  // namespace

std::vector<double> shares_of(const NextBreak& places, double length) {
  constexpr std::size_t most = 10000;  // where they have a limit, as those of sin(1/x) > 0
  std::vector<double> found;
  if (!places) return found;
  const double apart = 256.0 * rounding * length, end = length - apart;
  for (auto at = places(apart, end); at && found.size() < most; at = places(*at + apart, end))
    found.push_back(*at / length);
  return found;
}

const Piecewise& PiecewiseFit::of(const std::function<double(double)>& f, const Options& options) {
  f_ = &f;
  apart_ = options.apart;
  argument_ = options.argument;
  guards_.clear();
  scale_ = options.size;
  for (std::size_t k = 0; k < (options.smooth ? few_guards : guards); ++k) {
    // Multiples of the golden section: no formula has its period.
    const double s = std::fmod(0.5 + 0.6180339887498949 * static_cast<double>(k), 1.0);
    guards_.push_back(sample(s));
  }
  for (const double s : options.guards) guards_.push_back(sample(s));
  for (const Sample& guard : guards_) scale_ = std::max(scale_, std::abs(guard.value));
  std::ranges::sort(guards_, {}, &Sample::s);
  bool done = false;
  for (double tolerance = 4.0 * rounding; !done; tolerance *= 16.0) {
    pieces_.clear();
    error_ = lost_ = whole_ = in_brief_ = 0.0;
    double begin = 0.0;
    const auto halve_up_to = [&](double end) { return halve(std::exchange(begin, end), end, tolerance); };
    done = std::ranges::all_of(options.breaks, halve_up_to) && halve_up_to(1.0);
  }
  if (in_brief_ > most_in_brief * whole_)
    throw StepFailure(Failure::load, fmt::format("{} has a pole, or is as good as infinite in a moment", options.what));
  lost_ += pieces_.left_out();
  if (pieces_.size() > 1) {
    lost_ += simplify(pieces_, 16.0 * rounding * scale_ + 2.0 * error_, 0.0, brief, scratch_);
    locate_breaks();
  }
  return pieces_;
}

// False: it would take too many pieces.
bool PiecewiseFit::halve(double begin, double end, double tolerance, bool halved) {
  if (!fits(begin, end, tolerance)) {
    const double middle = 0.5 * (begin + end);
    return halve(begin, middle, tolerance, true) && halve(middle, end, tolerance, true);
  }
  // Around a jump the largest difference says nothing: what the piece adds to an integral does.
  if (end - begin < brief)
    lost_ += fit_error_ * (end - begin);
  else
    error_ = std::max(error_, fit_error_);
  pieces_.append(end, begin, end, fit_);
  const double part = (end - begin) * fit_.bound();
  whole_ += part;
  if (halved && end - begin < brief) in_brief_ += part;
  if (pieces_.size() > most_of_all)
    throw StepFailure(Failure::detail,
                      fmt::format("a formula has detail without end, which {} polynomials do not follow", most_of_all));
  return pieces_.size() <= most_pieces || tolerance >= 1e-6;
}

bool PiecewiseFit::fits(double begin, double end, double tolerance) {
  const double width = end - begin, middle = 0.5 * (begin + end);
  std::array<double, Chebyshev::fitted_terms> values;
  for (const std::size_t terms : {std::size_t{9}, std::size_t{17}, Chebyshev::fitted_terms}) {
    const std::span<const double> points = Chebyshev::points(terms);
    double slope = 0.0;
    for (std::size_t j = 0; j < terms; ++j) {
      values[j] = at(middle + 0.5 * width * points[j]);
      scale_ = std::max(scale_, std::abs(values[j]));
      if (j > 0)
        slope = std::max(slope, std::abs(values[j] - values[j - 1]) / (0.5 * width * (points[j - 1] - points[j])));
    }
    // Numbers below the smallest normal one have no digits to agree in.
    const double allowed = std::max(tolerance * (scale_ + argument_ * slope), std::numeric_limits<double>::min());
    fit_ = Chebyshev::through({values.data(), terms});
    if (width <= 4.0 * rounding) {
      fit_ = Chebyshev::constant(fit_.coefficients()[0]);
      fit_error_ = 0.0;
      lost_ += width * slope * width;
      return true;
    }
    const std::span<const double> c = fit_.coefficients();
    if (std::abs(c[terms - 1]) + std::abs(c[terms - 2]) > allowed) continue;
    fit_error_ = fit_.chop(0.25 * allowed);
    const auto check = [&](const Sample& sample) {
      fit_error_ = std::max(fit_error_, std::abs(fit_((sample.s - middle) / (0.5 * width)) - sample.value));
    };
    for (const double part : {0.0214, 0.3141, 0.7071, 0.9732}) check(sample(begin + part * width));
    // A break beyond the last of the points shows at the ends.
    const double inside = std::min(apart_, 0.01 * width);
    check(sample(begin + inside));
    check(sample(end - inside));
    const auto first = std::ranges::lower_bound(guards_, begin, {}, &Sample::s);
    for (auto guard = first; guard != guards_.end() && guard->s < end; ++guard) check(*guard);
    if (fit_error_ <= 2.0 * allowed) return true;
  }
  return false;
}

// Between two pieces that are left and right of a break lie some that are as short as roundings of the place. Where the
// function is the one or the other there, the break is where it changes.
void PiecewiseFit::locate_breaks() {
  scratch_.clear();
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piecewise::Piece left = pieces_[i];
    const Chebyshev p = pieces_.polynomial(i);
    double end = left.end;
    std::size_t j = i + 1;
    while (j < pieces_.size() && pieces_[j].width() < brief) ++j;
    if (j > i + 1 && j < pieces_.size() && left.width() >= brief) {
      const Piecewise::Piece& right = pieces_[j];
      const Chebyshev q = pieces_.polynomial(j);
      const auto off = [&](double s, bool of_left) {
        return std::abs((of_left ? p(left.z(s)) : q(right.z(s))) - at(s));
      };
      double low = left.end, high = right.begin;
      while (low < 0.5 * (low + high) && 0.5 * (low + high) < high) {
        const double s = 0.5 * (low + high);
        (off(s, true) <= off(s, false) ? low : high) = s;
      }
      double worst = 0.0;
      for (const double part : {0.11, 0.52, 0.93})
        worst = std::max(
            {worst, off(left.end + part * (low - left.end), true), off(high + part * (right.begin - high), false)});
      if (worst <= 64.0 * rounding * scale_ + 1e-3 * std::abs(p(left.z(low)) - q(right.z(high)))) {
        end = low;
        lost_ += worst * (right.begin - left.end);
        i = j - 1;  // the next piece begins where this one ends
      }
    }
    scratch_.append(end, left, p);
  }
  std::swap(pieces_, scratch_);
}

}  // namespace viscobar::characteristics
