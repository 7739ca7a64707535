#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "characteristics/piecewise.hpp"
#include "run/step_failure.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar::characteristics {

/// Places of a function of x inside the bar, in parts of its length.
std::vector<double> shares_of(const NextBreak& places, double length);

/// Makes polynomial pieces of functions on [0, 1], to rounding: halves an interval until a polynomial of degree 32 or
/// less has, at points where it was not made, the values of the function up to
///
///     4 eps (max |f| + |f'|),
///
/// what roundings of f and of its argument do, where that is of size 1. Halving goes on around a jump or a kink until
/// it is known to rounding; then the pieces are put together again. A feature that shows at none of the guards, nor at
/// 61 places spread over [0, 1], is missed.
class PiecewiseFit {
 public:
  struct Options {
    /// Places in (0, 1), increasing, where f is known not to be smooth.
    std::span<const double> breaks = {};
    /// Where it has detail that halving may miss: more places to look at.
    std::span<const double> guards = {};
    /// f is evaluated at least so far away from them, from 0 and 1, but in pieces of a hundred times that or less.
    double apart = 64.0 * std::numeric_limits<double>::epsilon();
    /// f is smooth by its making: no place is looked at for features that the halving may have missed.
    bool smooth = false;
    /// Size of the terms that f is a sum of: its roundings are theirs.
    double size = 0.0;
    /// How large its argument is where it is evaluated, in units of s: its roundings are those of that.
    double argument = 1.0;
    const char* what = "a formula";  ///< f, in messages
  };
  /// Valid until the next call. @throws StepFailure where f is not finite, has a pole, or takes too many pieces at any
  /// tolerance
  const Piecewise& of(const std::function<double(double)>& f, const Options& options);
  const Piecewise& of(const std::function<double(double)>& f) { return of(f, Options()); }

  /// Error of the last result: the largest difference seen, and an integral around breaks.
  double error() const { return error_ + lost_; }
  std::size_t evaluations() const { return evaluations_; }  ///< of all

 private:
  struct Sample {
    double s, value;
  };
  double at(double s) {
    ++evaluations_;
    const double value = (*f_)(s);
    if (!std::isfinite(value)) throw not_finite();
    return value;
  }
  Sample sample(double s) { return {s, at(s)}; }
  bool halve(double begin, double end, double tolerance, bool halved = false);
  bool fits(double begin, double end, double tolerance);
  void locate_breaks();

  const std::function<double(double)>* f_ = nullptr;
  Piecewise pieces_, scratch_;
  Chebyshev fit_;
  double fit_error_ = 0.0;
  std::vector<Sample> guards_;
  double apart_ = 0.0, argument_ = 1.0, scale_ = 0.0, error_ = 0.0, lost_ = 0.0;
  double whole_ = 0.0, in_brief_ = 0.0;  // int |f|, and its part in brief pieces of halved ones
  std::size_t evaluations_ = 0;
};

}  // namespace viscobar::characteristics
