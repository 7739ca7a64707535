#include "sensitivity/complex_bar.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <unsupported/Eigen/MatrixFunctions>

namespace viscobar {

namespace {

using Number = ComplexBar::Number;
using Vector = ComplexBar::Vector;
using Matrix = ComplexBar::Matrix;

// z = (u, v, impulses on the ends, 1, sin, cos)
class Run {
 public:
  explicit Run(const ComplexBar& bar) : bar_(bar), n_(static_cast<Eigen::Index>(bar.elements) + 1) {
    const Number h = bar.length / static_cast<double>(bar.elements);
    stiffness_ = mass_ = symmetric_ = Matrix::Zero(n_, n_);
    for (Eigen::Index j = 0; j + 1 < n_; ++j) {
      const bool lumped = bar.inertia == ComplexBar::Inertia::lumped;
      const bool fourth = bar.inertia == ComplexBar::Inertia::fourth_order;
      const double on = lumped ? 0.5 : fourth ? 5.0 / 12.0 : 1.0 / 3.0;
      for (const auto i : {j, j + 1}) stiffness_(i, i) += 1.0 / h, symmetric_(i, i) += bar.density * h * on;
      stiffness_(j, j + 1) = stiffness_(j + 1, j) = -1.0 / h;
      symmetric_(j, j + 1) = symmetric_(j + 1, j) = bar.density * h * (0.5 - on);
    }
    mass_ = symmetric_;
    if (bar.inertia == ComplexBar::Inertia::fourth_order)
      for (const bool left : {true, false}) {
        const double row[] = {7.0, 6.0, -1.0};
        for (Eigen::Index k = 0; k < 3; ++k)
          mass_(left ? 0 : n_ - 1, left ? k : n_ - 1 - k) = bar.density * h * row[k] / 24.0;
      }
    Vector z = Vector::Zero(2 * n_ + 5);
    for (Eigen::Index j = 0; j < n_; ++j) {
      const Number x = bar.length * (static_cast<double>(j) / static_cast<double>(bar.elements));
      z(j) = bar.a * x + bar.b, z(n_ + j) = bar.c + bar.d * x;
    }
    z(2 * n_ + 2) = 1.0, z(2 * n_ + 4) = 1.0;
    z_ = z;
  }

  ComplexBar::Result operator()(const std::vector<double>& times) {
    ComplexBar::Result result;
    begin_leg();
    for (const bool left : {true, false})
      if (obstacle(left) && std::abs(clearance(left, z_)) < 1e-14 && z_(speed(left)).real() < 0.0)
        change(left, 0.0, result);
    const double step = bar_.end / 6000.0;
    std::size_t next = 0;
    Number t = 0.0;
    for (int k = 1; next < times.size();) {
      const double to = std::min(k * step, times[next]);
      const Number length = to - t;
      const Vector reached = std::abs(length - step) < 1e-15 * bar_.end ? Vector(regular_ * z_) : at(length);
      std::optional<std::pair<Number, bool>> first;
      for (const bool left : {true, false}) {
        if (!obstacle(left)) continue;
        if (indicator(left, reached).real() >= 0.0) continue;
        const Number found = root(left, length);
        if (!first || found.real() < first->first.real()) first = {found, left};
      }
      if (first) {
        z_ = at(first->first);
        t += first->first;
        change(first->second, t, result);
        if (result.changes.size() > 400) throw std::runtime_error("chatter");
        continue;
      }
      z_ = reached, t = to;
      if (to == times[next]) result.states.push_back(z_.head(2 * n_)), ++next;
      if (to == k * step) ++k;
    }
    result.impulse_left = z_(2 * n_), result.impulse_right = z_(2 * n_ + 1);
    const Vector u = z_.head(n_), v = z_.segment(n_, n_);
    result.energy = 0.5 * product(v, symmetric_ * v) + 0.5 * bar_.modulus * product(u, stiffness_ * u);
    for (const bool left : {true, false})
      if (closed(left) && bar_.law == ComplexBar::Law::spring)
        result.energy += 0.5 / bar_.epsilon * clearance(left, z_) * clearance(left, z_);
    return result;
  }

 private:
  static Number product(const Vector& a, const Vector& b) { return (a.array() * b.array()).sum(); }
  bool obstacle(bool left) const { return (left ? bar_.left_gap : bar_.right_gap).has_value(); }
  Number gap(bool left) const { return *(left ? bar_.left_gap : bar_.right_gap); }
  bool& closed(bool left) { return left ? closed_left_ : closed_right_; }
  Eigen::Index node(bool left) const { return left ? 0 : n_ - 1; }
  Eigen::Index speed(bool left) const { return n_ + node(left); }
  Number clearance(bool left, const Vector& z) const { return z(node(left)) + gap(left); }
  bool rigid() const { return bar_.law == ComplexBar::Law::rigid; }

  Number effective_mass(bool left) const {
    Vector one = Vector::Zero(n_);
    one(node(left)) = 1.0;
    return 1.0 / Vector(mass_.partialPivLu().solve(one))(node(left));
  }
  Number dashpot(bool left) const {
    if (rigid() || bar_.restitution == 1.0) return 0.0;
    const Number logarithm = std::log(bar_.restitution);
    const Number zeta = -logarithm / std::sqrt(std::numbers::pi * std::numbers::pi + logarithm * logarithm);
    return 2.0 * zeta * std::sqrt(effective_mass(left) / bar_.epsilon);
  }

