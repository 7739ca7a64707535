#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "input/formula_tree.hpp"

namespace viscobar {

/// A number and its derivative with respect to a parameter.
struct Dual {
  double value = 0.0, slope = 0.0;
};

/// f, f' and f''.
template <class Number>
using TaylorOf = std::array<Number, 3>;
using Taylor = TaylorOf<double>;

/// A formula with its first two derivatives with respect to one name, by the rules of calculus on its tree: they have
/// the digits that a value has. At a switch (see FormulaSwitches) they are those of the side that the formula takes
/// there. In Duals each has its derivative with respect to a parameter.
template <class Number>
class TaylorFormula {
 public:
  /// `by` is "x", "t" or the name of a parameter; `slope_by`, of Duals, that of the other one.
  TaylorFormula(FormulaTree tree, std::string_view by, std::string_view slope_by = "");

  bool is_zero() const { return depends_.empty() || !depends_.back(); }  ///< f' is zero everywhere
  bool moves_jump() const { return moves_jump_; }                        ///< a condition depends on `by`
  TaylorOf<Number> operator()(double x, double t);

 private:
  FormulaTree tree_;
  std::vector<bool> depends_;  // of each node: its value changes smoothly with `by`
  std::vector<bool> has_slope_;
  std::vector<TaylorOf<Number>> of_nodes_;
  bool moves_jump_ = false;
};

using FormulaTaylor = TaylorFormula<double>;

}  // namespace viscobar
