#include "integration/exponential/passage.hpp"

#include <algorithm>
#include <cmath>

namespace viscobar::exponential {

using Eigen::Index;
using Eigen::VectorXd;

HermiteRange::HermiteRange(const std::array<double, 3>& left, double middle, const std::array<double, 3>& right) {
  const double b0 = left[0], b1 = b0 + left[1] / 5, b2 = b0 + 0.4 * left[1] + left[2] / 20;
  const double b5 = right[0], b4 = b5 - right[1] / 5, b3 = b5 - 0.4 * right[1] + right[2] / 20;
  const double quintic = (b0 + b5 + 5 * (b1 + b4) + 10 * (b2 + b3)) / 32;
  // 64 sigma^3 (1 - sigma)^3, one in the middle, has 64 / 20 as its only coefficient.
  const double miss = 3.2 * (middle - quintic);
  control = {b0, (b0 + 5 * b1) / 6, (b1 + 2 * b2) / 3, (b2 + b3) / 2 + miss, (b4 + 2 * b3) / 3, (b5 + 5 * b4) / 6, b5};
  margin = 4 * std::abs(miss);
}

double HermiteRange::lowest() const { return std::min(std::ranges::min(control), control[3] - margin); }

double HermiteRange::highest() const { return std::max(std::ranges::max(control), control[3] + margin); }

bool HermiteRange::monotone() const {
  bool up = true, down = true;
  for (std::size_t i = 0; i + 1 < control.size(); ++i) {
    const double slack = i == 2 || i == 3 ? margin : 0.0;
    up &= control[i + 1] - control[i] >= slack;
    down &= control[i] - control[i + 1] >= slack;
  }
  return up || down;
}

namespace {

VectorXd bernstein(const VectorXd& c) {
  const Index n = c.size() - 1;
  VectorXd b = c;
  double binomial = 1.0;
  for (Index k = 1; k <= n; ++k) {
    binomial *= static_cast<double>(n - k + 1) / static_cast<double>(k);
    b[k] /= binomial;
  }
  for (Index first = 1; first <= n; ++first)
    for (Index k = n; k >= first; --k) b[k] += b[k - 1];
  return b;
}

// First point of [from, from + width] where the polynomial with Bernstein coefficients b there is below `floor`.
std::optional<double> descend(const VectorXd& b, double floor, double from, double width) {
  if (b.minCoeff() >= floor) return std::nullopt;
  if (b[0] < floor || width < 1e-17) return from;
  VectorXd left = b, right = b;
  for (Index k = 1; k < b.size(); ++k) {
    for (Index i = 0; i + k < b.size(); ++i) right[i] = 0.5 * (right[i] + right[i + 1]);
    left[k] = right[0];
  }
  if (const auto found = descend(left, floor, from, width / 2)) return found;
  return descend(right, floor, from + width / 2, width / 2);
}

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
  const std::optional<double> passage = descend(bernstein(c), -band, 0.0, 1.0);
  if (!passage) return std::nullopt;
  double sigma = *passage;
  for (int iteration = 0; iteration < 3 && slope(c, sigma) < 0.0; ++iteration)
    sigma = std::clamp(sigma - value(c, sigma) / slope(c, sigma), 0.0, *passage);
  return sigma;
}

}  // namespace viscobar::exponential
