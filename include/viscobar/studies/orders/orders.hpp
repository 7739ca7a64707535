#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "viscobar/case/recording.hpp"
#include "viscobar/studies/exact/exact_solutions.hpp"
#include "viscobar/studies/orders/observed_order.hpp"

namespace viscobar {

/// The quantity that is refined: h, the step dt of a scheme, or both in proportion.
enum class Refine { mesh, step, both };

/// The case and `levels` - 1 refinements of it by factors of two. Output times stay, so that errors are taken at the
/// same times. @throws std::invalid_argument when the step is to be refined and the case has none
std::vector<Case> refinements(const Case& coarsest, Refine what, std::size_t levels);

/// Errors of a scheme along a refinement, and the powers p of C x^p that they follow, x = h or dt.
struct OrderStudy {
  /// One level of the refinement.
  struct Row {
    std::size_t elements = 0;    ///< J
    std::optional<double> step;  ///< dt; absent for methods without one
    exact::Error error;          ///< to the exact solution
  };
  std::vector<Row> rows;  ///< from coarse to fine
  /// Over the largest range that ends with the finest level and settles to Sequence::by_few: three levels at least.
  /// Absent: not settled, or an error is 0.
  std::optional<SequenceOrder> displacement_l2;
  std::optional<SequenceOrder> velocity_l2;  ///< absent as above
  std::optional<SequenceOrder> end_trace;    ///< absent as above
  std::optional<SequenceOrder> reaction_l1;  ///< absent as above
  Refine what = Refine::mesh;                ///< else dt is what errors are powers of

  /// Those of a quantity over the levels.
  Sequence errors(double exact::Error::*quantity) const;
};

/// Runs the solver on each case, on all cores (or on `threads`), against the exact solution of their scene.
/// @throws what the solver throws; std::invalid_argument when a recording does not fit its case
OrderStudy order_study(const Solver& solver, const exact::Solution& solution, std::span<const Case> cases, Refine what,
                       std::size_t threads = 0);

/// The same where no solution is known: each case against the next finer one, on one mesh (Refine::step). Since
/// C dt^p - C (dt/2)^p falls with the same power, the orders are those of the error; there is a row less than cases,
/// reaction errors are not taken.
OrderStudy self_study(const Solver& solver, std::span<const Case> cases, std::size_t threads = 0);

}  // namespace viscobar
