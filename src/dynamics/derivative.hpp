#pragma once

#include <array>
#include <span>
#include <vector>

#include "dynamics/penalised_system.hpp"
#include "dynamics/unit_stiffness.hpp"
#include "viscobar/dynamics/sensitivity.hpp"

namespace viscobar {

class Derivative;
struct Piece;

/// A state of a penalised system, as that measures it, and what derivatives are driven by.
struct Moment {
  double t = 0.0;
  std::span<const double> u, w;
  std::span<const double> a, inertia;           ///< u'' and rho M u''; empty: to be left out
  std::span<const double> strain, strain_rate;  ///< K (u + origin), of walls, too, and K w; empty where nobody asks
};

/// Makes moments for derivatives, whose drive they share.
class MomentBuilder {
 public:
  /// Both outlive it.
  MomentBuilder(const PenalisedSystem& system, std::span<Derivative* const> derivatives);
  bool asks_for_inertia() const { return asks_for_inertia_; }
  /// Valid until the next, and as long as its arguments are. O(n)
  Moment operator()(double t, std::span<const double> u, std::span<const double> w, std::span<const double> a);

 private:
  const PenalisedSystem& system_;
  UnitStiffness stiffness_;
  bool asks_for_inertia_ = false;
  std::vector<double> inertia_, strain_, strain_rate_;
};

/// The equation of s = du/dp on a leg. It is that of the bar itself, with the same contacts closed,
///
///     rho M s'' = M f' - E K s - eta K s' + sum_i sigma_i (k_i d_i^s + b_i d_i^s') e_i + added,
///     d_i^s = -(sigma_i s_i + gap_i'),
///
/// the walls, gaps and the load being replaced by their derivatives, f' = (L f)' / L, under the added force
///
///     -(E' - E L'/L) K u - (eta' - eta L'/L) K v - (rho'/rho + L'/L) rho M a + sum_i sigma_i (k_i' d_i + b_i' d_i')
///     e_i.
///
/// with -M ((k' + k L'/L) u + (c' + c L'/L) v) of a side that resists, and at an end with a spring, a dashpot or a mass
/// -(k' u + c' v + (m' - (rho'/rho + L'/L) m) a), for m is in M, and does not go like rho L. Where a frame moves with
/// the ends (see BarSystem), u, v and a in the added force are those of the bar itself, lift included, and s is
/// measured in the frame of d lift / dp.
///
/// (K goes like 1 / L, M like L, on graded meshes, too; nodes stay at their part of the bar.) Of bars in line each has
/// its own numbers, and the first three terms are those of ChainRates; so they are of a parameter of a section, by
/// differences (see Direction::Beside). So it is a PenalisedSystem of its own, and its dynamic stiffness is that of the
/// bar.
class Derivative {
 public:
  /// Derivatives of the matrices of a chain, or of a difference: rho'/rho + L'/L of each bar in M, E' - E L'/L and eta'
  /// - eta L'/L over int dx / A of each element, those of joints that are springs among them.
  struct ChainRates {
    BandedMatrix inertia;
    std::array<std::array<double, 3>, 2> held;  ///< rows of it of fixed ends
    std::vector<double> elastic, viscous;       ///< of each element
    UnitStiffness stiffness, viscosity;         ///< of those
    BandedMatrix whole;                         ///< that of inertia with fixed ends, where the frame moves
  };

  /// `system` outlives it.
  Derivative(PenalisedSystem& system, const Penalty& penalty, const Direction& direction);
  Derivative(const Derivative&) = delete;
  Derivative& operator=(const Derivative&) = delete;

  const BarSystem& data() const { return data_; }  ///< its gaps, walls and data of the start
  State initial_state() const;                     ///< of s
  PenalisedSystem& motion() { return motion_; }    ///< of s

  /// Reference scale of s in a run up to `end`, over the natural displacement of the bar: from its own data
  /// and gaps, and the relative change of the coefficients of the bar and its contacts.
  double relative_scale(double end) const;

