#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstring>
#include <span>

namespace viscobar::radau {

inline constexpr std::size_t stages = 8;          ///< s, even: the poles are pairs
inline constexpr std::size_t lanes = stages / 2;  ///< a pole of each pair
inline constexpr std::size_t parts = 2 * lanes;   ///< real numbers of those
// Functions that pass these on are all compiled here, for one processor.
#pragma GCC diagnostic ignored "-Wpsabi"
/// A vector of the compiler's own: it stays in registers where an array of a library goes through memory.
typedef double Lanes __attribute__((vector_size(lanes * sizeof(double))));
inline Lanes load_lanes(const double* x) {
  Lanes loaded;
  std::memcpy(&loaded, x, sizeof loaded);
  return loaded;
}
inline void store_lanes(const Lanes& stored, double* x) { std::memcpy(x, &stored, sizeof stored); }
/// Entry j of vector i becomes entry i of vector j.
[[gnu::always_inline]] inline std::array<Lanes, lanes> transposed(const std::array<Lanes, lanes>& of) {
  static_assert(lanes == 4);
  const Lanes a = __builtin_shufflevector(of[0], of[1], 0, 4, 2, 6),
              b = __builtin_shufflevector(of[0], of[1], 1, 5, 3, 7);
  const Lanes c = __builtin_shufflevector(of[2], of[3], 0, 4, 2, 6),
              d = __builtin_shufflevector(of[2], of[3], 1, 5, 3, 7);
  return {__builtin_shufflevector(a, c, 0, 1, 4, 5), __builtin_shufflevector(b, d, 0, 1, 4, 5),
          __builtin_shufflevector(a, c, 2, 3, 6, 7), __builtin_shufflevector(b, d, 2, 3, 6, 7)};
}
using Parts = std::array<double, parts>;  ///< of the poles: real parts, then imaginary parts
/// At theta = j / stages, j = 0 .. stages. What is behind it is 0 and makes whole vectors of it.
using Samples = Eigen::Array<double, stages + lanes, 1>;

/// A complex number for each of the poles. Calls of its arithmetic would cost a tenth of a run on few elements.
struct Complex {
  Lanes re, im;
};
[[gnu::always_inline]] inline Complex operator*(const Complex& a, const Complex& b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
[[gnu::always_inline]] inline Complex operator*(double a, const Complex& b) { return {a * b.re, a * b.im}; }
[[gnu::always_inline]] inline Complex operator-(const Complex& a, const Complex& b) {
  return {a.re - b.re, a.im - b.im};
}
[[gnu::always_inline]] inline Complex operator+(const Complex& a, const Complex& b) {
  return {a.re + b.re, a.im + b.im};
}

/// sum_l columns[l] (part l of x)
template <class Column>
inline Column combined(const std::array<Column, parts>& columns, const Complex& x) {
  Column re = columns[0] * x.re[0], im = columns[lanes] * x.im[0];
  for (std::size_t l = 1; l < lanes; ++l) {
    re += columns[l] * x.re[l];
    im += columns[lanes + l] * x.im[l];
  }
  return re + im;
}

inline double combined(const Parts& weights, const Complex& x) {
  static_assert(lanes == 4);
  const Lanes sum = load_lanes(weights.data()) * x.re + load_lanes(weights.data() + lanes) * x.im;
  return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}

/// Radau's collocation (IIA) of 8 stages for y' = A y + g, in partial fractions. Its order is 15. A step multiplies y
/// by P(z)/Q(z), z = h A, in place of exp(z). P and Q have the degrees 7 and 8, and the quotient matches exp(z) to
/// z^15. Within the step, at t_0 + theta h, the collocation polynomial multiplies y by
///
///     P_theta(z)/Q(z),   P_theta = exp(theta z) Q(z) cut off behind z^8.
///
/// This is a polynomial of degree 8 in theta. Its error is c_9(theta) z^9 + ..., |c_9| < 6e-11. Q has 4 pairs of zeros
/// zeta_k. With them
///
///     y(theta) = y_0 + sum_k c_k(theta) X_k,   (zeta_k - h A) X_k = h A y_0 + h g_0 + h sum_j j! zeta_k^-j g_j,
///     c_k(theta) = -P_theta(zeta_k) / (zeta_k Q'(zeta_k)).
///
/// g_j is the coefficient of theta^j in g. The systems of a pair are conjugate, so four are solved, at once. After that
/// every time within the step costs sums only. With c_k in place of g, sum_j j! zeta_l^-j g_j is 1 for l = k and else
/// 0: a load that is linear in the motion is in each system a multiple of X_k.
class Formula {
 public:
  static const Formula& get();

  Complex poles;                     ///< zeta_k of the upper half plane
  Complex inverse;                   ///< 1 / zeta_k
  std::array<double, stages> nodes;  ///< of the stages, in (0, 1], the last 1
  /// sum_j j! zeta_k^-j (coefficient j of Lagrange's polynomial of node m among the nodes and 0): what g(node m) - g(0)
  /// adds to the right-hand side, in multiples of h.
  std::array<Complex, stages> of_load;

  /// Contribution of g(node m) - g(0) to the coefficients of T_5 to T_8, Chebyshev's polynomials in 2 theta - 1, in the
  /// interpolant of g. They fall geometrically where g is smooth; a kink within the step has all of them.
  std::array<std::array<double, 4>, stages> tail;

  /// Contribution of the parts of a X_k to y(theta) (derivative 0) or its derivative by theta (1).
  Parts weights(double theta, int derivative) const;
  /// The same, of X_k / zeta_k.
  Parts weights_over_pole(const Parts& weights) const;
  /// weights() at j / stages, or where asked for weights_over_pole() of those.
  const std::array<Samples, parts>& samples(int derivative, bool over_pole) const {
    return samples_[derivative == 0 ? 0 : 1][over_pole ? 1 : 0];
  }
  /// The weights of what the step may be wrong by, 30 max |c_9| z^8 / Q(z). It has z^9 as if |z| were 30, as modes have
  /// that the step does not resolve. It is the error within the step. That at the end of the step is far below it.
  const Parts& error() const { return error_; }

 private:
  Formula();
  std::array<Parts, stages + 1> weights_, rates_;  // by Chebyshev's polynomials in 2 theta - 1
  Parts end_, error_;
  std::array<std::array<std::array<Samples, parts>, 2>, 2> samples_;
};

/// Largest changes of w and u in a step of length h, and what they may be wrong by, w of nodes with mass alone.
struct Moved {
  double rate, way, rate_error, way_error;
};
/// Makes (u, w) at its end, by those at its beginning and the parts X_k of w. Of five nodes or more; those in the range
/// `with_mass` have mass.
Moved move_nodes(double h, std::span<const Complex> x, const std::array<std::size_t, 2>& with_mass,
                 std::span<const double> begin, std::span<double> end);

}  // namespace viscobar::radau
