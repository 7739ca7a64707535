#pragma once

#include <array>
#include <span>

#include "dynamics/penalised_system.hpp"
#include "integration/exponential/linear_leg.hpp"

namespace viscobar::exponential {

/// Energy that viscosity and dashpots take, that the load gives, and that the end rows of the mass take. The power of
/// those is v.N a = v_0.N a + (v - v_0).N a, v_0 the velocity where the step begins. The first part is the rate of
/// v_0.N v, which is taken as it is: what a is wrong by, E/h times the roundings of u, would add up in a long flight.
struct EnergyFlow {
  double dissipated = 0.0, work = 0.0, end_inertia = 0.0;
  /// Adds so many times another.
  void add(double factor, const EnergyFlow& other) {
    dissipated += factor * other.dissipated;
    work += factor * other.work;
    end_inertia += factor * other.end_inertia;
  }
};

/// The power of these on a step, of motions that are Taylor series about points of it.
class StepPower {
 public:
  using Series = LinearLeg<double>::Series;

  /// On the step from t on, of length tau, by the motion and the load about its beginning: `load` are the nodal
  /// coefficients on the step, the constant part included; no columns without a load.
  StepPower(const PenalisedSystem& system, double t, double tau, const Series& motion, Eigen::MatrixXd load)
      : system_(system), t_(t), tau_(tau), begin_(velocity(motion, 0.0)), load_(std::move(load)) {}

  /// At the part sigma of the step, which is `at` from where the series is about, but for the power of v_0.
  EnergyFlow operator()(double sigma, const Series& motion, double at) const;
  /// v_0.N (v - v_0)
  double of_begin(const Series& motion, double at) const;
  double length() const { return tau_; }  ///< tau
  Eigen::VectorXd velocity(const Series& motion, double at) const {
    return LinearLeg<double>::velocity(motion, at, tau_);
  }

 private:
  const PenalisedSystem& system_;
  double t_, tau_;
  Eigen::VectorXd begin_;  // v_0
  Eigen::MatrixXd load_;
};

/// The flow over the part [0, sigma] of a step that one Taylor series covers, by Gauss' rule with eight points.
EnergyFlow gauss_flow(const StepPower& power, const StepPower::Series& motion, double sigma);

/// The flow over a whole step from the motion about its eighths, by the rule of Newton and Cotes, of degree 9. `error`
/// is how far Romberg's rule on these points, of degree 7, is off.
struct SampledFlow {
  EnergyFlow flow;
  double error = 0.0;
  std::array<EnergyFlow, 9> powers;  ///< at the eighths, times the length of the step
  std::array<double, 9> at_ends{};   ///< there: v_0.N (v - v_0), which is in none of the powers

  /// The flow over the part [0, sigma] of the step: the integral of the polynomial through the powers.
  EnergyFlow until(double sigma) const;
};
SampledFlow sampled_flow(const StepPower& power, std::span<const StepPower::Series> motion);

}  // namespace viscobar::exponential
