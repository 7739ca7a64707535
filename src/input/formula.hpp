#pragma once

#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "viscobar/scene/scene.hpp"

namespace viscobar {

struct FormulaTree;
class Series;

/// Names that formulas may use for numbers, those of [parameters].
using Parameters = std::map<std::string, double, std::less<>>;

/// Fault of a formula, with its place.
class FormulaError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Why a number cannot have that name in formulas; empty when it can.
std::string parameter_name_problem(std::string_view name);

/// A function of x, of t, or of both, that the user wrote: a number, or a formula of + - * / ^, comparisons, && ||,
/// ?:, sin cos tan exp log (natural) sqrt abs min max, and pi. Or it is a series of measured values.
///
/// A function made from it shares what was read with the formula and all copies, and nothing changes that: it may be
/// called by several threads at the same time. One that tells breaks or detail remembers what it found: each thread
/// calls a copy of its own.
class Formula {
 public:
  explicit Formula(double constant);
  /// `variables` are those that the formula may use: "x", "t" or "xt", beside the parameters.
  /// @throws FormulaError
  Formula(std::string text, std::string_view variables, const Parameters& parameters = {});

  /// @param variable 'x' or 't'
  Formula(std::shared_ptr<const Series> series, char variable);

  const std::shared_ptr<const Series>& series() const { return series_; }  ///< null where it is none
  bool uses(char variable) const;
  bool is_constant() const { return !uses('x') && !uses('t'); }
  bool is_zero() const { return is_constant() && constant() == 0.0; }
  double constant() const;  ///< of a constant formula

  /// f(x) and g(t) where it is a product f(x) g(t), of both; absent: it is none.
  std::optional<std::pair<Formula, Formula>> factors() const;

  SpaceFunction of_x() const;
  TimeFunction of_t() const;
  SpaceTimeFunction of_x_t() const;
  /// The first or second derivative of a formula in t, itself for 0; of its derivative with respect to a parameter,
  /// where `by` names one.
  TimeFunction derivative_of_t(int order, std::string_view by = "") const;

  /// Where it is not a smooth function of t, for all x at once, and what depends on x, too (see FormulaSwitches); empty
  /// functions where there is nothing of the kind.
  NextBreak breaks() const;
  /// The same, and the pulses of t for x in [0, length], see FormulaDetail: no step may pass them by.
  NextBreak breaks_and_pulses(double length) const;
  NextBreakAt breaks_at() const;
  /// Where it is not a smooth function of x, at a time; an empty function where there is nothing of the kind.
  NextBreakAt breaks_in_x_at() const;
  /// Its detail in x in [0, length] at a time, see FormulaDetail; an empty function where it does not use x.
  NextBreakAt detail_in_x_at(double length) const;
  /// The breaks in x of a formula in x alone, and its detail in [0, length]; empty functions where it does not use x.
  Places places(double length) const;

  /// Its derivative with respect to "x" or to a parameter; an empty function where it does not depend on that.
  SpaceTimeFunction derivative(std::string_view by) const;
  /// The same of a function of x in [0, length], where it jumps the mean of its sides: a kink of the function that
  /// moves with the parameter has it, and a node may lie on the kink.
  SpaceTimeFunction mean_derivative(std::string_view by, double length) const;
  /// True if a condition in it depends on "x" or that parameter: then a jump moves.
  bool moves_jump(std::string_view by) const;

 private:
  explicit Formula(std::shared_ptr<const FormulaTree> tree) : tree_(std::move(tree)) {}
  NextBreak breaks_of_series(bool kinks) const;

  std::shared_ptr<const FormulaTree> tree_;  // null where it is a series
  std::shared_ptr<const Series> series_;
  char variable_ = 't';  // of that
};

}  // namespace viscobar
