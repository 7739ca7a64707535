#include "integration/bernstein.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

namespace viscobar {

namespace {

double binomial(std::size_t n, std::size_t k) {
  double value = 1.0;
  for (std::size_t i = 0; i < k; ++i) value = value * static_cast<double>(n - i) / static_cast<double>(i + 1);
  return value;
}

// Samples at equidistant points to coefficients, for every degree.
const Eigen::MatrixXd& samples_to_coefficients(std::size_t degree) {
  static const std::vector<Eigen::MatrixXd> matrices = [] {
    std::vector<Eigen::MatrixXd> list;
    for (std::size_t q = 0; q <= Bernstein::max_degree; ++q) {
      const auto size = static_cast<Eigen::Index>(q + 1);
      Eigen::MatrixXd values(size, size);
      for (std::size_t i = 0; i <= q; ++i) {
        const double s = q ? static_cast<double>(i) / static_cast<double>(q) : 0.0;
        for (std::size_t j = 0; j <= q; ++j)
          values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
              binomial(q, j) * std::pow(s, static_cast<double>(j)) * std::pow(1.0 - s, static_cast<double>(q - j));
      }
      list.push_back(values.inverse());
    }
    return list;
  }();
  return matrices[degree];
}

}  // namespace

Bernstein Bernstein::through(std::span<const double> samples) {
  assert(!samples.empty() && samples.size() <= max_degree + 1);
  Bernstein p;
  p.degree_ = samples.size() - 1;
  const auto size = static_cast<Eigen::Index>(samples.size());
  Eigen::Map<Eigen::VectorXd>(p.c_.data(), size).noalias() =
      samples_to_coefficients(p.degree_) * Eigen::Map<const Eigen::VectorXd>(samples.data(), size);
  return p;
}

double Bernstein::operator()(double s) const {
  std::array<double, max_degree + 1> b = c_;
  for (std::size_t r = degree_; r > 0; --r)
    for (std::size_t j = 0; j < r; ++j) b[j] += s * (b[j + 1] - b[j]);
  return b[0];
}

double Bernstein::smallest_coefficient() const {
  return *std::min_element(c_.begin(), c_.begin() + static_cast<std::ptrdiff_t>(degree_) + 1);
}

std::optional<double> Bernstein::first_descent(double threshold) const {
  if (smallest_coefficient() >= threshold) return std::nullopt;
  // Depth-first from the left; an interval is given up once its hull stays above, and halved until it is a number.
  struct Interval {
    std::array<double, max_degree + 1> c;
    double begin, length;
  };
  std::vector<Interval> pending{{c_, 0.0, 1.0}};
  while (!pending.empty()) {
    const Interval now = pending.back();
    pending.pop_back();
    const auto last = now.c.begin() + static_cast<std::ptrdiff_t>(degree_) + 1;
    if (*std::min_element(now.c.begin(), last) >= threshold) continue;
    if (now.c[0] < threshold) return now.begin;
    if (now.length <= std::numeric_limits<double>::epsilon()) return now.begin;
    Interval left{{}, now.begin, now.length / 2}, right{now.c, now.begin + now.length / 2, now.length / 2};
    for (std::size_t r = 0; r <= degree_; ++r) {
      left.c[r] = right.c[0];
      for (std::size_t j = 0; j + r < degree_; ++j) right.c[j] = 0.5 * (right.c[j] + right.c[j + 1]);
    }
    pending.push_back(right);
    pending.push_back(left);
  }
  return std::nullopt;
}

}  // namespace viscobar
