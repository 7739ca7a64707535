#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>

namespace viscobar::characteristics {

inline constexpr double rounding = std::numeric_limits<double>::epsilon();  ///< of 1

/// A polynomial sum_k c_k T_k(z) on -1 <= z <= 1, a value without memory of its own. |T_k| <= 1, so it differs from c_0
/// by at most the sum of the other |c_k|: signs are proved by coefficients, at any degree and without the condition
/// number of another basis.
class Chebyshev {
 public:
  static constexpr std::size_t most_terms = 36;    // of any,
  static constexpr std::size_t fitted_terms = 33;  // and of one through values: it may be integrated three times

  Chebyshev() = default;  // zero
  explicit Chebyshev(std::span<const double> coefficients);
  static Chebyshev constant(double value) { return Chebyshev(std::span(&value, 1)); }
  /// z_j = cos(pi (2 j + 1) / (2 n)), inside the interval: its ends may be where a function breaks.
  static std::span<const double> points(std::size_t n);
  /// Through the values at points(values.size()).
  static Chebyshev through(std::span<const double> values);
  /// Through those of f at points(n).
  static Chebyshev of(std::size_t n, auto&& f) {
    const std::span<const double> at = points(n);
    std::array<double, most_terms> values;
    for (std::size_t j = 0; j < n; ++j) values[j] = f(at[j]);
    return through({values.data(), n});
  }

  std::size_t terms() const { return terms_; }
  std::span<const double> coefficients() const { return {c_.data(), terms_}; }

  double operator()(double z) const;
  /// At up to `most_places` places at once, which takes little more than one.
  static constexpr std::size_t most_places = 40;
  void at(std::span<const double> z, std::span<double> values) const;
  double integral() const;           ///< over [-1, 1]
  Chebyshev antiderivative() const;  ///< zero at -1
  Chebyshev derivative() const;
  Chebyshev restricted(double from, double to) const;  ///< the same on [from, to], taken to [-1, 1]
  Chebyshev mirrored() const;                          ///< p(-z)

  double lower() const { return terms_ == 0 ? 0.0 : c_[0] - spread(); }  ///< p is not below that,
  double upper() const { return terms_ == 0 ? 0.0 : c_[0] + spread(); }  ///< nor above this
  double bound() const;                                                  ///< of |p|

  Chebyshev& operator+=(const Chebyshev& other);
  Chebyshev& operator+=(double constant);
  Chebyshev& operator*=(double factor);

  /// Leaves out last coefficients that sum up to at most `tolerance`; returns that sum.
  double chop(double tolerance);
  /// Leaves out all but the first ones.
  void cut(std::size_t terms) { terms_ = terms < terms_ ? terms : terms_; }

 private:
  double spread() const;

  std::array<double, most_terms> c_;
  std::size_t terms_ = 0;
};

inline Chebyshev operator*(double factor, Chebyshev p) { return p *= factor; }
inline Chebyshev operator-(Chebyshev p) { return p *= -1.0; }
inline Chebyshev operator+(Chebyshev p, double constant) { return p += constant; }

/// The first zero through which p passes to below -band, or a place within the band just before; -1 where it begins
/// below. Absent: p >= -band throughout. No pair of zeros is missed: an interval is given up only once its coefficients
/// prove it.
std::optional<double> first_descent(const Chebyshev& p, double band);

/// max p to within `tolerance`, if it exceeds `known`; else `known`.
double maximum(const Chebyshev& p, double known, double tolerance);

}  // namespace viscobar::characteristics
