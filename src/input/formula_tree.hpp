#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "input/dual.hpp"
#include "input/formula.hpp"
#include "input/row.hpp"

namespace viscobar {

/// A formula as operations in the order in which they can be done, of x, t, numbers, and earlier ones.
struct FormulaTree {
  // clang-format off
  enum class Operation : unsigned char {
    then, otherwise,  // of condition ? a : b, before a and before b: where values are computed, one of them is passed by
    negate, add, subtract, multiply, divide, power,
    less, at_most, greater, at_least, equal, unequal,
    both, either, choose,
    sin, cos, tan, exp, log, sqrt, abs, min, max
  };
  // clang-format on
  static constexpr int x = -1, t = -2, first_number = -3;  ///< operands that are no nodes; further numbers are below
  struct Node {
    Operation operation;
    std::array<int, 3> of{};     ///< operands; the second of `then` is its `otherwise`, of that its `choose`
    unsigned char operands = 0;  ///< how many there are
    bool uses_x = false, uses_t = false;
    int branch = -1;  ///< in which it lies
  };
  struct Number {
    double value = 0.0;
    int parameter = -1;  ///< which of `parameters` it is
  };
  /// A side of a ?:, taken where the condition's truth is `when`.
  struct Branch {
    int condition = 0, outer = -1;
    bool when = true;
  };

  std::vector<Node> nodes;
  std::vector<Number> numbers;
  std::vector<Branch> branches;
  std::vector<std::string> parameters;
  int root = 0;  ///< the formula

  const Number& number(int operand) const { return numbers[static_cast<std::size_t>(first_number - operand)]; }
  bool uses_x(int of) const { return of < 0 ? of == x : nodes[static_cast<std::size_t>(of)].uses_x; }
  bool uses_t(int of) const { return of < 0 ? of == t : nodes[static_cast<std::size_t>(of)].uses_t; }

  /// How many numbers an evaluation has, and where that of the first node is among them.
  std::size_t size() const { return nodes.size() + numbers.size() + 2; }
  template <class N>
  N* of_nodes(N* all) const {
    return all + numbers.size() + 2;
  }

  /// Numbers of x, t, those that `number` makes of the numbers, and of all nodes into `out`, that of the first node,
  /// with the others before. `done` may narrow one before those it is a part of are computed. In bounds of intervals,
  /// and in rows, both branches count.
  template <class N, class OfNumber, class Done>
  void evaluate(const N& at_x, const N& at_t, N* out, OfNumber&& number, Done&& done) const;

  template <class N, class OfNumber>
  N at(N at_x, N at_t, OfNumber&& number) const {
    std::array<N, 256> few;
    std::vector<N> many;
    if (size() > few.size()) many.resize(size());
    N* const out = of_nodes(many.empty() ? few.data() : many.data());
    evaluate(at_x, at_t, out, number, [](std::size_t, N&) {});
    return out[root];
  }
  double operator()(double at_x, double at_t) const {
    return at(at_x, at_t, [](const Number& number) { return number.value; });
  }
  void row(std::span<const double> at_x, double at_t, std::span<double> f) const {
    for (std::size_t done = 0; done < at_x.size(); done += Row::count) {
      const std::size_t some = std::min(Row::count, at_x.size() - done);
      Row some_x(at_x[done]);
      some_x.same = false;
      std::ranges::fill(std::ranges::copy(at_x.subspan(done, some), some_x.values.begin()).out, some_x.values.end(),
                        at_x[done]);
      const Row of = at(some_x, Row(at_t), [](const Number& number) { return Row(number.value); });
      for (std::size_t i = 0; i < some; ++i) f[done + i] = of.values[of.same ? 0 : i];
    }
  }
  static Jet bound(const Number& number) { return {hull({number.value, number.value}), {}}; }
};

inline bool is_condition(FormulaTree::Operation operation) {
  return operation >= FormulaTree::Operation::less && operation <= FormulaTree::Operation::either;
}

template <class N, class OfNumber, class Done>
void FormulaTree::evaluate(const N& at_x, const N& at_t, N* out, OfNumber&& number, Done&& done) const {
  using std::abs, std::min, std::max;
  constexpr bool of_values = !std::is_same_v<N, Jet> && !std::is_same_v<N, Row>;
  out[x] = at_x;
  out[t] = at_t;
  for (std::size_t k = 0; k < numbers.size(); ++k) out[first_number - static_cast<int>(k)] = number(numbers[k]);
  const Node* const all = nodes.data();
  const std::size_t count = nodes.size();
  for (std::size_t i = 0; i < count; ++i) {
    const auto& of = all[i].of;
    const N &a = out[of[0]], &b = out[of[1]];
    switch (all[i].operation) {
      case Operation::then:
        if constexpr (of_values)
          if (plain(a) == 0.0) i = static_cast<std::size_t>(of[1]);
        continue;
      case Operation::otherwise:
        if constexpr (of_values) i = static_cast<std::size_t>(of[1]) - 1;
        continue;
      case Operation::negate: out[i] = -a; break;
      case Operation::add: out[i] = a + b; break;
      case Operation::subtract: out[i] = a - b; break;
      case Operation::multiply: out[i] = a * b; break;
      case Operation::divide: out[i] = a / b; break;
      case Operation::power: out[i] = power(a, b); break;
      case Operation::less: out[i] = compared(std::less(), a, b); break;
      case Operation::at_most: out[i] = compared(std::less_equal(), a, b); break;
      case Operation::greater: out[i] = compared(std::greater(), a, b); break;
      case Operation::at_least: out[i] = compared(std::greater_equal(), a, b); break;
      case Operation::equal: out[i] = compared(std::equal_to(), a, b); break;
      case Operation::unequal: out[i] = compared(std::not_equal_to(), a, b); break;
      case Operation::both: out[i] = joined(std::logical_and(), a, b); break;
      case Operation::either: out[i] = joined(std::logical_or(), a, b); break;
      case Operation::choose: out[i] = chosen(a, b, out[of[2]]); break;
      case Operation::sin: out[i] = sin(a); break;
      case Operation::cos: out[i] = cos(a); break;
      case Operation::tan: out[i] = tan(a); break;
      case Operation::exp: out[i] = exp(a); break;
      case Operation::log: out[i] = log(a); break;
      case Operation::sqrt: out[i] = sqrt(a); break;
      case Operation::abs: out[i] = abs(a); break;
      case Operation::min: out[i] = min(a, b); break;
      case Operation::max: out[i] = max(a, b); break;
    }
    done(i, out[i]);
  }
}

/// @throws FormulaError if it is none of those variables, "x", "t" or "xt", and of those parameters
FormulaTree parse_formula(std::string_view text, const Parameters& parameters = {}, std::string_view variables = "xt");

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
  /// Those of s = t whose g uses t and not x, or both, or those of s = x.
  enum class Of { of_all_x, at_x, along_x };
  FormulaSwitches(std::shared_ptr<const FormulaTree> tree, Of of);

