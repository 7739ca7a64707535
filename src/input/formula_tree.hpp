#pragma once

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "input/interval.hpp"

namespace viscobar {

/// Names that formulas may use for numbers, those of [parameters].
using Parameters = std::map<std::string, double, std::less<>>;

/// What a formula computes, in the order in which it can be: the last node is the formula.
struct FormulaTree {
  // clang-format off
  enum class Operation : unsigned char {
    number, x, t,
    negate, add, subtract, multiply, divide, power,
    less, at_most, greater, at_least, equal, unequal,
    both, either, choose,
    sin, cos, tan, exp, log, sqrt, abs, min, max
  };
  // clang-format on
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

  /// Bounds of every node, from those of x and t; `out` has an entry for each. `tighten` may narrow that of a node
  /// before those it is a part of are bounded.
  void bound(const Jet& x, const Jet& t, std::vector<Jet>& out,
             const std::function<void(std::size_t node, Jet&)>& tighten = {}) const;
};

inline bool is_comparison(FormulaTree::Operation operation) {
  return operation >= FormulaTree::Operation::less && operation <= FormulaTree::Operation::unequal;
}

/// Of a formula that Formula accepts. @throws FormulaError for any other
FormulaTree parse_formula(std::string_view text, const Parameters& parameters = {});

/// Where a formula of x and t is not a smooth function of one of them, s, the other one given. It switches where the
/// argument g of one of its parts changes sign:
///
///     a < b, a <= b, a > b, a >= b, a == b, a != b, min(a, b), max(a, b)    g = a - b
///     abs(a)                                                                g = a
///
/// All else that a formula knows is smooth wherever it is finite. What lies in a branch of ?: counts only where that
/// branch is taken.
///
/// Sign changes are isolated by interval arithmetic on g and its derivative: an interval of s is given up when g
/// provably keeps its sign on it, and is halved until g is monotone there. So no pulse is too short to be seen. (A g
/// that touches zero may count, too.) Only a g that interval arithmetic cannot tell from zero, such as sin(t) - sin(t),
/// uses up the effort of a search; then what changes sign twice within a 1024th of the interval searched may be missed.
class FormulaSwitches {
 public:
  /// Those of s = t whose g uses t: with x as well, or without.
  FormulaSwitches(FormulaTree tree, bool with_x);
  /// Those of s = x.
  static FormulaSwitches along_x(FormulaTree tree);

  bool empty() const { return switches_.empty(); }

  /// The first sign change of s in (after, until), to the number next to it; absent: none. `other` is what s is not.
  std::optional<double> first(double other, double after, double until);

 private:
  template <class Counts>
  FormulaSwitches(FormulaTree tree, bool along_x, Counts&& counts);
  void bound(Interval s);
  bool excluded(int branch) const;
  std::optional<double> first_within(double begin, double end);
  std::optional<double> flip(std::size_t argument, double begin, double end);
  double argument_at(std::size_t argument, double s);

  FormulaTree tree_;
  std::vector<std::size_t> switches_;  // nodes: the g
  std::vector<std::size_t> open_;      // those that may change sign
  std::vector<Jet> jets_;              // of all nodes
  bool along_x_ = false;
  double other_ = 0.0, coarse_ = 0.0;
  int effort_ = 0;
};

/// Where a formula has stretches of s, x or t, on which it is far from linear, though smooth: between the
/// places of a stretch and its neighbours it differs from a line by no more than a 50th of its largest value, by
/// intervals of its value and its slope, and no less than a 128th of the interval searched is such a stretch. So no
/// pulse is too short to be seen.
class FormulaDetail {
 public:
  /// In t only pulses count, which fill less than half of the interval, and beside what does not rest for half of it
  /// only those of a 1024th: what goes on all the time no step misses. `other` is what the other variable is.
  FormulaDetail(FormulaTree tree, bool along_x, Interval other);

  /// The first such place in (after, until), of those between 0 and until; absent: none.
  std::optional<double> operator()(double after, double until);

 private:
  void bound(const Jet& s);
  void find();
  double largest();
  void search(double share);
  void divide(double begin, double end);

  FormulaTree tree_;
  FormulaSwitches switches_;
  std::vector<Jet> jets_, middle_;  // of all nodes
  std::vector<double> places_;
  bool along_x_;
  Jet other_;
  double until_ = 0.0, rounding_ = 0.0, allowed_ = 0.0, covered_ = 0.0, quiet_ = 0.0, coarse_ = 0.0;
  std::size_t effort_ = 0;
};

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
