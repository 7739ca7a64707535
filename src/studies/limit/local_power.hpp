#pragma once

#include <span>

#include "studies/limit/mesh_runs.hpp"
#include "viscobar/studies/limit/limit.hpp"

namespace viscobar::limit {

/// Powers of epsilon in u_epsilon - U at each row of a mesh, by derivatives of its runs (see LocalPower), U the traces
/// `limit`. Both norms are those of the common times, the integral by the trapezoidal rule, and so the formulas hold of
/// them exactly, but for one thing: the time of the largest difference hops from one to the next as epsilon falls, and
/// the power with it, by no more than it differs between neighbouring times. Differences below `floor`, the error of
/// the time integration in them, have none.
void add_local_powers(const MeshRuns& mesh, const EndTraces& limit, double floor, std::span<LimitRow> rows);

}  // namespace viscobar::limit
