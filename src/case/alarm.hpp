#pragma once

#include <optional>
#include <string>
#include <vector>

#include "viscobar/case/case.hpp"

namespace viscobar {

/// A contradiction between the numbers of a run: its method promises less, or no use can be made of such an error.
struct Alarm {
  std::string what;      ///< the two numbers that disagree, and by how much
  bool ruinous = false;  ///< true if nothing of the result can be relied on
};

/// The sentence about a run whose energies are no longer numbers; absent: they are.
std::optional<std::string> overflow(const Statistics& statistics);

/// Alarms of a run of `system`, that of the case, which came to its end, by what it knows of itself; none where it is
/// sound.
///
/// - The energy balance, |final + dissipated - initial - work|, beyond what the promise of the tolerances makes of it,
///
///       2 * 100 (relative E + a_v sqrt(2 E rho L) + a_u 2 J sqrt(2 E modulus / L)),
///
///   E the largest energy on the way (EnergyAccount::largest, less what the balance is off by), a_u and a_v the
///   allowance(), and in any case beyond 5 % of E, as a warning. Of `exponential` and the
///   schemes, which close their balance to rounding, beyond 1e-9 E and what roundings r U of the displacement add up
///   to in N steps, sqrt(N) r U 2 J sqrt(2 E modulus / L), U = max(|u_0|, t sqrt(2 E / (rho L))). Ruinous beyond that
///   and a hundredth of E.
/// - A dissipated energy that is negative by more than that: energy grew without a cause.
/// - A penetration deeper than all the energy there was could press its spring, d^2 k / 2 > E, where no load works.
///   Ruinous.
/// - An opening with a pull left, LateOpening::ratio > 10, ruinous above 100.
std::vector<Alarm> alarms(const Setup& setup, const BarSystem& system, const Statistics& statistics);

}  // namespace viscobar
