#pragma once

#include <string_view>
#include <vector>

#include "input/formula_tree.hpp"

namespace viscobar {

/// The derivative of a formula with respect to x or to a parameter, by dual numbers: exact but for rounding. At a kink
/// of abs, min or max it is that of one side; a condition has none, see moves_jump().
class FormulaDerivative {
 public:
  /// `by` is "x" or the name of a parameter.
  FormulaDerivative(FormulaTree tree, std::string_view by);

  bool vanishes() const { return depends_.empty() || !depends_.back(); }  ///< it is zero everywhere
  bool moves_jump() const { return moves_jump_; }  ///< a condition depends on what it is taken with respect to
  double operator()(double x, double t);

 private:
  struct Dual {
    double value = 0.0, slope = 0.0;
  };
  FormulaTree tree_;
  std::vector<bool> depends_;  // of each node
  std::vector<Dual> duals_;
  bool moves_jump_ = false;
};

}  // namespace viscobar
