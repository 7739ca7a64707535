#pragma once

#include <cstddef>
#include <vector>

#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar::baseline {

/// Result of every contender of a comparison: u(0, t) at the given times, the steps it took, and the contact changes
/// that it located, if it does.
struct Trace {
  std::vector<double> left;
  std::size_t steps = 0, changes = 0;
};

/// Problem that every contender solves. The mass must be lumped: the baselines need u'' explicitly.
struct Problem {
  const BarSystem& system;
  double epsilon;
  std::vector<double> times;
};

/// The penalised bar as a plain first-order system over y = (u_0, v_0, u_1, v_1, ...): the kink of the penalty is in
/// the right-hand side.
class Interleaved {
 public:
  explicit Interleaved(const Problem& problem);
  std::size_t size() const { return 2 * nodes_; }
  std::vector<double> start() const;
  void rates(const double* y, double* out) const;
  /// Calls set(row, column, value) for each entry of the Jacobian at y.
  template <class Set>
  void jacobian(const double* y, Set&& set) const {
    for (std::size_t i = 0; i < nodes_; ++i) {
      set(2 * i, 2 * i + 1, 1.0);
      const bool first = i == 0, last = i + 1 == nodes_;
      const double sides = (first ? 0.0 : 1.0) + (last ? 0.0 : 1.0), r = inverse_mass_[i];
      double stiffness = -sides * stiffness_;
      if ((first || last) && y[2 * i] < -gap_) stiffness -= penalty_;
      set(2 * i + 1, 2 * i, r * stiffness);
      set(2 * i + 1, 2 * i + 1, -r * sides * damping_);
      if (!first) set(2 * i + 1, 2 * i - 2, r * stiffness_), set(2 * i + 1, 2 * i - 1, r * damping_);
      if (!last) set(2 * i + 1, 2 * i + 2, r * stiffness_), set(2 * i + 1, 2 * i + 3, r * damping_);
    }
  }
  double gap() const { return gap_; }

 private:
  const Problem& problem_;
  std::size_t nodes_;
  double stiffness_, damping_, penalty_, gap_;
  std::vector<double> load_, inverse_mass_;
};

/// Treatment of a contact change by stock CVODE.
enum class AtChange {
  nothing,       ///< steps across the kink
  restart,       ///< locates it by its root finding and re-initialises, with a first step of its own estimation
  restart_kept,  ///< the same with the first step that the last start was given
  restart_last   ///< the same with a tenth of the last step before the change
};

/// CVODE as its examples use it: serial vector, band matrix and band solver, analytic Jacobian, and the formulas given.
Trace stock_cvode(const Problem& problem, double relative, double absolute, AtChange change, bool adams = false);

/// Scheme (2.8) in the paper's way: the system for u^{n+1}, solved without obstacles, and again with the left, the
/// right, both ends held, until a solution fits. Returns u^n(0) of every step.
std::vector<double> paper_scheme(const BarSystem& system, double step, std::size_t steps);

/// The same, plain but quick: factored once, the ends by the columns of the inverse.
std::vector<double> plain_scheme(const BarSystem& system, double step, std::size_t steps);

/// Boost.Odeint: rosenbrock4 (dense matrices, small meshes only) and dopri5, each with its error control.
Trace rosenbrock4(const Problem& problem, double relative, double absolute);
Trace dopri5(const Problem& problem, double relative, double absolute);

}  // namespace viscobar::baseline
