#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace viscobar::radau {

inline constexpr std::size_t stages = 8;          ///< s, even: the poles are pairs
inline constexpr std::size_t lanes = stages / 2;  ///< a pole of each pair
inline constexpr std::size_t parts = 2 * lanes;   ///< real numbers of those
using Lanes = Eigen::Array<double, lanes, 1>;
using Parts = std::array<double, parts>;  ///< of the poles: real parts, then imaginary parts

/// A complex number for each of the poles.
struct Complex {
  Lanes re, im;
};

/// Radau's collocation (IIA) of 8 stages for y' = A y + g, order 15, in its partial fractions. Of the exponential it
/// makes the rational function P(z)/Q(z) of degrees 7 and 8 that matches exp(z) to z^15, and within the step, at
/// t_0 + theta h,
///
///     P_theta(z)/Q(z),   P_theta = exp(theta z) Q(z) cut off behind z^8,
///
/// a polynomial of degree 8 in theta, wrong by c_9(theta) z^9 + ..., |c_9| < 6e-11. With the zeros zeta_k of Q, which
/// are 4 pairs,
///
///     y(theta) = y_0 + sum_k c_k(theta) X_k,   (zeta_k - h A) X_k = h A y_0 + h g_0 + h sum_j j! zeta_k^-j g_j,
///
/// g_j the coefficients of theta^j in g, and c_k(theta) = -P_theta(zeta_k) / (zeta_k Q'(zeta_k)). The eight systems are
/// solved at once, and every time within the step costs sums only.
class Formula {
 public:
  static const Formula& get();

  Complex poles;                     ///< zeta_k of the upper half plane
  Complex inverse;                   ///< 1 / zeta_k
  std::array<double, stages> nodes;  ///< of the stages, in (0, 1], the last 1
  /// sum_j j! zeta_k^-j (coefficient j of Lagrange's polynomial of node m among the nodes and 0): what g(node m) - g(0)
  /// adds to the right-hand side, in multiples of h.
  std::array<Complex, stages> of_load;

  /// What g(node m) - g(0) adds to the coefficients of T_5 to T_8, Chebyshev's polynomials in 2 theta - 1, in the
  /// interpolant of g. Of a smooth g they fall geometrically; a kink within the step has all of them.
  std::array<std::array<double, 4>, stages> tail;

  /// What the parts of a X_k contribute to y(theta) (derivative 0) or its derivative by theta (1).
  Parts weights(double theta, int derivative) const;
  /// The same, of X_k / zeta_k.
  Parts weights_over_pole(const Parts& weights) const;
  /// Of what the step may be wrong by: 30 max |c_9| z^8 / Q(z), as if |z| were 30, which modes have that the step does
  /// not resolve. It is the dense output's error; that at the end of the step is far below it.
  const Parts& error() const { return error_; }

 private:
  Formula();
  std::array<Parts, stages + 1> weights_, rates_;  // by Chebyshev's polynomials in 2 theta - 1
  Parts end_, error_;
};

}  // namespace viscobar::radau
