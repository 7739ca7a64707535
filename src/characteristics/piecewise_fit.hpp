#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "characteristics/piecewise.hpp"

namespace viscobar::characteristics {

/// Makes polynomial pieces of functions on [0, 1], to rounding: halves an interval until a polynomial of degree 32 or
/// less has, at points where it was not made, the values of the function up to
///
///     4 eps (max |f| + s |f'|),
///
/// what roundings of f and of its argument do. Halving goes on around a jump or a kink until it is known to rounding;
/// then the pieces are put together again. A feature that shows at none of 61 places spread over [0, 1] is missed.
class PiecewiseFit {
 public:
  /// Of what is smooth by its making, no place is looked at for features that the halving may have missed.
  enum class Nature { unknown, smooth_between_breaks };
  /// `breaks` are places in (0, 1), increasing, where f is known not to be smooth; f is not evaluated there, nor at 0
  /// and 1. The result is valid until the next call.
  const Piecewise& of(const std::function<double(double)>& f, std::span<const double> breaks = {},
                      Nature nature = Nature::unknown);

  double error() const { return error_; }  ///< of the last: the largest difference seen, and int of what was left out
  std::size_t evaluations() const { return evaluations_; }  ///< of all

 private:
  struct Interval {
    double begin, end;
  };
  struct Sample {
    double s, value;
  };
  double at(double s) {
    ++evaluations_;
    return (*f_)(s);
  }
  bool halve(double begin, double end, double tolerance);
  bool fits(const Interval& interval, double tolerance);
  void locate_breaks();

  const std::function<double(double)>* f_ = nullptr;
  Piecewise pieces_, scratch_;
  Chebyshev fit_;
  double fit_error_ = 0.0;
  std::vector<Sample> guards_;
  std::vector<Interval> waiting_;
  double scale_ = 0.0, error_ = 0.0;
  std::size_t evaluations_ = 0;
};

}  // namespace viscobar::characteristics
