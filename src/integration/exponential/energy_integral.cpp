#include "integration/exponential/energy_integral.hpp"

#include <algorithm>
#include <cmath>

#include "discretisation/gauss.hpp"
#include "dynamics/energy_terms.hpp"

namespace viscobar::exponential {

using Eigen::VectorXd;
using Leg = LinearLeg<double>;

EnergyFlow StepPower::operator()(double sigma, const Series& motion, double at) const {
  const BarSystem& bar = system_.bar();
  const double t = t_ + sigma * tau_;
  const VectorXd v = velocity(motion, at);
  const double loss = frame_loss(bar, t, entries(v));
  EnergyFlow power{.dissipated = dissipated_power(system_.contacts(), entries(v)) + loss, .work = loss};
  if (load_.cols() > 0) power.work += v.dot(Leg::displacement(load_, sigma));
  if (!bar.has_end_rows()) return power;
  const VectorXd u = Leg::displacement(motion, at), a = Leg::acceleration(motion, at, tau_), gained = v - begin_;
  const EndPower beside = end_power(system_, t, entries(u), entries(v), entries(a));
  power.work += beside.of_frame;
  power.end_inertia = bar.inertia().end_power(entries(gained), entries(a)) + beside.of_side + beside.of_frame;
  return power;
}

double StepPower::of_begin(const Series& motion, double at) const {
  if (!system_.bar().has_end_rows()) return 0.0;
  const VectorXd gained = velocity(motion, at) - begin_;
  return system_.bar().inertia().end_power(entries(begin_), entries(gained));
}

EnergyFlow gauss_flow(const StepPower& power, const StepPower::Series& motion, double sigma) {
  EnergyFlow flow{.end_inertia = power.of_begin(motion, sigma)};
  for (const auto [node, weight] : gauss(8)) {
    const double at = sigma * (1.0 + node) / 2;
    flow.add(power.length() * sigma * weight / 2, power(at, motion, at));
  }
  return flow;
}

SampledFlow sampled_flow(const StepPower& power, std::span<const StepPower::Series> motion) {
  constexpr std::array<double, 5> fine = {989.0 / 28350, 5888.0 / 28350, -928.0 / 28350, 10496.0 / 28350,
                                          -4540.0 / 28350};
  constexpr std::array<double, 5> coarse = {217.0 / 5670, 1024.0 / 5670, 352.0 / 5670, 1024.0 / 5670, 436.0 / 5670};
  SampledFlow sampled;
  EnergyFlow &flow = sampled.flow, other;
  for (std::size_t k = 0; k <= 8; ++k) {
    const std::size_t weight = std::min(k, 8 - k);
    sampled.powers[k].add(power.length(), power(static_cast<double>(k) / 8.0, motion[k], 0.0));
    sampled.at_ends[k] = power.of_begin(motion[k], 0.0);
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
