#pragma once

#include <Eigen/Dense>
#include <complex>
#include <cstddef>
#include <optional>
#include <vector>

namespace viscobar {

/// A bar of few nodes whose numbers are complex: a parameter p + i 1e-40 gives the derivative of all that follows as
/// its imaginary part / 1e-40, without differences. It shares no code with the library: dense matrices, exponentials of
/// them between contact changes, and Newton's method in complex arithmetic for the times of these.
struct ComplexBar {
  using Number = std::complex<double>;
  using Vector = Eigen::VectorXcd;
  using Matrix = Eigen::MatrixXcd;

  enum class Inertia { consistent, lumped, fourth_order };
  enum class Law { spring, rigid };

  std::size_t elements = 5;
  Inertia inertia = Inertia::consistent;
  Number length = 1.0, density = 1.0, modulus = 1.0, viscosity = 0.1;
  std::optional<Number> left_gap, right_gap;  ///< of obstacles below and above, if any
  Law law = Law::spring;
  Number epsilon = 1e-2, restitution = 1.0;
  /// u_0 = a x + b, u_1 = c + d x, f = f_0 + f_1 sin(omega t)
  Number a = 0.0, b = 0.0, c = 0.0, d = 0.0, f_0 = 0.0, f_1 = 0.0, omega = 1.0;
  double end = 1.0;

  struct Change {
    Number time, velocity;
    bool left, closing;
  };
  struct Result {
    std::vector<Vector> states;  ///< (u, v) at the times asked for
    std::vector<Change> changes;
    Number impulse_left = 0.0, impulse_right = 0.0, energy = 0.0;
  };
  Result run(const std::vector<double>& times) const;
};

}  // namespace viscobar