  /// To be called where a leg begins.
  void begin_leg(double t, double end) { motion_.load().begin_leg(t, end); }
  /// Closes the contacts of the bar, and no others.
  void take_contacts();
  /// Derivatives of the matrices of the bar, its contacts apart.
  struct MatrixRates {
    double inertia;                     ///< of rho M, relative to it
    double viscosity, modulus;          ///< of eta K and of E K: so many times K
    std::span<const Support> supports;  ///< of springs, dashpots and, as above, masses
    const SideRows* side;               ///< k' + k L'/L and c' + c L'/L; null: none
    const ChainRates* chain;            ///< in place of the first three; null: of one bar
  };
  MatrixRates matrix_rates() const {
    return {inertia_, viscosity_, modulus_, supports_, side_ ? &*side_ : nullptr, chain_ ? &*chain_ : nullptr};
  }
  /// out = (rho M)' x of a chain, springs and masses of its ends included. O(n)
  void multiply_chain_inertia(std::span<const double> x, std::span<double> out) const;
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
  /// Derivatives of (rho M v + eta K u) in the row of an end, and of its rate without the reaction, (E K u - M f): the
  /// impulse of the obstacles on that end is the one plus the integral of the other.
  double momentum(std::size_t end, const Moment& at, std::span<const double> s, std::span<const double> rate) const;
  double momentum_loss(std::size_t end, const Moment& at, std::span<const double> s);
  /// The part of the latter that is linear in (u, s), by their values in the row and their differences to the row
  /// beside.
  double elastic_row(std::size_t end, double u, double u_stretch, double s, double s_stretch) const;
  /// The part of it that is the side's, of values u(j) and s(j) at all nodes.
  double side_row(std::size_t end, auto&& u, auto&& s) const {
    const SideRows* own = system_.bar().side();
    if (!own) return 0.0;
    const bool right = system_.bar().unknowns().is_right(end);
    const double sum = own->at_end(right, [&](std::size_t j) { return own->stiffness(j) * s(j); });
    return side_ ? sum + side_->at_end(right, [&](std::size_t j) { return side_->stiffness(j) * u(j); }) : sum;
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
  void take_side(const Direction& direction, double stretched);
  void take_chain(const Direction& direction);
  void take_difference(const Direction& direction);
  void find_start(const Direction& direction, std::span<const Piece> pieces);
  double mass_growth(const Contact& contact) const;
  double elastic_of(std::size_t element) const {
    return chain_ ? chain_->elastic[element] : modulus_ / system_.bar().elements().stretch(element);
  }
  double viscous_of(std::size_t element) const {
    return chain_ ? chain_->viscous[element] : viscosity_ / system_.bar().elements().stretch(element);
  }
  // dR/dp at the same motion.
  double law_rate(std::size_t i, double clearance, double w) const;
  void add_frame();
  // Terms of the frame, by the end's entry among the unknowns.
  auto placed(std::span<const double> u) const;  // the displacement of the bar itself at a node
  auto moving(std::span<const double> w) const;  // its velocity
  double lift_inertia(std::size_t unknown, const Lift& lift) const;
  double lift_stretch(std::size_t end, const Lift& lift) const;
  double lift_stress(const Lift& lift, const Lift& rate) const;
  double displacement(std::size_t end, std::span<const double> u) const;  // of the bar itself
  double stretch(std::size_t end, std::span<const double> x, std::span<const double> origin,
                 const BarSystem& walls) const;

  PenalisedSystem& system_;
  BarSystem data_;
  PenalisedSystem motion_;
  const Contacts& contacts_;              // of the bar
  Contacts& of_contacts_;                 // of s
  double relative_change_;                // of what the bar and its contacts are made of
  double modulus_, viscosity_, inertia_;  // E' - E L'/L, eta' - eta L'/L, rho'/rho + L'/L
  std::vector<LawRates> laws_;
  std::vector<Support> supports_;  // k', c' and m' - (rho'/rho + L'/L) m of the ends
  std::optional<SideRows> side_;
  std::optional<ChainRates> chain_;
  std::vector<double> added_, product_;
  std::vector<double> start_;  // of a chain, or of a difference: what masses change the initial velocity by; or empty
  std::array<std::vector<double>, 2> lift_inertia_;  // (rho M)' (1 - x/L) and (rho M)' x/L, where the frame moves
  std::array<Lift, 3> lift_{};                       // and its rates, at the moment driven by last
  bool driven_ = false;                              // by the motion of the bar
};

}  // namespace viscobar
