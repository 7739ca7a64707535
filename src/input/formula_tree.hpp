#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "input/interval.hpp"

namespace viscobar {

/// Names that formulas may use for numbers, those of [parameters].
using Parameters = std::map<std::string, double, std::less<>>;

/// What a formula computes, in the order in which it can be: the last node is the formula.
struct FormulaTree {
  enum class Operation : unsigned char {
    number,
    x,
    t,
    negate,
    add,
    subtract,
    multiply,
    divide,
    power,
    less,
    at_most,
    greater,
    at_least,
    equal,
    unequal,
    both,
    either,
    choose,
    sin,
    cos,
    tan,
    exp,
    log,
    sqrt,
    abs,
    min,
    max
  };
  struct Node {
    Operation operation = Operation::number;
    int a = -1, b = -1, c = -1;  ///< operands, earlier nodes
    double number = 0.0;
    int branch = -1;  ///< in which it lies
    bool uses_x = false, uses_t = false;
    int parameter = -1;  ///< of a number: which of `parameters` it is
  };
  /// Of a ?:, taken where the condition's truth is `when`.
  struct Branch {
    int condition = -1, outer = -1;
    bool when = true;
  };

  std::vector<Node> nodes;
  std::vector<Branch> branches;
  std::vector<std::string> parameters;

  /// Bounds of every node over an interval of t; `out` has an entry for each.
  void bound(double x, Interval t, std::vector<Jet>& out) const;
};

/// Of a formula that Formula accepts. @throws FormulaError for any other
FormulaTree parse_formula(std::string_view text, const Parameters& parameters = {});

}  // namespace viscobar
