#include "integration/error_weights.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <span>

#include "dynamics/natural_scales.hpp"

namespace viscobar {

Allowance allowance(const Tolerance& tolerance, const BarSystem& system, double end) {
  if (tolerance.absolute) return {*tolerance.absolute, *tolerance.absolute};
  const NaturalScales scales = natural_scales(system, end);
  const double share = 1e-3 * tolerance.relative;
  return {share * scales.displacement, share * scales.velocity()};
}

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

double largest(std::span<const double> x) {
  return Eigen::Map<const Eigen::ArrayXd>(x.data(), static_cast<Eigen::Index>(x.size())).abs().maxCoeff();
}

}  // namespace

double ErrorWeights::displacement_tolerance() const {
  return (tolerance_.relative * largest_u_ + absolute_.displacement) / tightening_;
}

double ErrorWeights::tolerance_at(std::size_t i) const {
  const double own = std::min(clearances_[i], largest_u_);
  return std::max((tolerance_.relative * own + absolute_.displacement) / tightening_,
                  system_.contacts()[i].clearance_rounding(largest_u_));
}

double ErrorWeights::negligible_bounce(std::size_t i) const {
  // Each change adds a rounding of the clearance to the height, which tolerance_at() is at least.
  constexpr double stirred = 64.0, small = 0.01;
  const double once = tightening_ / (tolerance_.control == ErrorControl::global ? accumulated_ : 1.0);
  return std::max({once * tolerance_at(i), std::min(once * displacement_tolerance(), small * heights_[i]),
                   stirred * system_.contacts()[i].clearance_rounding(largest_u_)});
}

double ErrorWeights::velocity_tolerance() const {
  return (tolerance_.relative * largest_w_ + absolute_.velocity) / tightening_;
}

double ErrorWeights::reaction_tolerance() const { return displacement_tolerance() + viscous_tolerance(); }

double ErrorWeights::viscous_tolerance() const {
  const Bar& bar = system_.bar().bar();
  return bar.viscosity / bar.modulus * velocity_tolerance();
}

double ErrorWeights::negligible_reaction(double h) const {
  const Bar& bar = system_.bar().bar();
  const double rounding = 32.0 * std::numeric_limits<double>::epsilon();
  return h / bar.length * displacement_tolerance() + rounding * (largest_u_ + bar.viscosity / bar.modulus * largest_w_);
}

double ErrorWeights::promised_energy() const { return inertia_ * largest_w_ * promised_velocity(); }

void ErrorWeights::notice(std::span<const double> y) {
  largest_u_ = std::max(largest_u_, system_.contacts().origin().largest_displacement(y.first(layout_.nodes)));
  largest_w_ = std::max(largest_w_, largest(y.subspan(layout_.nodes, layout_.nodes)));
}

// Below a few units of rounding no step could pass.
double ErrorWeights::relative() const { return std::max(tolerance_.relative / tightening_, 16.0 * epsilon); }

double ErrorWeights::weight_of_displacement() const {
  return 1.0 / (relative() * largest_u_ + absolute_.displacement / tightening_);
}

double ErrorWeights::resolved_w() const {
  return std::max(relative() * largest_w_ + absolute_.velocity / tightening_, 4.0 * passed_over_);
}

void ErrorWeights::fill(std::span<const double> y, std::span<double> weights) {
  notice(y);
  std::ranges::fill(layout_.u(weights), weight_of_displacement());
  const double of_velocity = resolved_w();
  for (std::size_t i = 0; i < system_.contacts().size(); ++i)
    if (const double rate = system_.contacts().closed(i) ? system_.contacts()[i].rate : 0.0; rate > 0.0) {
      for (std::size_t node = system_.contacts()[i].unknown, last = node - (system_.contacts()[i].joint > 0 ? 1 : 0);;
           --node) {
        // In flight the nodes of a joint go far, and what they differ by is known to their roundings.
        const double known = 4.0 * epsilon * std::abs(y[node]);
        weights[node] = std::max(weights[node], 1.0 / std::max(of_velocity / rate, known));
        if (node == last) break;
      }
    }
  const auto w = layout_.w(weights);
  std::ranges::fill(w, 1.0 / of_velocity);
  std::ranges::fill(w.first(massive_begin_), 0.0);
  std::ranges::fill(w.subspan(massive_end_), 0.0);
  std::ranges::fill(weights.subspan(2 * layout_.nodes, layout_.account()), 0.0);
  fill_derivatives(y, weights);
}

void ErrorWeights::fill_derivatives(std::span<const double> y, std::span<double> weights) {
  const auto weight = [&](double largest_so_far, double absolute) {
    const double tolerance = derivative_slack * (tolerance_.relative * largest_so_far + absolute);
    return tolerance > 0.0 ? 1.0 / tolerance : 0.0;  // without scale and size there is none
  };
  // The weights of a field are alike, and stay so as long as it does not grow.
  const auto set = [](std::span<double> field, double to) {
    if (field.front() != to) std::ranges::fill(field, to);
  };
  for (std::size_t k = 0; k < derivatives_.size(); ++k) {
    auto& [scale, largest_u, largest_w] = derivatives_[k];
    const auto s = layout_.derivative(y, k);
    const auto block = layout_.derivative(weights, k);
    largest_u = std::max(largest_u, largest(s.u()));
    largest_w = std::max(largest_w, largest(s.w()));
    set(block.u(), weight(largest_u, scale * absolute_.displacement));
    set(block.w().subspan(massive_begin_, massive_end_ - massive_begin_),
        weight(largest_w, scale * absolute_.velocity));
  }
}

}  // namespace viscobar