  bool empty() const { return switches_.empty(); }

  /// The first sign change of s in (after, until), to the number next to it; absent: none. `other` is what s is not.
  std::optional<double> first(double other, double after, double until) const;

 private:
  class Search;
  std::shared_ptr<const FormulaTree> tree_;
  std::vector<int> switches_;  // nodes
  bool along_x_;
};

/// Where a formula has stretches of s, x or t, on which it is far from linear, though smooth: between the
/// places of a stretch and its neighbours it differs from a line by no more than a 50th of its largest value, by
/// intervals of its value and its slope, and no less than a 128th of the interval searched is such a stretch. So no
/// pulse is too short to be seen.
class FormulaDetail {
 public:
  /// In t only pulses count, which fill less than half of the interval, and beside what does not rest for half of it
  /// only those of a 1024th: what goes on all the time no step misses. Beside pulses those are looked for that are
  /// smaller. `other` is what the other variable is. Where breaks travel, they are at some x all the time, and some x
  /// of `other` are looked at.
  FormulaDetail(std::shared_ptr<const FormulaTree> tree, bool along_x, Interval other);

  /// The first such place in (after, until), of those between 0 and until; absent: none.
  std::optional<double> operator()(double after, double until);

 private:
  using Places = std::shared_ptr<const std::vector<double>>;
  void bound(const Jet& s);
  Places find();
  struct Stretch {
    double begin, end;
    std::vector<double> places{};
  };
  using Stretches = std::vector<Stretch>;
  static Stretches without(const Stretches& all, const Stretches& some);
  double largest(const Stretches& rest);
  bool is_flank(const Stretch& one, const Stretches& rest);
  void search(const Stretches& rest);
  void take_shorter_than(double share);
  Jet over(const Jet& s, Interval other);
  void divide(double begin, double end, std::size_t first, std::size_t count);

  std::shared_ptr<const FormulaTree> tree_;
  FormulaSwitches switches_, travelling_;
  std::vector<Jet> jets_, middle_;
  Places places_;
  // Found by a search, of lines each; where something goes on that always changes about as fast it is steady.
  struct Part {
    double begin, end;
    bool steady;
  };
  std::vector<Part> parts_;
  Stretches found_;  // of them
  bool along_x_;
  const Interval whole_;  // of the other variable
  // Values of it: those of the whole search, and behind them what each halving has left; those to be looked at.
  std::vector<Interval> others_, pending_;
  Jet other_;
  double until_ = 0.0, rounding_ = 0.0, allowed_ = 0.0, covered_ = 0.0, quiet_ = 0.0;
  std::size_t effort_ = 0;
};

}  // namespace viscobar
