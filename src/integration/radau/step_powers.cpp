#include "integration/radau/step_powers.hpp"

#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>

#include "discretisation/dense.hpp"
#include "discretisation/gauss.hpp"

namespace viscobar::radau {

namespace {

constexpr Eigen::Index count = 17;

// P_0 to P_17 at a place.
std::array<double, count + 1> legendre(double s) {
  std::array<double, count + 1> p{1.0, s};
  for (std::size_t n = 1; n < count; ++n) {
    const auto m = static_cast<double>(n);
    p[n + 1] = ((2.0 * m + 1.0) * s * p[n] - m * p[n - 1]) / (m + 1.0);
  }
  return p;
}

struct Rule {
  std::array<double, count> nodes;
  Eigen::Matrix<double, count, count> to_coefficients;  // of values at the nodes

  // Kronrod's own nodes are the middle and every second pair from there on.
  Rule() {
    std::size_t k = 0;
    for (const GaussPoint& point : gauss(8)) nodes[k++] = point.node;
    const auto& half = boost::math::quadrature::gauss_kronrod<double, count>::abscissa();
    nodes[k++] = half[0];
    for (std::size_t i = 2; i < half.size(); i += 2) nodes[k++] = half[i], nodes[k++] = -half[i];
    Eigen::Matrix<double, count, count> values;
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto p = legendre(nodes[static_cast<std::size_t>(i)]);
      for (Eigen::Index n = 0; n < count; ++n) values(i, n) = p[static_cast<std::size_t>(n)];
    }
    to_coefficients = inverse(values);
  }
};

const Rule& rule() {
  static const Rule rule;
  return rule;
}

}  // namespace

const std::array<double, StepPowers::points>& StepPowers::nodes() { return rule().nodes; }

StepPowers::Flow StepPowers::over_step(double length, const std::array<Flow, of_gauss>& at_gauss) {
  half_ = 0.5 * length;
  known_ = false;
  std::ranges::copy(at_gauss, values_.begin());
  Flow sum{};
  std::size_t k = 0;
  for (const GaussPoint& point : gauss(of_gauss)) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += half_ * point.weight * values_[k][i];
    ++k;
  }
  return sum;
}

void StepPowers::expand() {
  for (std::size_t n = 0; n < points; ++n) {
    coefficients_[n] = {};
    for (std::size_t k = 0; k < points; ++k) {
      const double share = rule().to_coefficients(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(k));
      for (std::size_t i = 0; i < coefficients_[n].size(); ++i) coefficients_[n][i] += share * values_[k][i];
    }
  }
  known_ = true;
}

// int_{-1}^s P_n = (P_{n+1} - P_{n-1}) / (2 n + 1), and s + 1 for n = 0.
StepPowers::Flow StepPowers::integral(double s) const {
  const auto p = legendre(s);
  Flow sum{};
  for (std::size_t n = 0; n < points; ++n) {
    const double share = n == 0 ? s + 1.0 : (p[n + 1] - p[n - 1]) / (2.0 * static_cast<double>(n) + 1.0);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += half_ * share * coefficients_[n][i];
  }
  return sum;
}

}  // namespace viscobar::radau