  // z' = rate z on this leg; reaction . z
  void begin_leg() {
    const Eigen::Index size = 2 * n_ + 5, one = size - 3, sine = size - 2, cosine = size - 1;
    Matrix force = Matrix::Zero(n_, size), held = mass_;
    force.leftCols(n_) = -bar_.modulus * stiffness_;
    force.middleCols(n_, n_) = -bar_.viscosity * stiffness_;
    const Vector weights = mass_ * Vector::Ones(n_) / bar_.density;
    force.col(one) += bar_.f_0 * weights;
    force.col(sine) += bar_.f_1 * weights;
    const Matrix bare = force;
    for (const bool left : {true, false}) {
      const Eigen::Index i = node(left);
      reaction_[left] = Eigen::RowVectorXcd::Zero(size);
      if (!closed(left)) continue;
      if (rigid()) {
        held.row(i).setZero();
        held(i, i) = 1.0;
        force.row(i).setZero();
      } else {
        reaction_[left](i) = -1.0 / bar_.epsilon;
        reaction_[left](one) = -gap(left) / bar_.epsilon;
        reaction_[left](n_ + i) = -dashpot(left);
        force.row(i) += reaction_[left];
      }
    }
    inertia_.compute(held);
    const Matrix acceleration = inertia_.solve(force);
    for (const bool left : {true, false})
      if (closed(left) && rigid()) reaction_[left] = mass_.row(node(left)) * acceleration - bare.row(node(left));
    rate_ = Matrix::Zero(size, size);
    rate_.block(0, n_, n_, n_).setIdentity();
    for (const bool left : {true, false})
      if (closed(left) && rigid()) rate_.row(node(left)).setZero();
    rate_.middleRows(n_, n_) = acceleration;
    rate_.row(2 * n_) = reaction_[true];
    rate_.row(2 * n_ + 1) = reaction_[false];
    rate_(sine, cosine) = bar_.omega;
    rate_(cosine, sine) = -bar_.omega;
    regular_ = (rate_ * Number(bar_.end / 6000.0)).exp();
  }

  Vector at(Number length) const { return Matrix((rate_ * length).exp()) * z_; }
  Number indicator(bool left, const Vector& z) {
    if (!closed(left)) return clearance(left, z);
    return rigid() ? Number((reaction_[left] * z)(0)) : -clearance(left, z);
  }
  Number indicator_rate(bool left, const Vector& z) { return indicator(left, rate_ * z + z) - indicator(left, z); }

  Number root(bool left, Number length) {
    double low = 0.0, high = length.real(), middle = 0.5 * high;
    for (int i = 0; i < 60 && high - low > 1e-15 * bar_.end; ++i) {
      const Vector z = at(middle);
      const double value = indicator(left, z).real(), slope = indicator_rate(left, z).real();
      (value < 0.0 ? high : low) = middle;
      const double newton = middle - value / slope;
      if (std::abs(newton - middle) < 1e-16 * bar_.end) break;
      middle = newton > low && newton < high ? newton : 0.5 * (low + high);
    }
    // One step in complex arithmetic has the derivative.
    const Vector z = at(middle);
    return middle - indicator(left, z) / indicator_rate(left, z);
  }

  void change(bool left, Number t, ComplexBar::Result& result) {
    const Eigen::Index i = speed(left);
    if (t == 0.0) {
      t = -clearance(left, z_) / z_(i);
      z_ = at(t);
      // The bar goes on from there, in complex time: back to 0 is what it does after the change.
      result.changes.push_back({t, z_(i), left, true});
      close(left, result, t);
      z_ = at(-t);
      return;
    }
    result.changes.push_back({t, z_(i), left, !closed(left)});
    if (!closed(left)) return close(left, result, t);
    closed(left) = false;
    begin_leg();
  }

  void close(bool left, ComplexBar::Result& result, Number t) {
    const Eigen::Index i = speed(left);
    if (!rigid()) {
      closed(left) = true;
      return begin_leg();
    }
    Vector one = Vector::Zero(n_);
    one(node(left)) = 1.0;
    const Vector answer = inertia_.solve(one);
    const Number leaving = bar_.restitution == 0.0 ? Number(0.0) : -bar_.restitution * z_(i);
    const Number impulse = (leaving - z_(i)) / answer(node(left));
    z_.segment(n_, n_) += impulse * answer;
    z_(2 * n_ + (left ? 0 : 1)) += impulse;
    // The support of the other end takes its part of the blow.
    if (closed(!left)) z_(2 * n_ + (left ? 1 : 0)) += impulse * (mass_.row(node(!left)) * answer)(0);
    z_(node(left)) = -gap(left);
    z_(i) = leaving;
    if (bar_.restitution == 0.0 && (rate_ * z_)(i).real() < 0.0) {
      closed(left) = true;
      return begin_leg();
    }
    result.changes.push_back({t, leaving, left, false});
  }

  const ComplexBar& bar_;
  Eigen::Index n_;
  Matrix stiffness_, mass_, symmetric_, rate_, regular_;
  Eigen::PartialPivLU<Matrix> inertia_;
  Eigen::RowVectorXcd reaction_[2];
  bool closed_left_ = false, closed_right_ = false;
  Vector z_;
};

}  // namespace

ComplexBar::Result ComplexBar::run(const std::vector<double>& times) const { return Run(*this)(times); }

}  // namespace viscobar
