#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/acting_load.hpp"
#include "dynamics/contact_rows.hpp"
#include "dynamics/contacts.hpp"
#include "integration/linear_form.hpp"
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

  /// Appends the entries of (u, w) that its forms take, for a method that samples those.
  void ask_for(std::vector<std::size_t>& entries);
  /// Appends the forms that it takes as long as the contacts are as they are.
  void ask_for(std::vector<LinearForm>& forms);
  /// `origin` is added to u to have displacements from here on; empty: nothing.
  void measure_from(std::span<const double> origin) { origin_ = origin; }
  /// Takes the rows as the contacts are now, wherever they change, in the state (u, w).
  void begin(std::span<const double> u, std::span<const double> w);
  /// Takes the forces into the peaks with which dashpots of contacts begin that have just closed, in that state at t:
  /// for a method whose first steps are so short that they tell them worse.
  void take_first_forces(double t, std::span<const double> u, std::span<const double> w);
  bool closed() const;
  /// Adds the step, or the part of one, from `from` up to `to`, by all forms at its points.
  void add(double from, double to, std::size_t order, std::span<const PointValues> forms, bool peaks);
  void strike(std::size_t contact, double impulse, std::span<const double> change);

 private:
  struct Joint {
    std::size_t contact;
    ContactAccount* account;
    JointRow row;
    double direction;                     // of its force: the row's sign at a joint, of an obstacle that of u
    double momentum = 0.0;                // of the terms of its momentum without their signs, as the leg begins
    std::optional<double> load_factor{};  // of the rows that are added, where they have one
    double rest = 0.0;                    // of the rate, beside its form and the load
    std::size_t forms = 0;                // the place of that of the momentum, and behind it that of the rate
    PointValues load{};                   // of the rows that are added
  };

  // True if its largest force is the first, but for what other contacts do.
  bool has_dashpot(const Joint& joint) const {
    const ContactNode& contact = contacts_[joint.contact];
    return !contact.by_law && !contact.holds && contact.law.linear().damping > 0.0;
  }
  void add(Joint& joint, double to, double length, std::size_t order, const PointValues& momentum,
           const PointValues& rate, bool peaks);

  const Contacts& contacts_;
  const ActingLoad& load_;
  std::vector<Joint> joints_;
  std::span<const double> origin_;
  PointValues history_{};  // of the load
};

}  // namespace viscobar
