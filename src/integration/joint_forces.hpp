#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "dynamics/acting_load.hpp"
#include "dynamics/contact_rows.hpp"
#include "dynamics/contacts.hpp"
#include "integration/point_values.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// The forces of closed contacts at joints of a chain, and of obstacles that meet a body as another contact does, each
/// by the row beside it (see JointRow),
///
///     sign N = d/dt (inertia . v + c (u_node - u_next) + c_0 u_node) + k (u_node - u_next) + k_0 u_node - f_0 -
///              (M f)_node + (M (k u + c v))_node,
///
/// and the account of it: int N dt, and max N of the polynomial of each step.
///
/// Where there is no row, its law has the force.
class JointForces {
 public:
  /// Both outlive it. Without such contacts it asks for nothing.
  JointForces(const Contacts& contacts, const ActingLoad& load, RunAccount& account);

  void ask_for(std::vector<std::size_t>& entries);
  /// `origin` is added to u to have displacements from here on; empty: nothing.
  void measure_from(std::span<const double> origin) { origin_ = origin; }
  /// Takes the rows as the contacts are now, wherever they change.
  void begin();
  void select(std::vector<std::size_t>& positions) const;
  bool closed() const;
  /// At the points of a step, by the entries of all.
  void look_at(double from, double to, std::size_t order, std::span<const PointValues> y);
  void strike(std::size_t contact, double impulse, std::span<const double> change);
  /// Adds a step of that length, which ends at `to`.
  void add(double to, double length, std::size_t order, bool peaks);

 private:
  struct Joint {
    std::size_t contact;
    ContactAccount* account;
    JointRow row;
    double direction;                        // of its force: the row's sign at a joint, of an obstacle that of u
    std::array<std::size_t, 6> positions{};  // of u_node, u_next, the three velocities and u_beyond
    PointValues momentum{}, rate{}, load{};  // the last of the rows that are added
  };

  void look_at(Joint& joint, std::size_t order, std::span<const PointValues> y) const;
  /// Positions that are used: the last is of a side that resists.
  std::size_t used() const { return contacts_.bar().side() ? 6 : 5; }

  const Contacts& contacts_;
  const ActingLoad& load_;
  std::vector<Joint> joints_;
  std::span<const double> origin_;
};

}  // namespace viscobar
