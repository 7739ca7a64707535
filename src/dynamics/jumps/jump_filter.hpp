#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/element_springs.hpp"
#include "dynamics/penalised_system.hpp"

namespace viscobar {

class Derivative;

/// At an instant at which nodal forces b or their rates jump, by [b] and [b'], no mesh resolves what the jump sets
/// going in its high modes, and those near the upper edge of its spectrum stay at the end and ring: the velocity of an
/// end never converges. So the high modes of the mass `fourth_order` are put at their new equilibrium,
///
///     v += theta (h^2 rho / E) G(A) (rho M)^{-1} [b'],       u += theta (h^2 rho / E) G(A) (rho M)^{-1} ([b] - C [v]),
///     A = (h^2 rho / E) (rho M)^{-1} K,     G(mu) = g(mu) / mu,     g = 0 below mu = 1, 1 above 6, smooth in between,
///
/// M, K, C with masses, springs, dashpots and viscosity, nodes of closed contacts held. G is a polynomial in A: 50
/// solves and products. From theta = max(0, 1 - 2 eta^2 / (h^2 rho E))^4 = 0 on high modes creep as those of the bar
/// do, and nothing is done; nor where a span obstacle bounds all nodes, and on meshes of less than 8 elements, which
/// have no mode with mu < 1 to leave alone. See docs/fourth-order.md.
class JumpFilter {
 public:
  static constexpr std::size_t fewest_elements = 8;
  /// Refers to the bar, which outlives it.
  explicit JumpFilter(const BarSystem& bar);
  bool acts() const { return share_ > 0.0; }  ///< theta > 0

  /// The energy that a jump took, and the work of the load on the way.
  struct Taken {
    double energy = 0.0, work = 0.0;
  };
  /// Differences below these need no correction.
  struct Negligible {
    double displacement, velocity;
  };

  /// At the start of a run: [b] = F(t, u, v), [b'] = b' - K v, so that data which fit the ends change by no more than
  /// the error of the mesh.
  Taken begin(PenalisedSystem& system, double t, const Negligible& negligible, std::span<double> u,
              std::span<double> w);
  /// Where the load breaks at t; nothing elsewhere, nor where a motion has a kink. `end` as in
  /// ActingLoad::begin_leg().
  Taken pass_break(PenalisedSystem& system, double t, double end, std::span<double> u, std::span<double> w);
  /// The derivatives s of a state that the last call of begin() or pass_break() has put right, with those of
  /// [b] and [b'], which are overwritten. Shifts are linear in the data, go like h / E, and with theta.
  void differentiate(Derivative& derivative, std::span<double> force, std::span<double> rate, std::span<double> s,
                     std::span<double> s_rate);
  bool has_shifted() const { return shifted_; }  ///< true if that call changed anything
  /// Those of [b] and [b'] of begin(), before it: the derivative is driven by the bar's motion.
  void start_rates(Derivative& derivative, double t, std::span<const double> w, std::span<const double> s,
                   std::span<const double> s_rate, std::span<double> force, std::span<double> rate);

 private:
  double fading(const Derivative& derivative) const;  // theta' / theta
  bool jumps_with_frame(double t, double end) const;
  void add_changes(const Derivative& derivative, std::span<const double> x, std::span<const double> x_rate,
                   std::span<double> force) const;
  void prepare(const PenalisedSystem& system);
  void stiffness(std::span<const double> x, std::span<double> out) const;
  void damping(std::span<const double> x, std::span<double> out) const;
  void forces(std::span<const double> x, double factor, auto&& of_end, double (SideRows::*of_side)(std::size_t) const,
              std::span<double> out) const;
  bool is_smooth(std::span<const double> force, double negligible);
  void apply(std::span<double> force);
  void quieten(std::span<double> x) const;
  void answer_with_dashpots(std::span<const double> step, std::span<double> w);
  void take_high_part(std::span<const double> x, std::span<double> high);
  // Springs and masses at the two ends, beside those that they have, and springs along the bar: so many times those of
  // `sides`, and so many times the bar's own.
  struct Added {
    std::array<double, 2> stiffness{}, mass{};
    std::span<const SideRows> sides{};
    double of_sides = 0.0, of_own = 0.0;
  };
  double largest_side(const Added& change) const;
  template <class Function>
  void add_slope(const Added& change, Function&& f, std::span<double> out);
  void factorise();
  Taken put(PenalisedSystem& system, double t, std::span<double> force, std::span<double> rate, std::span<double> u,
            std::span<double> w);

  const BarSystem& bar_;
  double share_ = 0.0, scale_ = 0.0, top_ = 0.0;  // theta; h^2 rho / E; the largest mu
  std::array<bool, 2> deaf_{};                    // ends whose dashpot lets no high mode ring
  ElementSprings stiffness_;                      // K
  std::vector<double> coefficients_;              // of G on [0, top]
  TridiagonalFactor factor_;                      // of rho M, nodes of closed contacts being held
  std::optional<std::array<bool, 2>> held_;
  std::vector<double> first_, second_, next_, start_, force_, rate_;  // scratch
  Added added_;
  // Results of the last put(): its jumps, C v in them, its shifts, and the answers of dashpots.
  std::vector<double> jump_force_, jump_rate_, shift_u_, shift_w_, impulse_;
  double part_ = 1.0;                 // of the former, short of an obstacle
  std::optional<std::size_t> bound_;  // the contact of that obstacle
  bool shifted_ = false;
};

}  // namespace viscobar
