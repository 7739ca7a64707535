#include "integration/radau/step_derivatives.hpp"

#include <algorithm>
#include <cmath>

namespace viscobar::radau {

namespace {

double sum(const Parts& weights, const Complex& x) {
  double total = 0.0;
  for (std::size_t l = 0; l < lanes; ++l) {
    const auto at = static_cast<Eigen::Index>(l);
    total += weights[l] * x.re[at] + weights[lanes + l] * x.im[at];
  }
  return total;
}

void add(Complex& to, const Complex& share, double times) {
  to.re += share.re * times;
  to.im += share.im * times;
}

}  // namespace

StepDerivatives::StepDerivatives(PenalisedSystem& system, const Layout& layout,
                                 std::span<Derivative* const> derivatives)
    : system_(system),
      layout_(layout),
      derivatives_(derivatives),
      state_(layout.size),
      acceleration_(layout.nodes),
      inertial_force_(layout.nodes),
      force_(layout.nodes),
      s_(2 * layout.nodes),
      rates_(layout.block - 2 * layout.nodes) {
  for (const Derivative* one : derivatives) asks_for_inertia_ |= one->asks_for_inertia();
  const std::size_t n = layout.nodes;
  parts_.resize(derivatives.size(), {std::vector<double>(n),
                                     std::vector<double>(n),
                                     rates_,
                                     std::vector<Complex>(n),
                                     std::vector<Complex>(rates_.size()),
                                     {}});
  for (Part& part : parts_) part.load_tail.resize(n);
}

Moment StepDerivatives::moment(double t, std::span<const double> y) {
  const std::size_t n = layout_.nodes;
  const std::span<const double> u = y.first(n), w = y.subspan(n, n);
  if (asks_for_inertia_) {
    system_.force(t, u, w, acceleration_);
    system_.accelerate(acceleration_);
    const SymmetricTridiagonal& inertia = system_.bar().inertia();
    inertia.multiply(acceleration_, inertial_force_);
  }
  return {t, u, w, inertial_force_};
}

void StepDerivatives::impulse_rates(Derivative& derivative, const Moment& at, std::span<const double> s,
                                    std::vector<double>& rates) {
  std::size_t entry = 0;
  if (layout_.left) rates[entry++] = derivative.momentum_loss(0, at, s);
  if (layout_.right) rates[entry++] = derivative.momentum_loss(layout_.nodes - 1, at, s);
}

void StepDerivatives::evaluate(ShiftedSystems& systems, double t, std::span<double> y) {
  const std::size_t n = layout_.nodes;
  const Moment at = moment(t, y);
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    Derivative& derivative = *derivatives_[k];
    derivative.drive(at);
    const std::span<double> block = layout_.derivative(y, k), u = block.first(n), w = block.subspan(n, n);
    derivative.motion().complete_velocity(t, u, w);
    derivative.motion().force(t, u, w, parts_[k].force);
    systems.multiply_stiffness(w, parts_[k].stiff_rate);
    impulse_rates(derivative, at, u, parts_[k].impulse_rates);
  }
}

void StepDerivatives::add_force(std::size_t stage, const Moment& at, std::span<const double> begin) {
  const std::size_t n = layout_.nodes;
  const Complex& of_load = Formula::get().of_load[stage];
  const Complex share = {h_ * of_load.re, h_ * of_load.im};
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    Part& part = parts_[k];
    derivatives_[k]->drive(at);
    const std::span<const double> block = layout_.derivative(begin, k);
    derivatives_[k]->motion().force(at.t, block.first(n), block.subspan(n, n), force_);
    if (stage == 0) std::ranges::fill(part.x, Complex{Lanes::Zero(), Lanes::Zero()});
    for (std::size_t i = 0; i < n; ++i) {
      const double change = force_[i] - part.force[i];
      add(part.x[i], share, change);
      part.load_tail.add(stage, i, change);
    }
  }
}

double StepDerivatives::solve(ShiftedSystems& systems, std::span<const double> weights, Statistics& statistics) {
  const Formula& formula = Formula::get();
  const Parts of_w = formula.error(), of_u = formula.weights_over_pole(of_w);
  const std::size_t n = layout_.nodes;
  double largest = 0.0;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    Part& part = parts_[k];
    systems.solve(part.force, part.stiff_rate, true, part.x);
    statistics.linear_solves += lanes;
    const auto weight = layout_.derivative(weights, k);
    largest = std::max(largest,
                       part.load_tail.error(system_.bar(), h_, weight[0], weight[n + system_.bar().massive_begin()]));
    for (std::size_t i = 0; i < n; ++i)
      largest = std::max(
          {largest, h_ * std::abs(sum(of_u, part.x[i])) * weight[i], std::abs(sum(of_w, part.x[i])) * weight[n + i]});
  }
  return largest;
}

void StepDerivatives::add_impulse_rates(std::size_t stage, const Moment& at, std::span<const double> begin) {
  if (rates_.empty()) return;
  const Formula& formula = Formula::get();
  const Complex share = {h_ * formula.of_load[stage].re, h_ * formula.of_load[stage].im};
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    Part& part = parts_[k];
    derivatives_[k]->drive(at);
    // The balance of momentum of an end asks for no more than its element.
    const std::size_t n = layout_.nodes, two = std::min<std::size_t>(2, n);
    motion_of(k, formula.nodes[stage], begin, s_, 0, two);
    motion_of(k, formula.nodes[stage], begin, s_, n - two, n);
    impulse_rates(*derivatives_[k], at, std::span<const double>(s_).first(layout_.nodes), rates_);
    if (stage == 0)
      for (std::size_t e = 0; e < rates_.size(); ++e)
        part.impulses[e] = {Lanes::Constant(h_ * part.impulse_rates[e]), Lanes::Zero()};
    for (std::size_t e = 0; e < rates_.size(); ++e) add(part.impulses[e], share, rates_[e] - part.impulse_rates[e]);
  }
}

void StepDerivatives::motion_of(std::size_t k, double theta, std::span<const double> begin, std::span<double> s,
                                std::size_t first, std::size_t last) const {
  const Formula& formula = Formula::get();
  const Parts of_w = formula.weights(theta, 0), of_u = formula.weights_over_pole(of_w);
  const std::size_t n = layout_.nodes;
  const auto before = layout_.derivative(begin, k);
  for (std::size_t i = first; i < last; ++i) {
    s[i] = before[i] + h_ * (theta * before[n + i] + sum(of_u, parts_[k].x[i]));
    s[n + i] = before[n + i] + sum(of_w, parts_[k].x[i]);
  }
}

// An impulse I' = r has the systems zeta X = h r.
void StepDerivatives::blocks_at(double theta, std::span<const double> begin, std::span<double> y) const {
  const Formula& formula = Formula::get();
  const Parts weights = formula.weights_over_pole(formula.weights(theta, 0));
  const std::size_t n = layout_.nodes;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const auto before = layout_.derivative(begin, k);
    const std::span<double> block = layout_.derivative(y, k);
    motion_of(k, theta, begin, block, 0, n);
    for (std::size_t e = 0; e < rates_.size(); ++e)
      block[2 * n + e] = before[2 * n + e] + sum(weights, parts_[k].impulses[e]);
  }
}

}  // namespace viscobar::radau
