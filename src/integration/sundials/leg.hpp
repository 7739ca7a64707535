#pragma once

#include <cstddef>
#include <exception>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "integration/sundials/vector.hpp"
#include "viscobar/discretisation/tridiagonal.hpp"
#include "viscobar/dynamics/penalised_system.hpp"
#include "viscobar/dynamics/run.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar::sundials {

/// Where things are in the state y = (u, w, energy account): u and w have an entry for each unknown node (the w of a
/// massless one is dependent: it is carried along without a weight in the error test), the account has an entry for
/// each of dissipation and work that the scene has and the user wants.
struct Layout {
  Layout(const PenalisedSystem& system, bool energy) : nodes(system.size()), size(2 * nodes) {
    if (energy && system.dissipates()) dissipated = size++;
    if (energy && system.loaded()) work = size++;
  }
  std::span<double> u(std::span<double> y) const { return y.first(nodes); }
  std::span<double> w(std::span<double> y) const { return y.subspan(nodes, nodes); }

  std::size_t nodes, size;
  std::optional<std::size_t> dissipated, work;
};

/// Error weights of Tolerance: 1 / (relative max|u| + absolute) for each entry of u, likewise for w, 0 for dependent
/// entries and the energy account. The maxima run over the time passed, so that a bar at rest for a moment does not ask
/// for absurd accuracy.
class ErrorWeights {
 public:
  ErrorWeights(const PenalisedSystem& system, const Layout& layout, const Tolerance& tolerance)
      : layout_(layout),
        tolerance_(tolerance),
        massive_begin_(system.bar().massive_begin()),
        massive_end_(system.bar().massive_end()),
        accumulated_(system.dissipates() ? 150.0 : 1000.0),
        tightening_(1.0) {}

  /// `noise` is what the velocities are not known better than.
  void fill(std::span<double> y, double noise, std::span<double> weights);
  /// The local tolerance is the requested one divided by 150 + 6 (contact changes so far), or by 1000 + 6 (...) where
  /// nothing dissipates: local errors add up, an undamped bar forgets none of them, and a bounce multiplies what was
  /// there before it. Measured in docs/methods.md.
  void tighten(std::size_t changes) {
    if (tolerance_.control == ErrorControl::global) tightening_ = accumulated_ + 6.0 * static_cast<double>(changes);
  }
  double largest_displacement() const { return largest_u_; }
  double displacement_tolerance() const;

 private:
  Layout layout_;
  Tolerance tolerance_;
  std::size_t massive_begin_, massive_end_;
  double largest_u_ = 0.0, largest_w_ = 0.0, accumulated_, tightening_;
};

/// The equations of one implicit step on a leg of constant contact states, where the system is linear: one force, one
/// solve with D(m,c,k), and no iteration. What CVODE and IDA call is a SUNNonlinearSolver made of it.
class Leg {
 public:
  Leg(PenalisedSystem& of, const Layout& placed, Statistics& counted)
      : system(of), layout(placed), statistics(counted), field(placed.nodes) {}

  /// x <- D(m,c,k)^{-1} x; factorises only when a coefficient or a contact has changed.
  void solve(double m, double c, double k, std::span<double> x);

  /// What the velocities may be wrong by through the rounding of closed contacts, at the step solved for last.
  double contact_noise() const { return system.contact_noise(rate()); }
  /// 1 / gamma of CVODE, cj of IDA, at the step solved for last; 0 before the first.
  double rate() const { return factorised_ ? m_ / c_ : 0.0; }

  /// out -= factor * rho M x
  void subtract_inertia(double factor, std::span<const double> x, std::span<double> out);

  /// Rates of the energy account for the velocity w.
  void account_rates(double t, std::span<const double> w, std::span<double> y_rate);

  PenalisedSystem& system;
  Layout layout;
  Statistics& statistics;
  std::vector<double> field;    // scratch, one entry a node
  std::exception_ptr error;     // thrown inside a callback, to be rethrown outside the C frames
  std::string library_message;  // what SUNDIALS said last
  void* memory = nullptr;       // of the integrator

 private:
  SymmetricTridiagonal matrix_;
  TridiagonalFactor factor_;
  double m_ = 0.0, c_ = 0.0, k_ = 0.0;
  std::uint64_t revision_ = 0;
  bool factorised_ = false;
};

/// A step that could not be made.
struct StepFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A SUNNonlinearSolver whose Solve is `solve(leg, correction)`, 0 on success. `leg` must outlive it.
NonlinearSolver make_step_solver(Leg& leg, void (*solve)(Leg&, std::span<double> correction), const Context& context);

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

/// Throws what a callback kept, or a StepFailure made of the call, the flag's name and the library's message.
[[noreturn]] void fail(Leg& leg, const char* call, std::string flag);

}  // namespace viscobar::sundials
