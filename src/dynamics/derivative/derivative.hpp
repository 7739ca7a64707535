#pragma once

#include <array>
#include <span>
#include <vector>

#include "dynamics/contact_rows.hpp"
#include "dynamics/derivative/matrix_rates.hpp"
#include "dynamics/penalised_system.hpp"
#include "viscobar/dynamics/sensitivity.hpp"

namespace viscobar {

/// A state of a penalised system, as that measures it, and what derivatives are driven by.
struct Moment {
  double t = 0.0;
  std::span<const double> u, w;
  std::span<const double> a;  ///< u''; empty: its force of inertia is to be left out
};

/// The equation of s = du/dp on a leg. It is that of the bar itself, with the same contacts closed,
///
///     rho M s'' = M f' - E K s - eta K s' + sum_i sigma_i (k_i d_i^s + b_i d_i^s') e_i + added,
///     d_i^s = -(sigma_i s_i + gap_i'),
///
/// the walls, gaps and the load being replaced by their derivatives, f' = (L f)' / L, under the added force
///
///     -(E K)' u - (eta K)' v - (rho M)' a + sum_i sigma_i (k_i' d_i + b_i' d_i') e_i
///
/// with MatrixRates, -(M (k' u + c' v) + M' (k u + c v)) of a side that resists, and -(k' u + c' v + m' a) at an end
/// with a spring, a dashpot or a mass. Where a frame moves with the ends (see BarSystem), u, v and a in the added force
/// are those of the bar itself, lift included, and s is measured in the frame of d lift / dp.
///
/// So it is a PenalisedSystem of its own, and its dynamic stiffness is that of the bar.
class Derivative {
 public:
  /// `system` outlives it.
  Derivative(PenalisedSystem& system, const Penalty& penalty, const Direction& direction);
  Derivative(const Derivative&) = delete;
  Derivative& operator=(const Derivative&) = delete;

  const BarSystem& data() const { return data_; }  ///< its gaps, walls and data of the start
  State initial_state(double t) const;             ///< of s, in the frame of data()
  PenalisedSystem& motion() { return motion_; }    ///< of s

  /// Reference scale of s in a run up to `end`, over the natural displacement of the bar: from its own data
  /// and gaps, and the relative change of the coefficients of the bar and its contacts.
  double relative_scale(double end) const;

  /// Closes the contacts of the bar, and no others.
  void take_contacts();
  const MatrixRates& matrices() const { return matrices_; }        ///< of the bar
  std::span<const Support> supports() const { return supports_; }  ///< k', c' and m' of the ends, where one is not 0
  /// The derivatives of the rows of a side that resists, M diag(k') and M' diag(k), those of c with them; where they
  /// are not zero.
  std::span<const SideRows> sides() const { return sides_; }
  /// out = (rho M)' x, masses of the ends included; false: that is zero, and nothing is done. O(n)
  bool multiply_inertia(std::span<const double> x, std::span<double> out) const;
  /// True if s has a load, or the frame an added force, that depends on time.
  bool load_varies() const { return motion_.load().varies() || (driven_ && system_.bar().frame().moving()); }
  /// Sets the added force for the state of the bar. O(n)
  void drive(const Moment& at);

  /// Adds the rate of what the frame adds to that force.
  void add_frame_rate(double t, std::span<double> rate) const;

  /// The added force in the row of a massless end alone, for values of the bar there and at the neighbour.
  double drive_row(std::size_t end, double t, double u, double u_next, double w, double w_next) const;

