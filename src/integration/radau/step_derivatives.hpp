#pragma once

#include <span>
#include <vector>

#include "dynamics/derivative/derivative.hpp"
#include "integration/layout.hpp"
#include "integration/radau/load_tail.hpp"
#include "integration/radau/shifted_systems.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar::radau {

/// The derivatives by parameters on a step of Formula. M', C' and K' being the derivatives of the matrices, they obey
/// the bar's equations under the force -M' a - C' w - K' u of its motion. That is linear in the motion, so it is in the
/// systems of the step what the derivatives of those are, X being the motion's and q = s':
///
///     (zeta M + h C + h^2 / zeta K) Y = h r - h^2 / zeta (K q + K' w) - (zeta M' + h C' + h^2 / zeta K') X + load,
///     r = M f' - K s - C q - K' u - C' w,
///
/// and no stage has to be looked at but for a load of s that depends on time. Each costs a solve with the factor of the
/// step. The impulses of the ends are integrals, by the same formula: I' = r has zeta X = h r.
class StepDerivatives {
 public:
  /// All outlive it.
  StepDerivatives(PenalisedSystem& system, const Layout& layout, std::span<Derivative* const> derivatives);

  /// Evaluates the state y at t, from which the next step begins; completes the velocities of massless nodes.
  void evaluate(ShiftedSystems& systems, double t, std::span<double> y);

  struct Step {
    double t, h, reached;  ///< where it begins, its length, and its last stage
  };
  /// A step whose motion has the parts `motion`, from the blocks of `begin` to those of `end`: what it is wrong by, as
  /// Formula::error() says, times the blocks of `weights`.
  double attempt(ShiftedSystems& systems, const Step& step, std::span<const double> begin,
                 std::span<const Complex> motion, std::span<const double> weights, std::span<double> end,
                 Statistics& statistics);

  /// The blocks at a part theta of the step.
  void blocks_at(double theta, std::span<const double> begin, std::span<double> y) const;

 private:
  struct Part {
    std::vector<double> force, stiff_rate, impulse_rates;  // where the step begins
    std::vector<Complex> x, impulses;
    LoadTail load_tail;
  };

  static void multiply(const BandedMatrix& inertia, std::span<const Complex> x, std::vector<Complex>& out);
  void impulse_rates(Derivative& derivative, const Moment& at, std::span<const double> s, std::vector<double>& rates);
  bool drive(std::size_t k, std::span<const Complex> motion);
  void gather_load(std::size_t k, const Step& step, std::span<const double> begin, bool driven);
  void add_elastic_impulses(std::size_t k, std::span<const double> begin, std::span<const Complex> motion);
  double move(std::size_t k, std::span<const double> begin, std::span<const double> weights,
              std::span<double> end) const;
  void impulses_at(std::size_t k, double theta, std::span<const double> before, std::span<double> block) const;

  PenalisedSystem& system_;
  const Layout& layout_;
  std::span<Derivative* const> derivatives_;
  std::vector<std::size_t> ends_;  // that have an impulse
  Moment begin_;                   // where the step begins
  double h_ = 0.0;                 // of the last step
  std::vector<Part> parts_;
  std::vector<double> force_, rates_;  // scratch
};

}  // namespace viscobar::radau
