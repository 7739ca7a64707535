#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "dynamics/penalised_system.hpp"

namespace viscobar {

/// Reactions of the contacts at the left and the right end, and of those of a span obstacle, in the direction of u, the
/// sum of s_i R_i.
std::array<double, 3> reactions(PenalisedSystem& system, double t, std::span<const double> u,
                                std::span<const double> w);
/// N of each contact of a joint, of closed ones, in the order of the contacts; 0 of the others.
std::vector<double> joint_forces(PenalisedSystem& system, double t, std::span<const double> u,
                                 std::span<const double> w);
/// Reaction of a closed contact that holds, as its row gives it, of either sign; at a joint N.
double holding_force(PenalisedSystem& system, std::size_t i, double t, std::span<const double> u,
                     std::span<const double> w);
/// The remainder of the row of contact i, whose node has no mass, on its obstacle: it holds the node there, R >= 0
/// where it pushes. R = -(E (u_1 + s gap) + eta w_1) s / h - s (M f)_i, less k gap of a spring at that end.
double row_reaction(PenalisedSystem& system, std::size_t i, double t, std::span<const double> u,
                    std::span<const double> w);
/// Reaction that keeps the node of contact i, which has mass and is open now, from accelerating, R >= 0 where it
/// pushes: -m s a with rho M a = F, m = k / omega^2. Its error is that of F and no stiffness times a depth. `w` is
/// completed, `force` is scratch.
double resting_force(PenalisedSystem& system, std::size_t i, double t, std::span<const double> u, std::span<double> w,
                     std::span<double> force);

}  // namespace viscobar