  /// Derivative of the reaction of contact i in the direction of u, the bar being at the moment driven by last.
  double reaction(std::size_t i, const Moment& at, std::span<const double> s, std::span<const double> rate);
  /// Derivatives of Snapshot::joint_forces.
  std::vector<double> joint_forces(const Moment& at, std::span<const double> s, std::span<const double> rate);
  /// Derivative of the reaction whose zero opens closed contact i: the same where it holds(), else that of
  /// row_reaction().
  double opening_reaction(std::size_t i, const Moment& at, std::span<const double> s, std::span<const double> rate);
  /// Derivative of the push condition of contact i (see push_weights()).
  double push_rate(std::size_t i, const Moment& at, std::span<const double> s, std::span<const double> rate) const;
  /// Displacements, velocities and accelerations at all nodes.
  struct Nodal {
    std::span<const double> u, v, a;
  };
  /// Derivative of the force that holds a fixed end (see BarSystem), from the values of the bar itself and of s. O(1)
  double holding_force(bool right, double t, const Nodal& bar, const Nodal& s) const;
  /// Derivatives of (rho M v + eta K u) in the rows of an end, and of its rate without the reaction, (E K u - M f): the
  /// impulse of the obstacles on that end is the one plus the integral of the other. By a law they are 0 and the
  /// reaction.
  /// @param s_rate s' at the end
  double momentum(std::size_t end, const EndRows& rows, const Moment& at, std::span<const double> s,
                  std::span<const double> rate) const;
  double momentum_loss(std::size_t end, const Moment& at, std::span<const double> s, double s_rate = 0.0);
  /// The part of the latter that is linear in (u, s), by their values in the row of the end and the differences of the
  /// last of its rows to the one beside.
  double elastic_row(std::size_t end, const EndRows& rows, double u, double u_stretch, double s,
                     double s_stretch) const;
  /// The part of it that is the side's, of values u(j) and s(j) at all nodes.
  double side_row(std::size_t end, const EndRows& rows, auto&& u, auto&& s) const {
    const SideRows* own = system_.bar().side();
    if (!own || !rows.strained) return 0.0;
    double sum = at_last(end, rows, *own, [&](std::size_t j) { return own->stiffness(j) * s(j); });
    for (const SideRows& side : sides_)
      sum += at_last(end, rows, side, [&](std::size_t j) { return side.stiffness(j) * u(j); });
    return sum;
  }
  /// Displacements and velocities of the bar itself, at all nodes.
  void expand(double t, std::span<const double> s, std::span<const double> rate, std::span<double> u,
              std::span<double> v) const;
  /// Derivative of the kinetic, elastic and contact energy.
  double energy(const Moment& at, std::span<const double> s, std::span<const double> rate) const;

 private:
  struct LawRates {
    double stiffness, damping;  // of a stop those of its numbers
  };
  void take_sides(const Direction& direction);
  LawRates stop_rates(std::size_t i, const Direction& direction);
  LawRates spring_rates(std::size_t i, const Penalty& penalty, const Direction& direction) const;
  double mass_growth(const Contact& contact) const;
  void add_lift(const Lift& lift, const Lift& rate, const Lift& acceleration, std::span<double> out) const;
  double law_reaction(std::size_t i, const Moment& at, std::span<const double> s, double rate) const;
  // dR/dp at the same motion.
  double law_rate(std::size_t i, double clearance, double w) const;
  // Functions of the node: a lift, displacements in the frame, those of the bar itself, its velocities.
  auto lifted(const Lift& lift) const {
    return [this, lift](std::size_t j) { return lift.at(system_.bar().elements().share(j)); };
  }
  auto in_frame(std::span<const double> u) const {
    return [this, of = system_.bar().unknowns().displacement_at_nodes(u)](std::size_t j) {
      const std::size_t i = j - system_.bar().unknowns().first_node();
      return of(j) + (i < system_.size() ? contacts_.origin().at(i) : 0.0);
    };
  }
  auto placed(std::span<const double> u) const {
    return [of = in_frame(u), by = lifted(lift_[0])](std::size_t j) { return of(j) + by(j); };
  }
  auto moving(std::span<const double> w) const {
    return [of = system_.bar().unknowns().at_nodes(w), by = lifted(lift_[1])](std::size_t j) { return of(j) + by(j); };
  }
  // Terms of the frame, by the end's entry among the unknowns.
  double lift_inertia(std::size_t unknown, const Lift& lift) const;
  double lift_stretch(std::size_t end, std::size_t last, const Lift& lift) const;
  // (M r)_j of the side, j the node of the last row of an end.
  double at_last(std::size_t end, const EndRows& rows, const SideRows& side, auto&& r) const {
    const Unknowns& unknowns = system_.bar().unknowns();
    return side.at_end(rows.last + unknowns.first_node(), unknowns.is_right(end), r);
  }
  double displacement(std::size_t end, std::span<const double> u) const;  // of the bar itself
  // Beside the last row of an end.
  double stretch(std::size_t end, std::size_t last, std::span<const double> x, std::span<const double> origin,
                 const BarSystem& walls) const;

  PenalisedSystem& system_;
  BarSystem data_;
  PenalisedSystem motion_;
  const Contacts& contacts_;  // of the bar
  Contacts& of_contacts_;     // of s
  MatrixRates matrices_;
  std::vector<double> start_;  // see start_of_masses()
  double relative_change_;     // of what the bar and its contacts are made of
  std::vector<LawRates> laws_;
  std::vector<Support> supports_;
  std::vector<SideRows> sides_;
  std::vector<double> added_;
  std::array<std::vector<double>, 2> lift_inertia_;  // (rho M)' (1 - x/L) and (rho M)' x/L, where the frame moves
  std::array<Lift, 3> lift_{};                       // and its rates, at the moment driven by last
  bool driven_ = false;                              // by the motion of the bar
};

}  // namespace viscobar
