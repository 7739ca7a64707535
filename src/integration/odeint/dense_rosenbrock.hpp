#pragma once

#include <cstddef>
#include <functional>
#include <memory>

// Compiled as C++17: the matrices that rosenbrock4 of Boost 1.74 is made of do not compile as C++20.

namespace viscobar {

/// Odeint's rosenbrock4 for y' = f(t, y) with a constant dense Jacobian. Time is one more unknown, of rate 1: with the
/// coefficients that Boost 1.74 has for df/dt the formulas are of order 2 only.
class DenseRosenbrock {
 public:
  using Rate = std::function<void(double t, const double* y, double* rate)>;
  using TimeRate = std::function<void(double t, double* rate)>;  ///< df/dt

  DenseRosenbrock(std::size_t size, Rate rate, TimeRate time_rate);
  ~DenseRosenbrock();

  double* state();
  double& jacobian(std::size_t row, std::size_t column);

  /// Tries a step from the state to next(), wrong by error().
  void attempt(double t, double h);
  const double* next() const;
  const double* error() const;
  void accept();  ///< next() becomes the state
  /// y' at the end of the step tried last, by the formulas' own interpolation, of order 3: f(t, y) would make of an
  /// error of y, however small, its multiple by the fastest decay.
  void rate(double* out);

 private:
  struct Dense;
  std::unique_ptr<Dense> dense_;
};

}  // namespace viscobar
