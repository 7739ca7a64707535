#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "dynamics/penalised_system.hpp"

namespace viscobar {

/// Result of an impact.
struct Collision {
  bool rests;                         ///< the contact stays closed
  double dissipated;                  ///< of the energy
  double impulse;                     ///< P, on the bar
  double height;                      ///< H of a rebound onto which the bar is pressed, else 0
  std::vector<std::size_t> released;  ///< closed contacts that the impact would have pulled, open now
};
/// Negligible sizes of a displacement, of (h/E) times a reaction, and of a velocity.
struct NegligibleSizes {
  double displacement;  ///< of the node, the height of a bounce
  double reaction;      ///< times h/E, a displacement
  double velocity;      ///< with which contacts that an impact pulls would part
};
/// The impact of open contact i, which collides, its node being at the obstacle with velocity s w_i <= 0, here for
/// s = 1:
///
///     rho M (w+ - w) = P e_i,    w+_i = -e w_i,    P = -(1 + e) w_i / (e_i . (rho M)^{-1} e_i),
///
/// closed contacts elsewhere holding their nodes as far as they push. A node that is already below the surface by d
/// leaves with e (w_i^2 - 2 A d)^(1/2), where A is the acceleration by which the bar presses it on. The impact takes
/// (1 - e^2) m w_i^2 / 2, where m is the mass in that quotient. With e = 0 the node stays where the bar presses it
/// on, a_i < 0 at w+. With e > 0 it leaves, unless the bounces to come are negligible: it would rise by H = (e w_i)^2
/// / (2 A) and rest after 2 e |w_i| / (A (1 - e)). It rests at once then, w+_i = 0, and nothing is displaced by more
/// than H: but for the node's momentum m u_i', whose integral over time is m H at most, the bar has the same impulse.
Collision collide(PenalisedSystem& system, std::size_t i, double t, std::span<const double> u, std::span<double> w,
                  const NegligibleSizes& negligible);
/// Gives both nodes of each rigid contact of a joint that is closed one velocity again, after a kink of the frame,
/// which changes those of the nodes near an end; momentum is kept.
void tie_joints(const Contacts& contacts, std::span<double> w);

}  // namespace viscobar
