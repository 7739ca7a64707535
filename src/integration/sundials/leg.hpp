#pragma once

#include <exception>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dynamics/derivative/derivative.hpp"
#include "integration/layout.hpp"
#include "integration/sundials/return_flags.hpp"
#include "integration/sundials/vector.hpp"
#include "viscobar/discretisation/tridiagonal.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar::sundials {

/// The equations of one implicit step on a leg of constant contact states, where the system is linear: one force, one
/// solve with D(m,c,k), and no iteration. What CVODE and IDA call is a SUNNonlinearSolver made of it.
class Leg {
 public:
  /// `find_correction` solves the equations of a step of the library.
  Leg(PenalisedSystem& of, const Layout& placed, Statistics& counted, std::span<Derivative* const> of_parameters,
      void (*find_correction)(Leg&, std::span<double> correction))
      : system(of),
        layout(placed),
        statistics(counted),
        derivatives(of_parameters),
        solve_step(find_correction),
        field(placed.nodes) {
    if (placed.end_inertia || !of_parameters.empty()) acceleration.resize(placed.nodes);
    if (of.bar().side() || of.contacts().bend() || !of_parameters.empty()) new_u.resize(placed.nodes);
    if (!of_parameters.empty()) new_w.resize(placed.nodes);
  }

  /// x <- D(m,c,k)^{-1} x; factorises only when a coefficient or a contact has changed.
  void solve(double m, double c, double k, std::span<double> x);

  /// A solve finds an increment x: u becomes u + (k / factor) x, w becomes w + (c / factor) x, and the forces have
  /// entered the right-hand side times `factor`.
  struct Increment {
    const double *u, *explicit_u, *w;  // u is the sum of the first two; the second may be null
    double factor;
  };
  /// The same with the closed contacts that are not linear, by the forces of the bar or of a derivative of it: D x =
  /// right + factor sum_i s_i (N_i(x) - N_i(0)) e_i, at a joint e_b - e_a. Without them it is the same; with z_i =
  /// D^{-1} e_i, which stay as the factor does,
  ///
  ///     x = D^{-1} right + factor sum_i s_i (N_i(x_i) - N_i(0)) z_i,
  ///
  /// an equation for each contact, of x_i = e_i . x, by Newton's method.
  void solve(PenalisedSystem& forces, double m, double c, double k, const Increment& to, std::span<double> x);

  /// x of  x = gamma f(t, y + x) + factor z  for the first-order form y' = f(t, y) = (w, (rho M)^{-1} F): the corrector
  /// of CVODE and a stage of ARKODE. Put x_u = gamma (w + x_w) + factor z_u into the momentum rows and multiply those
  /// by rho M, which is then never inverted:
  ///
  ///     D(1, gamma, gamma^2) x_w = gamma F(t, u + gamma w + factor z_u, w) + factor rho M z_w,
  ///
  /// right for massless rows, too, where rho M = 0. The derivatives have the same matrix: a solve each.
  void solve_first_order(double t, double gamma, std::span<const double> y, double factor, std::span<const double> z,
                         std::span<double> x);

  /// Completes the rate of a state y whose velocities, those of massless nodes included, are layout.u(rate).
  void evaluate(double t, std::span<double> y, std::span<double> rate);
  /// rate = f(t, y), the velocities of massless nodes being those of their rows.
  void right_hand_side(double t, std::span<double> y, std::span<double> rate);

  /// Rates of the impulse entries of a block s + x.
  void impulse_rates(Derivative& derivative, const Moment& at, std::span<const double> s, std::span<const double> x,
                     std::span<double> rates);

  /// out -= factor * rho M x
  void subtract_inertia(double factor, std::span<const double> x, std::span<double> out);

  /// Rates of the energy account for the displacement u, the velocity w and the acceleration a.
  void account_rates(double t, std::span<const double> u, std::span<const double> w, std::span<const double> a,
                     std::span<double> y_rate);

  PenalisedSystem& system;
  Layout layout;
  Statistics& statistics;
  std::span<Derivative* const> derivatives;
  void (*solve_step)(Leg&, std::span<double> correction);
  std::vector<double> new_u, new_w;    // of the step solved for, where somebody asks
  std::vector<double> field;           // scratch, one entry a node
  std::vector<double> acceleration;    // scratch, where the energy account needs it
  std::span<const double> correction;  // of the step or stage solved for last; valid until the next
  double account_correction = 0.0;     // largest of the energy account, at the step solved for last
  std::exception_ptr error;            // thrown inside a callback, to be rethrown outside the C frames
  std::string library_message;         // last message of SUNDIALS
  void* memory = nullptr;              // of the integrator

 private:
  void derivative_rates(double t, std::span<const double> y, std::span<double> y_rate);
  void solve_momentum(PenalisedSystem& forces, double t, double gamma, std::span<const double> y, double factor,
                      std::span<const double> z, std::span<double> x);

  // z of a contact; e . (u + explicit u) as its clearance, e . w, N there, e . x before and after, what is added.
  struct Column {
    std::size_t contact;
    std::vector<double> z;
    double clearance = 0.0, w = 0.0, force = 0.0, start = 0.0, y = 0.0, added = 0.0, slope = 0.0;
  };
  void find_columns();

  std::vector<Column> columns_;  // of this factor, of closed contacts that are not linear
  std::vector<double> newton_;   // the Jacobian by rows, and the residual
  bool columns_known_ = false;
  BandedMatrix matrix_;
  TridiagonalFactor factor_;
  double m_ = 0.0, c_ = 0.0, k_ = 0.0;
  std::uint64_t revision_ = 0;
  bool factorised_ = false;
};

/// A SUNNonlinearSolver whose Solve is solve_step() of a leg, which must outlive it.
NonlinearSolver make_step_solver(Leg& leg, const Context& context);

/// Runs a callback's body; an exception is kept in the leg and becomes -1, since none may cross a C frame.
template <class Body>
int guarded(Leg& leg, Body&& body) noexcept {
  try {
    body();
    return 0;
  } catch (...) {
    leg.error = std::current_exception();
    return -1;
  }
}

/// Throws what a callback kept, or a StepFailure that says what a flag of the library means, and what the library said.
[[noreturn]] void fail(Leg& leg, const std::string& call, int flag, const std::string& name, Library library);

}  // namespace viscobar::sundials
