#include "integration/exponential/passage.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "integration/bernstein.hpp"

namespace viscobar::exponential {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

// An error that vanishes like s^2 (1-s)^2 on each half, 1 at most, has 1.6 as Bernstein coefficients 2 and 3.
bool may_err(std::size_t i) { return i % 6 == 2 || i % 6 == 3; }

}  // namespace

SampledRange::SampledRange(const std::array<double, 5>& f, const std::array<double, 3>& g) {
  const double first = (36 * f[2] + 22.5 * f[0] + 5.5 * f[4] - 18 * g[1] + 4.5 * g[0] - 1.5 * g[2]) / 64;
  const double third = (36 * f[2] + 5.5 * f[0] + 22.5 * f[4] + 18 * g[1] + 1.5 * g[0] - 4.5 * g[2]) / 64;
  margin_ = 1.6 * 4 * std::max(std::abs(f[1] - first), std::abs(f[3] - third));
  const std::array<double, 3> curvature = {8 * f[2] - 11.5 * f[0] + 3.5 * f[4] - 8 * g[1] - 6 * g[0] - g[2],
                                           2 * (f[0] - 2 * f[2] + f[4]) + 0.5 * (g[0] - g[2]),
                                           8 * f[2] + 3.5 * f[0] - 11.5 * f[4] + 8 * g[1] + g[0] + 6 * g[2]};
  for (std::size_t half = 0; half < 2; ++half) {
    double* const b = control_.data() + 6 * half;
    const double left = f[2 * half], right = f[2 * half + 2];
    b[0] = left;
    b[1] = left + g[half] / 5;
    b[2] = left + 0.4 * g[half] + curvature[half] / 20;
    b[3] = right - 0.4 * g[half + 1] + curvature[half + 1] / 20;
    b[4] = right - g[half + 1] / 5;
    b[5] = right;
  }
}

double SampledRange::lowest() const {
  double lowest = control_[0];
  for (std::size_t i = 1; i < control_.size(); ++i)
    lowest = std::min(lowest, control_[i] - (may_err(i) ? margin_ : 0.0));
  return lowest;
}

double SampledRange::highest() const {
  double highest = control_[0];
  for (std::size_t i = 1; i < control_.size(); ++i)
    highest = std::max(highest, control_[i] + (may_err(i) ? margin_ : 0.0));
  return highest;
}

bool SampledRange::monotone() const {
  bool up = true, down = true;
  for (std::size_t i = 0; i + 1 < control_.size(); ++i) {
    const double slack = may_err(i) || may_err(i + 1) ? margin_ : 0.0;
    up &= control_[i + 1] - control_[i] >= slack;
    down &= control_[i] - control_[i + 1] >= slack;
  }
  return up || down;
}

namespace {

double slope(const VectorXd& c, double sigma) {
  double sum = 0.0;
  for (Index k = c.size(); k-- > 1;) sum = sum * sigma + static_cast<double>(k) * c[k];
  return sum;
}

}  // namespace

double value(const VectorXd& c, double sigma) {
  double sum = 0.0;
  for (Index k = c.size(); k-- > 0;) sum = sum * sigma + c[k];
  return sum;
}

double largest_value(const VectorXd& c, double sigma) {
  double rising = 0.0, falling = sigma;
  if (slope(c, 0.0) > 0.0 && slope(c, sigma) < 0.0)
    for (int halving = 0; halving < 30; ++halving) {  // the value is flat there: half of its digits are enough
      const double middle = (rising + falling) / 2;
      (slope(c, middle) > 0.0 ? rising : falling) = middle;
    }
  return std::max(value(c, rising), value(c, sigma));
}

std::optional<double> first_passage(const VectorXd& c, double band) {
  if (c[0] - c.tail(c.size() - 1).cwiseAbs().sum() >= -band) return std::nullopt;
  const std::span<const double> powers(c.data(), static_cast<std::size_t>(c.size()));
  const std::optional<double> passage = Bernstein::of_powers(powers).first_descent(-band, 0x1p-57);
  if (!passage) return std::nullopt;
  double sigma = *passage;
  for (int iteration = 0; iteration < 3 && slope(c, sigma) < 0.0; ++iteration)
    sigma = std::clamp(sigma - value(c, sigma) / slope(c, sigma), 0.0, *passage);
  return sigma;
}

}  // namespace viscobar::exponential
