#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "input/formula_tree.hpp"

namespace viscobar {

/// Where a formula of x and t is not a smooth function of t. It switches where the argument g of one of its parts
/// changes sign:
///
///     a < b, a <= b, a > b, a >= b, a == b, a != b, min(a, b), max(a, b)    g = a - b
///     abs(a)                                                                g = a
///
/// All else that a formula knows is smooth wherever it is finite. What lies in a branch of ?: counts only where that
/// branch is taken.
///
/// Sign changes are isolated by interval arithmetic on g and its derivative: an interval of time is given up when g
/// provably keeps its sign on it, and is halved until g is monotone there, where the signs at its ends tell all. So no
/// pulse is too short to be seen. (A g that touches zero may count, too.) Only a g that interval arithmetic cannot tell
/// from zero, such as sin(t) - sin(t), uses up the effort of a search; then what changes sign twice within a 1024th of
/// the time searched may be missed.
class FormulaSwitches {
 public:
  /// Those whose g uses t: with x as well, or without.
  FormulaSwitches(FormulaTree tree, bool with_x);

  bool empty() const { return switches_.empty(); }

  /// The first sign change in (after, until), to the number next to it; absent: none.
  std::optional<double> first(double x, double after, double until);

 private:
  bool excluded(int branch) const;
  std::optional<double> first_within(double begin, double end);
  std::optional<double> flip(std::size_t argument, double begin, double end);
  double argument_at(std::size_t argument, double t);

  FormulaTree tree_;
  std::vector<std::size_t> switches_;  // nodes: the g
  std::vector<std::size_t> open_;      // those that may change sign
  std::vector<Jet> jets_;              // of all nodes
  double x_ = 0.0, coarse_ = 0.0;
  int effort_ = 0;
};

}  // namespace viscobar
