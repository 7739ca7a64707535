#include "integration/exponential/energy_integral.hpp"

#include <algorithm>
#include <cmath>

#include "discretisation/gauss.hpp"

namespace viscobar::exponential {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Leg = LinearLeg<double>;

EnergyFlow gauss_flow(const Leg& leg, const Leg::Series& series, const MatrixXd& load, double tau, double sigma,
                      const FrameFlow& of_frame) {
  EnergyFlow flow;
  const VectorXd at_begin = Leg::velocity(series, 0.0, tau);
  if (leg.has_end_rows()) flow.end_inertia = leg.end_power(at_begin, Leg::velocity(series, sigma, tau) - at_begin);
  for (const auto [node, weight] : gauss(8)) {
    const double at = sigma * (1.0 + node) / 2, share = tau * sigma * weight / 2;
    const VectorXd v = Leg::velocity(series, at, tau);
    const VectorXd a = leg.has_end_rows() || of_frame ? Leg::acceleration(series, at, tau) : VectorXd();
    if (of_frame) flow.add(share, of_frame(at, Leg::displacement(series, at), v, a));
    flow.dissipated += share * leg.dissipation(v);
    if (load.cols() > 0) flow.work += share * v.dot(Leg::displacement(load, at));
    if (leg.has_end_rows()) flow.end_inertia += share * leg.end_power(v - at_begin, a);
  }
  return flow;
}

SampledFlow sampled_flow(const Leg& leg, std::span<const VectorXd> displacements, std::span<const VectorXd> velocities,
                         std::span<const VectorXd> loads, std::span<const VectorXd> accelerations, double tau,
                         const FrameFlow& of_frame) {
  constexpr std::array<double, 5> fine = {989.0 / 28350, 5888.0 / 28350, -928.0 / 28350, 10496.0 / 28350,
                                          -4540.0 / 28350};
  constexpr std::array<double, 5> coarse = {217.0 / 5670, 1024.0 / 5670, 352.0 / 5670, 1024.0 / 5670, 436.0 / 5670};
  SampledFlow sampled;
  EnergyFlow &flow = sampled.flow, other;
  for (std::size_t k = 0; k <= 8; ++k) {
    const std::size_t weight = std::min(k, 8 - k);
    const VectorXd& a = accelerations.empty() ? velocities[k] : accelerations[k];  // not looked at without end rows
    EnergyFlow& power = sampled.powers[k];
    if (of_frame) power.add(tau, of_frame(static_cast<double>(k) / 8.0, displacements[k], velocities[k], a));
    power.dissipated += tau * leg.dissipation(velocities[k]);
    if (!loads.empty()) power.work += tau * velocities[k].dot(loads[k]);
    if (leg.has_end_rows()) {
      const VectorXd gained = velocities[k] - velocities[0];
      power.end_inertia += tau * leg.end_power(gained, a);
      sampled.at_ends[k] = leg.end_power(velocities[0], gained);
    }
    flow.add(fine[weight], sampled.powers[k]);
    other.add(coarse[weight], sampled.powers[k]);
  }
  sampled.error = std::max({std::abs(flow.dissipated - other.dissipated), std::abs(flow.work - other.work),
                            std::abs(flow.end_inertia - other.end_inertia)});
  flow.end_inertia += sampled.at_ends[8];
  return sampled;
}

EnergyFlow SampledFlow::until(double sigma) const {
  EnergyFlow sum;
  // Lagrange's polynomial of sample k.
  const auto part = [](std::size_t k, double at) {
    double share = 1.0;
    for (std::size_t j = 0; j <= 8; ++j)
      if (j != k) share *= (8.0 * at - static_cast<double>(j)) / (static_cast<double>(k) - static_cast<double>(j));
    return share;
  };
  for (std::size_t k = 0; k <= 8; ++k) {
    for (const auto [node, weight] : gauss(5))  // exact for degree 8
      sum.add(sigma * weight / 2 * part(k, sigma * (1.0 + node) / 2), powers[k]);
    sum.end_inertia += part(k, sigma) * at_ends[k];
  }
  return sum;
}

}  // namespace viscobar::exponential
