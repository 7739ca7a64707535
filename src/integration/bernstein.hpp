#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

namespace viscobar {

/// A polynomial on [0, 1] in Bernstein form, p(s) = sum_j c_j binom(q,j) s^j (1-s)^(q-j). It lies in the convex hull
/// of its coefficients, so that a sign of all of them is a proof of its sign: no crossing can hide between samples.
class Bernstein {
 public:
  static constexpr std::size_t max_degree = 12;  ///< of one through samples
  static constexpr std::size_t max_power = 22;   ///< of one of powers

  /// Interpolates samples at s = j / degree, j = 0 .. degree.
  static Bernstein through(std::span<const double> samples);
  /// sum_k coefficients[k] s^k
  static Bernstein of_powers(std::span<const double> coefficients);

  std::size_t degree() const { return degree_; }
  double operator()(double s) const;
  /// The same on [from, to], a part of [0, 1] that does not begin at its end, as [0, 1].
  Bernstein between(double from, double to) const;
  Bernstein negative() const;  ///< -p
  double end() const { return c_[degree_]; }
  /// It begins at 0 where it begins below.
  void begin_at_least_at_zero() { c_[0] = c_[0] > 0.0 ? c_[0] : 0.0; }
  double mean() const;  ///< its integral over [0, 1]
  /// The same of the polynomial through samples.
  static double mean(std::span<const double> samples);
  /// Derivatives at the samples of the polynomial through them, and zeros.
  static std::array<double, 16> slopes(std::span<const double> samples);
  /// How far it may leave the samples' range to either side, in lengths of that range: (Lebesgue's constant - 1) / 2.
  static double excess(std::size_t degree);
  /// Largest of slopes() of samples within -1 and 1.
  static double steepest(std::size_t degree);
  /// max(known, p) over [0, 1], to rounding: nothing is searched where the hull stays below what is known.
  double largest(double known) const;
  /// min(known, p) over [0, 1], to rounding.
  double smallest(double known) const;

  /// The first s at which p passes below `threshold`: p(s) = threshold, and p is below behind it. 0 when p starts
  /// below. Absent when p stays at or above it up to `before`, from where on nothing is looked for. It is the last
  /// place, to `finest`, where p is not below.
  std::optional<double> first_descent(double threshold, double finest = 0x1p-52, double before = 2.0) const;

 private:
  std::size_t degree_ = 0;
  std::array<double, max_power + 1> c_{};
};

}  // namespace viscobar
