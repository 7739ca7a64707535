#pragma once

#include "viscobar/analysis/case.hpp"

namespace viscobar {

/// About how long a sound case takes, in seconds of the machine that docs/sweep.md names. Made for deciding which of
/// several cases to begin with: good to a factor of about three, further off where contacts chatter.
///
///     seconds = start + steps (a + b nodes)
///
/// fully_discrete, finite_difference: steps = T / dt.
/// cvode, ida, rigid: steps = T rate g, g the growth with the tolerance, rate that of what moves and survives,
///     rate = min(c / h, E / eta),
/// because the wave of one element has the rate c / h, and waves above 2 E / eta are overdamped. A contact
/// node that chatters (contact_regimes()) adds its bounces, each half a period of the node on its spring and as many
/// steps as a new start takes; a contact that does not, a fixed number.
/// exponential: matrices, nodes^3 for each contact state, and nodes^2 a sub-step.
double estimated_seconds(const Case& run);

}  // namespace viscobar
