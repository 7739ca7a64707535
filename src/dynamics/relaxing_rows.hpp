#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "dynamics/contacts.hpp"

namespace viscobar {

/// The row of an unknown whose inertia counts for little, of first order, n being its one or two neighbours:
///
///     u_i' + rate u_i = sum_n (u_share u_n + w_share u_n' - a_share u_n'') + load_share (M f)_i + constant.
struct RelaxingRow {
  /// Contribution of the neighbour n.
  struct Neighbour {
    std::size_t unknown;  ///< n
    double u_share;       ///< of its displacement, per time
    double w_share;       ///< of its velocity
    double a_share;       ///< of its acceleration, a time: off the diagonal of the mass
  };
  std::size_t unknown;                  ///< i
  double rate;                          ///< per time
  double load_share;                    ///< of the load, velocity per force
  double constant;                      ///< of springs and fixed ends, a velocity
  double inertia;                       ///< m over the stiffness, a time squared: what u_i'' adds is -rate times it
  std::array<Neighbour, 2> neighbours;  ///< the first `count`
  std::size_t count;                    ///< 1 or 2
};
/// Those of the massless unknowns that are not held, as long as no contact changes; none for eta = 0.
std::vector<RelaxingRow> relaxing_rows(const Contacts& contacts);
/// The row of the node of contact i, with mass, closed on a spring that a step passes over. Without damping it follows
/// its neighbours at 1000 omega.
RelaxingRow resting_row(const Contacts& contacts, std::size_t i);

}  // namespace viscobar
