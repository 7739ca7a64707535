#pragma once

#include <optional>
#include <string>

#include "viscobar/case/case.hpp"

namespace viscobar {

/// Why the peak reaction of an impact at an end of this run has no limit as the discretisation is refined, in a
/// sentence; absent where it has one. Reactions of an impact with speed V, m the effective mass of the contact node:
///
///     a scheme, a node with mass       m V / dt
///     a dashpot b = 2 zeta sqrt(k m)   b V at once
///     a spring k = 1 / epsilon, m > 0  V sqrt(k m), where that is more than the bar's own V sqrt(rho E)
///     a viscous bar                    V sqrt(rho eta / (pi t))
std::optional<std::string> peak_remark(const Case& run, const BarSystem& system);

}  // namespace viscobar
