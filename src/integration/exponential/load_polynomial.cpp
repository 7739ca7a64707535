#include "integration/exponential/load_polynomial.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "viscobar/dynamics/load_error.hpp"
#include "viscobar/dynamics/load_vector.hpp"

namespace viscobar::exponential {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr Index points = load_degree + 1;

struct Chebyshev {
  std::array<double, points> node;  // on [0, 1]
  MatrixXd analysis;                // values at the nodes -> coefficients of T_k(2 sigma - 1)
  MatrixXd monomials;               // those -> coefficients of sigma^j
};

Chebyshev make_chebyshev() {
  Chebyshev c{{}, MatrixXd(points, points), MatrixXd::Zero(points, points)};
  for (Index i = 0; i < points; ++i) {
    const double angle = std::numbers::pi * (static_cast<double>(i) + 0.5) / points;
    c.node[i] = std::pow(std::cos(angle / 2), 2);
    for (Index k = 0; k < points; ++k)
      c.analysis(i, k) = (k == 0 ? 1.0 : 2.0) / points * std::cos(static_cast<double>(k) * angle);
  }
  // T_0 = 1, T_1 = 2 sigma - 1, T_k = 2 (2 sigma - 1) T_{k-1} - T_{k-2}: integers, exact.
  c.monomials(0, 0) = 1.0;
  c.monomials(1, 0) = -1.0;
  c.monomials(1, 1) = 2.0;
  for (Index k = 2; k < points; ++k) {
    c.monomials.row(k) = -2.0 * c.monomials.row(k - 1) - c.monomials.row(k - 2);
    c.monomials.row(k).tail(load_degree) += 4.0 * c.monomials.row(k - 1).head(load_degree);
  }
  return c;
}

const Chebyshev& chebyshev() {
  static const Chebyshev table = make_chebyshev();
  return table;
}

// Below it a number has lost digits.
constexpr double smallest = std::numeric_limits<double>::min();

// Adds the part of `sample` outside the span of the orthonormal `basis` when rounding cannot explain it. A pass that
// shrinks the rest a lot leaves its own rounding in it, which lies within the span: then another pass follows. (The
// square of a load of 1e-200 is 0: norms are Eigen's stable ones.)
void extend(MatrixXd& basis, const Eigen::VectorXd& sample, double largest) {
  const double nothing = std::max(8.0 * std::numeric_limits<double>::epsilon() * largest, smallest);
  Eigen::VectorXd rest = sample;
  double norm = sample.stableNorm(), before = 0.0;
  do {
    rest -= basis * (basis.transpose() * rest);
    before = std::exchange(norm, rest.stableNorm());
    if (norm <= nothing) return;
  } while (norm < 0.5 * before);
  basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
  basis.rightCols(1) = rest / norm;
}

}  // namespace

LoadPolynomial rescaled(const LoadPolynomial& p, double origin, double scale) {
  LoadPolynomial q = p;
  for (Index first = 0; origin != 0.0 && first + 1 < q.cols(); ++first)  // repeated synthetic division
    for (Index j = q.cols() - 1; j-- > first;) q.col(j) += origin * q.col(j + 1);
  double factor = 1.0;
  for (Index j = 0; j < q.cols(); ++j, factor *= scale) q.col(j) *= factor;
  return q;
}

LoadInterpolation::LoadInterpolation(const BarSystem& system, double begin, double end)
    : system_(system), basis_(static_cast<Index>(system.size()), 0) {
  if (!system.loaded()) return;
  LoadVector load(system);
  if (load.steady()) {
    steady_ = load.at(0.0);
    return;
  }
  load_.emplace(system);
  constexpr int looks = 64;
  for (int k = 0; k < looks; ++k) try {
      const std::span<const double> now =
          load.at(begin + (end - begin) * (k + 0.5 + 1e-9) / looks);  // no instant that a formula names
      const double size = Eigen::Map<const Eigen::VectorXd>(now.data(), basis_.rows()).stableNorm();
      if (std::isfinite(size)) expected_ = std::max(expected_, size);
    } catch (const LoadError&) {  // a run that comes there says so
    }
}

// In a frame that moves the load may cancel its forces: what is left is their rounding.
double LoadInterpolation::parts(double t) const {
  if (!system_.frame().moving()) return 0.0;
  const Bar& bar = system_.bar();
  const auto most = [](const Lift& lift) { return std::max(std::abs(lift.left), std::abs(lift.right)); };
  const Lift at = system_.frame().lift(t, 0), rate = system_.frame().lift(t, 1);
  double force = std::abs(bar.modulus * (at.right - at.left) + bar.viscosity * (rate.right - rate.left)) /
                 system_.elements().whole_stretch();
  for (const Support& support : system_.supports())
    force += support.stiffness * most(at) + support.dashpot * most(rate);
  return force + bar.density * system_.mesh().spacing() * std::sqrt(static_cast<double>(system_.size())) *
                     most(system_.frame().lift(t, 2));
}

MatrixXd LoadInterpolation::varying(const LoadPolynomial& p) const { return load_ ? MatrixXd(basis_ * p) : MatrixXd(); }

MatrixXd LoadInterpolation::total(const LoadPolynomial& p) const {
  return load_ ? varying(p) : Eigen::Map<const MatrixXd>(steady_.data(), basis_.rows(), steady_.empty() ? 0 : 1);
}

bool LoadInterpolation::fit(double t, double tau, double negligible, LoadPolynomial& out) {
  if (!load_) return true;
  const Chebyshev& table = chebyshev();
  MatrixXd samples(basis_.rows(), points);
  for (Index i = 0; i < points; ++i) {
    const std::span<const double> value = load_->at(t + tau * table.node[i]);
    samples.col(i) = Eigen::Map<const Eigen::VectorXd>(value.data(), basis_.rows());
    largest_ = std::max({largest_, samples.col(i).stableNorm(), parts(t + tau * table.node[i])});
  }
  for (Index i = 0; i < points; ++i) extend(basis_, samples.col(i), largest_);
  const MatrixXd coefficients = (basis_.transpose() * samples) * table.analysis;
  out = coefficients * table.monomials;
  const auto size = [&](Index first) { return coefficients.middleCols(first, 4).stableNorm(); };
  const double tail = size(points - 4), before = size(points - 8);
  if (tail <= std::max({1e-14 * largest_, negligible, smallest})) return true;
  const double slope = 2.0 * coefficients.col(1).stableNorm() / tau;  // of the load, on average over the step
  const double of_time = 4.0 * std::numeric_limits<double>::epsilon() * (t + tau) * slope;
  if (tail <= 1e-11 * std::max(largest_, expected_) && (tail <= of_time || tail >= 0.05 * before)) return true;
  return coefficients.rightCols(points - 2).stableNorm() <= of_time;  // a straight front
}

}  // namespace viscobar::exponential
