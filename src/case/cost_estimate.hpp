#pragma once

#include "viscobar/case/case.hpp"

namespace viscobar {

/// About how long a sound case takes, in seconds. Decides which of several cases to begin with.
/// docs/internals/sweep-balance.md names the machine and has the errors of the estimate.
///
///     seconds = start + steps (a + b nodes)
///
/// fully_discrete, finite_difference: steps = T / dt.
///
/// cvode, ida, rigid: steps = g (20 starts + 46 log(1 + J) + 8 phi), g = (tolerance / 1e-4)^(-1/7) from multistep
/// formulas of order about 6. phi is the phase of the fastest wave that is still there at t: no faster than an element
/// lets it be, none that is overdamped, and of those the ones that viscosity has not yet consumed at the rate eta k^2 /
/// (2 rho),
///
///     phi = int min(c / h, E / eta, c sqrt(2 rho / (eta t))) dt.
///
/// The logarithm counts the steps through the decay of the modes from h to L. Starts are contact changes: a
/// few, and where a contact node chatters (contact_regimes()) its bounces. They lose the share pi zeta of the speed
/// each, so that their number is proportional to 1 / (pi zeta); a node that little viscosity ties to the next one
/// (eta / h < 0.2 sqrt(rho E)) flies with the wave instead, and bounces no more than once an element.
///
/// exponential: matrices, nodes^3, and nodes^2 a sub-step.
double estimated_seconds(const Case& run);

}  // namespace viscobar
