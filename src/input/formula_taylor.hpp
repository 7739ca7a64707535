#pragma once

#include <array>
#include <vector>

#include "input/formula_tree.hpp"

namespace viscobar {

/// f(t), f'(t) and f''(t).
using Taylor = std::array<double, 3>;

/// A formula in t with its first two derivatives, by the rules of calculus on its tree: they have the digits that a
/// value has. At a switch (see FormulaSwitches) they are those of the side that the formula takes there.
class FormulaTaylor {
 public:
  explicit FormulaTaylor(FormulaTree tree);
  Taylor operator()(double t);

 private:
  FormulaTree tree_;
  std::vector<Taylor> of_nodes_;
};

}  // namespace viscobar
