#pragma once

#include <Eigen/Dense>
#include <array>
#include <optional>

namespace viscobar::exponential {

/// Range of a smooth function on [0, 1] from value, slope and curvature at both ends and the value in the middle, as
/// Bernstein coefficients of the polynomial of degree 6 through all of them. How far the middle is from the quintic
/// through the ends alone says how well these data resolve the function; four times that is its margin in between.
struct HermiteRange {
  std::array<double, 7> control;
  double margin;  // of control[3]: an error that vanishes like sigma^3 at both ends moves no other

  HermiteRange(const std::array<double, 3>& left, double middle, const std::array<double, 3>& right);
  double lowest() const;
  double highest() const;
  bool monotone() const;
};

/// sum_k c_k sigma^k
double value(const Eigen::VectorXd& c, double sigma);

/// Largest value on [0, sigma] of a polynomial that has one maximum there at most.
double largest_value(const Eigen::VectorXd& c, double sigma);

/// First sigma in [0, 1] at which the polynomial sum_k c_k sigma^k leaves [-band, infinity), traced back to its zero.
std::optional<double> first_passage(const Eigen::VectorXd& c, double band);

}  // namespace viscobar::exponential
