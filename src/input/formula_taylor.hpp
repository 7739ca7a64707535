#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "input/formula_tree.hpp"

namespace viscobar {

/// f, f' and f''.
using Taylor = std::array<double, 3>;

/// A formula with its first two derivatives with respect to one name, by the rules of calculus on its tree: they have
/// the digits that a value has. At a switch (see FormulaSwitches) they are those of the side that the formula takes
/// there.
class FormulaTaylor {
 public:
  /// `by` is "x", "t" or the name of a parameter.
  FormulaTaylor(FormulaTree tree, std::string_view by);

  bool is_zero() const { return depends_.empty() || !depends_.back(); }  ///< f' is zero everywhere
  bool moves_jump() const { return moves_jump_; }                        ///< a condition depends on `by`
  Taylor operator()(double x, double t);

 private:
  FormulaTree tree_;
  std::vector<bool> depends_;  // of each node: its value changes smoothly with `by`
  std::vector<Taylor> of_nodes_;
  bool moves_jump_ = false;
};

}  // namespace viscobar
