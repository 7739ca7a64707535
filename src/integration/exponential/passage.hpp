#pragma once

#include <Eigen/Dense>
#include <array>
#include <optional>

namespace viscobar::exponential {

/// Range of a function on a step from its values at the quarters and its slopes (per half step) at begin, middle and
/// end: that of the quintic through all but the values at the first and third quarter, as Bernstein coefficients on
/// either half. How far these two are off says how well the function is resolved; four times that is the margin.
class SampledRange {
 public:
  SampledRange(const std::array<double, 5>& values, const std::array<double, 3>& slopes);
  double lowest() const;
  double highest() const;
  bool monotone() const;

 private:
  std::array<double, 12> control_;
  double margin_;
};

/// sum_k c_k sigma^k
double value(const Eigen::VectorXd& c, double sigma);

/// Largest value on [0, sigma] of a polynomial that has one maximum there at most.
double largest_value(const Eigen::VectorXd& c, double sigma);

/// First sigma in [0, 1] at which the polynomial sum_k c_k sigma^k leaves [-band, infinity), traced back to its zero.
std::optional<double> first_passage(const Eigen::VectorXd& c, double band);

}  // namespace viscobar::exponential
