#include "integration/exponential/energy_integral.hpp"

#include <algorithm>
#include <cmath>

namespace viscobar::exponential {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Leg = LinearLeg<double>;

EnergyFlow gauss_flow(const Leg& leg, const Leg::Series& series, const MatrixXd& load, double tau, double sigma) {
  constexpr std::array<double, 4> node = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                          0.9602898564975363};
  constexpr std::array<double, 4> weight = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                            0.1012285362903763};
  EnergyFlow flow;
  for (std::size_t i = 0; i < node.size(); ++i)
    for (const double side : {-1.0, 1.0}) {
      const double at = sigma * (1.0 + side * node[i]) / 2, share = tau * sigma * weight[i] / 2;
      const VectorXd v = Leg::velocity(series, at, tau);
      flow.dissipated += share * leg.dissipation(v, v);
      if (load.cols() > 0) flow.work += share * v.dot(Leg::displacement(load, at));
    }
  return flow;
}

namespace {

// A quantity and its derivatives by sigma.
using Jet = std::array<double, 3>;

// Integral over sigma in [0, 1] as weights on (values at the ends, in the middle, slopes, curvatures at the ends, in
// the middle), exact to degree 9 with all of them, to degree 7 without the last.
double integral(const std::array<Jet, 3>& f, const std::array<double, 5>& w) {
  return 0.5 * (w[0] * (f[0][0] + f[2][0]) + w[1] * f[1][0]) + 0.25 * w[2] * (f[0][1] - f[2][1]) +
         0.125 * (w[3] * (f[0][2] + f[2][2]) + w[4] * f[1][2]);
}

double integral(const std::array<Jet, 3>& f, double& error) {
  const double value = integral(f, {41.0 / 105, 128.0 / 105, 2.0 / 35, 1.0 / 315, 16.0 / 315});
  error = std::max(error, std::abs(value - integral(f, {19.0 / 35, 32.0 / 35, 4.0 / 35, 1.0 / 105, 0.0})));
  return value;
}

}  // namespace

HermiteFlow hermite_flow(const Leg& leg, const std::array<Leg::Series, 3>& series, const std::array<MatrixXd, 3>& load,
                         double tau) {
  std::array<Jet, 3> loss{}, power{};
  for (std::size_t at = 0; at < series.size(); ++at) {
    // Powers times tau, so that the integral over sigma is the one over time.
    const VectorXd v = series[at].col(1), rate = 2.0 * series[at].col(2), change = 6.0 * series[at].col(3);
    loss[at] = {leg.dissipation(v, v) / tau, 2.0 * leg.dissipation(v, rate) / tau,
                2.0 * (leg.dissipation(rate, rate) + leg.dissipation(v, change)) / tau};
    const MatrixXd& p = load[at];
    if (p.cols() == 0) continue;
    power[at] = {v.dot(p.col(0)), rate.dot(p.col(0)), change.dot(p.col(0))};
    if (p.cols() == 1) continue;
    power[at][1] += v.dot(p.col(1));
    power[at][2] += 2.0 * rate.dot(p.col(1)) + 2.0 * v.dot(p.col(2));
  }
  HermiteFlow result;
  result.flow = {integral(loss, result.error), integral(power, result.error)};
  return result;
}

}  // namespace viscobar::exponential
