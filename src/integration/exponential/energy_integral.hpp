#pragma once

#include <array>

#include "integration/exponential/linear_leg.hpp"

namespace viscobar::exponential {

/// Energy that viscosity and dashpots take and that the load gives.
struct EnergyFlow {
  double dissipated = 0.0, work = 0.0;
};

/// The flow over the part [0, sigma] of a step that one Taylor series covers, by Gauss' rule with eight points.
/// `load` are the nodal coefficients of the load on the step, the constant part included; no columns without a load.
EnergyFlow gauss_flow(const LinearLeg<double>& leg, const LinearLeg<double>::Series& series,
                      const Eigen::MatrixXd& load, double tau, double sigma);

/// The flow over a whole step from the Taylor coefficients (four or more) of u and load about its begin, middle and
/// end: the rule of degree 9 in the values and two derivatives of the powers at these points. `error` is how far the
/// rule of degree 7, which leaves out the curvature in the middle, is from it.
struct HermiteFlow {
  EnergyFlow flow;
  double error = 0.0;
};
HermiteFlow hermite_flow(const LinearLeg<double>& leg, const std::array<LinearLeg<double>::Series, 3>& series,
                         const std::array<Eigen::MatrixXd, 3>& load, double tau);

}  // namespace viscobar::exponential
