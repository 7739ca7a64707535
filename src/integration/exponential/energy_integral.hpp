#pragma once

#include <array>
#include <functional>
#include <span>

#include "dynamics/frame_energy.hpp"
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

/// Contributions to power and loss at a part of a step, of a frame that moves (see lift_loss) and of the
/// rows of a side that resists; empty where there is neither.
using FrameFlow = std::function<EnergyFlow(double sigma, const Eigen::VectorXd& u, const Eigen::VectorXd& v,
                                           const Eigen::VectorXd& a)>;

/// The flow over the part [0, sigma] of a step that one Taylor series covers, by Gauss' rule with eight points.
/// `load` are the nodal coefficients of the load on the step, the constant part included; no columns without a load.
EnergyFlow gauss_flow(const LinearLeg<double>& leg, const LinearLeg<double>::Series& series,
                      const Eigen::MatrixXd& load, double tau, double sigma, const FrameFlow& of_frame);

/// The flow over a whole step from displacements, velocities, loads and accelerations (n entries each; no displacements
/// without of_frame, no loads without a load, no accelerations for a mass without end rows) at its eighths, by the rule
/// of Newton and Cotes, of degree 9. `error` is how far Romberg's rule on these points, of degree 7, is off.
struct SampledFlow {
  EnergyFlow flow;
  double error = 0.0;
  std::array<EnergyFlow, 9> powers;  ///< at the eighths, times the length of the step
  std::array<double, 9> at_ends{};   ///< there: v_0.N (v - v_0), which is in none of the powers

  /// The flow over the part [0, sigma] of the step: the integral of the polynomial through the powers.
  EnergyFlow until(double sigma) const;
};
SampledFlow sampled_flow(const LinearLeg<double>& leg, std::span<const Eigen::VectorXd> displacements,
                         std::span<const Eigen::VectorXd> velocities, std::span<const Eigen::VectorXd> loads,
                         std::span<const Eigen::VectorXd> accelerations, double tau, const FrameFlow& of_frame);

}  // namespace viscobar::exponential
