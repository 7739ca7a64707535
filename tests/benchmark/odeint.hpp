#pragma once

#include <cstddef>
#include <functional>
#include <vector>

// In C++17's words: uBLAS, which rosenbrock4 needs, is not C++20 in Boost 1.74.
namespace viscobar::baseline {

/// y' = rates(y), y(times.front()) = start
struct OrdinarySystem {
  std::vector<double> start, times;
  std::function<void(const double* y, double* rate)> rates;
  std::function<void(const double* y, double* matrix)> jacobian;  // into a zero matrix, row after row
};

/// y_0 at the times, by dense output; returns the number of steps.
std::size_t odeint_rosenbrock4(const OrdinarySystem& system, double relative, double absolute,
                               std::vector<double>& first);
std::size_t odeint_dopri5(const OrdinarySystem& system, double relative, double absolute, std::vector<double>& first);

}  // namespace viscobar::baseline
