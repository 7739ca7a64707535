#include "input/formula.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "input/formula_tree.hpp"
#include "input/known.hpp"
#include "input/series.hpp"
#include "scene/message_text.hpp"

namespace viscobar {

namespace {

using Operation = FormulaTree::Operation;
using Tree = std::shared_ptr<const FormulaTree>;

// How a formula depends on "x", "t" or a parameter.
struct Dependence {
  bool smooth = false;    // other than by conditions alone
  bool by_jumps = false;  // a condition does, or a number taken for one
};

Dependence dependence(const FormulaTree& tree, std::string_view by) {
  bool by_jumps = false;
  std::vector<bool> nodes;
  const auto depends = [&](int on) {
    if (on >= 0) return static_cast<bool>(nodes[static_cast<std::size_t>(on)]);
    if (on > FormulaTree::first_number) return by == (on == FormulaTree::x ? "x" : "t");
    const int parameter = tree.number(on).parameter;
    return parameter >= 0 && tree.parameters[static_cast<std::size_t>(parameter)] == by;
  };
  for (const FormulaTree::Node& node : tree.nodes) {
    const bool moves = std::any_of(node.of.begin(), node.of.begin() + node.operands, depends);
    by_jumps |= moves && (is_condition(node.operation) || node.operation == Operation::then);
    nodes.push_back(moves && !is_condition(node.operation));
  }
  return {depends(tree.root), by_jumps};
}

// An operand with its derivatives by names, one for each level of duals.
template <class N>
N seeded(double value, const bool* moves) {
  if constexpr (std::is_same_v<N, double>)
    return value;
  else
    return N(seeded<typename N::Part>(value, moves + 1), typename N::Part(*moves ? 1.0 : 0.0));
}

double last_derivative(double value) { return value; }
template <class N>
double last_derivative(const Dual<N>& f) {
  return last_derivative(f.slope);
}

// The derivative with respect to one of the names after the other.
template <class N, std::size_t count>
SpaceTimeFunction derived(const Tree& tree, const std::array<std::string_view, count>& names) {
  std::array<bool, count> x{}, t{};
  std::array<int, count> parameter{};
  for (std::size_t k = 0; k < count; ++k) {
    x[k] = names[k] == "x";
    t[k] = names[k] == "t";
    const auto named = std::ranges::find(tree->parameters, names[k]);
    parameter[k] = static_cast<int>(named - tree->parameters.begin());
  }
  return [=](double at_x, double at_t) {
    return last_derivative(
        tree->at(seeded<N>(at_x, x.data()), seeded<N>(at_t, t.data()), [&](const FormulaTree::Number& number) {
          std::array<bool, count> moves{};
          for (std::size_t k = 0; k < count; ++k) moves[k] = number.parameter == parameter[k];
          return seeded<N>(number.value, moves.data());
        }));
  };
}

// A factor of a product, and the nodes it is made of, from the first to its own.
struct Factor {
  int first, root;
  bool divides;
};

// The nodes of an operand lie behind those of the one before it. Returns true if the product has a minus.
bool take_factors(const FormulaTree& tree, int first, int root, bool divides, std::vector<Factor>& all) {
  const FormulaTree::Node* const node = root >= 0 ? &tree.nodes[static_cast<std::size_t>(root)] : nullptr;
  const Operation operation = node ? node->operation : Operation::choose;
  if (operation == Operation::negate) return !take_factors(tree, first, node->of[0], divides, all);
  if (operation == Operation::multiply || operation == Operation::divide) {
    const int a = node->of[0];
    const bool minus = take_factors(tree, first, a, divides, all);
    const bool divided = divides != (operation == Operation::divide);
    return minus != take_factors(tree, a >= 0 ? a + 1 : first, node->of[1], divided, all);
  }
  all.push_back({first, root, divides});
  return false;
}

FormulaTree product_of(const FormulaTree& tree, const std::vector<Factor>& factors, double begin) {
  FormulaTree product;
  product.numbers = tree.numbers;
  product.parameters = tree.parameters;
  product.branches = tree.branches;
  product.root = FormulaTree::first_number - static_cast<int>(product.numbers.size());
  product.numbers.push_back({begin});
  for (const Factor& factor : factors) {
    const int first = factor.first, root = factor.root;
    const int shift = static_cast<int>(product.nodes.size()) - first;
    const auto moved = [&](int operand) { return operand >= first ? operand + shift : std::min(operand, 0); };
    for (int k = first; k <= root; ++k) {
      FormulaTree::Node node = tree.nodes[static_cast<std::size_t>(k)];
      std::ranges::transform(node.of, node.of.begin(), moved);
      if (node.branch >= 0) {
        const auto branch = static_cast<std::size_t>(node.branch);
        product.branches[branch].condition = moved(tree.branches[branch].condition);
      }
      product.nodes.push_back(node);
    }
    FormulaTree::Node node{factor.divides ? Operation::divide : Operation::multiply, {product.root, moved(root)}, 2};
    for (const int operand : {node.of[0], node.of[1]}) {
      node.uses_x |= product.uses_x(operand);
      node.uses_t |= product.uses_t(operand);
    }
    product.root = static_cast<int>(product.nodes.size());
    product.nodes.push_back(node);
  }
  return product;
}

using Breaks = FormulaSwitches::Of;
NextBreakAt told(const FormulaSwitches& breaks) {
  if (breaks.empty()) return {};
  return [breaks](double other, double after, double until) { return breaks.first(other, after, until); };
}

using First = Dual<double>;
using Second = Dual<First>;
using Third = Dual<Second>;

}  // namespace

Formula::Formula(double constant) {
  FormulaTree tree;
  tree.numbers.push_back({constant});
  tree.root = FormulaTree::first_number;
  tree_ = std::make_shared<FormulaTree>(tree);
}

Formula::Formula(std::string text, std::string_view variables, const Parameters& parameters) {
  // A scene asks for each of its formulas several times, and a sweep for those of thousands of scenes.
  static Known<std::tuple<std::string, std::string, Parameters>, Tree> trees;
  tree_ = trees({text, std::string(variables), parameters},
                [&] { return std::make_shared<FormulaTree>(parse_formula(text, parameters, variables)); });
  if (is_constant() && !std::isfinite(constant()))
    throw FormulaError(fmt::format("must be finite, is {}", printable(constant())));
}

Formula::Formula(std::shared_ptr<const Series> series, char variable)
    : series_(std::move(series)), variable_(variable) {}

NextBreak Formula::breaks_of_series(bool kinks) const {
  return [series = series_, which = kinks ? Series::Breaks::kinks : Series::Breaks::of_load](
             double after, double until) { return series->next_break(after, until, which); };
}

bool Formula::uses(char variable) const {
  if (series_) return variable == variable_;
  return variable == 'x' ? tree_->uses_x(tree_->root) : tree_->uses_t(tree_->root);
}
double Formula::constant() const { return (*tree_)(0.0, 0.0); }

SpaceFunction Formula::of_x() const {
  return [f = of_x_t()](double x) { return f(x, 0.0); };
}

TimeFunction Formula::of_t() const {
  return [f = of_x_t()](double t) { return f(0.0, t); };
}

SpaceTimeFunction Formula::of_x_t() const {
  if (series_)
    return [series = series_, of_x = variable_ == 'x'](double x, double t) { return (*series)(of_x ? x : t); };
  if (is_constant()) return [value = constant()](double, double) { return value; };
  return RowFunction{[tree = tree_](double x, double t) { return (*tree)(x, t); },
                     [tree = tree_](std::span<const double> x, double t, std::span<double> f) { tree->row(x, t, f); }};
}

std::optional<std::pair<Formula, Formula>> Formula::factors() const {
  if (series_ || !uses('x') || !uses('t')) return std::nullopt;
  std::vector<Factor> all, of_x, of_t;
  const bool minus = take_factors(*tree_, 0, tree_->root, false, all);
  for (const Factor& one : all) {
    if (tree_->uses_x(one.root) && tree_->uses_t(one.root)) return std::nullopt;
    (tree_->uses_t(one.root) ? of_t : of_x).push_back(one);
  }
  static Known<Tree, std::pair<Tree, Tree>> products;
  const auto [profile, history] = products(tree_, [&] {
    return std::pair<Tree, Tree>(std::make_shared<FormulaTree>(product_of(*tree_, of_x, minus ? -1.0 : 1.0)),
                                 std::make_shared<FormulaTree>(product_of(*tree_, of_t, 1.0)));
  });
  return std::pair(Formula(profile), Formula(history));
}

NextBreak Formula::breaks() const {
  if (series_) return breaks_of_series(true);
  const NextBreakAt found = told({tree_, Breaks::of_all_x});
  if (!found) return {};
  return [found](double after, double until) { return found(0.0, after, until); };
}
NextBreakAt Formula::breaks_at() const { return series_ ? NextBreakAt() : told({tree_, Breaks::at_x}); }
NextBreakAt Formula::breaks_in_x_at() const { return series_ ? NextBreakAt() : told({tree_, Breaks::along_x}); }

NextBreak Formula::breaks_and_pulses(double length) const {
  if (!uses('t')) return {};
  if (series_) return breaks_of_series(false);
  FormulaDetail pulses(tree_, false, {0.0, uses('x') ? length : 0.0});
  const NextBreak breaks = this->breaks();
  return breaks ? either_of(breaks, pulses) : pulses;
}

NextBreakAt Formula::detail_in_x_at(double length) const {
  if (!uses('x') || series_) return {};
  std::optional<FormulaDetail> at_time;
  return [=, tree = tree_, known = 0.0](double t, double after, double until) mutable {
    if (!at_time || t != known) at_time.emplace(tree, true, Interval{t, t});
    known = t;
    (*at_time)(0.0, length);
    return (*at_time)(after, until);
  };
}

Places Formula::places(double length) const {
  if (!uses('x')) return {};
  if (series_) return {breaks_of_series(true), breaks_of_series(false)};
  static Known<std::pair<Tree, double>, Places> all;
  return all({tree_, length}, [&]() -> Places {
    FormulaDetail detail(tree_, true, {0.0, 0.0});
    detail(0.0, length);  // found once, for all copies
    return {[breaks = FormulaSwitches(tree_, Breaks::along_x)](double after, double until) {
              return breaks.first(0.0, after, until);
            },
            detail};
  });
}

SpaceTimeFunction Formula::derivative(std::string_view by) const {
  if (series_ && by == std::string_view(&variable_, 1))
    return [series = series_, of_x = variable_ == 'x'](double x, double t) { return (*series)(of_x ? x : t, 1); };
  if (series_) return {};
  if (!dependence(*tree_, by).smooth) return {};
  return derived<First, 1>(tree_, {by});
}

SpaceTimeFunction Formula::mean_derivative(std::string_view by, double length) const {
  const SpaceTimeFunction slope = derivative(by);
  const NextBreak breaks = places(length).breaks;
  if (!slope || !breaks) return slope;
  return [slope, breaks, length](double x, double t) {
    const double apart = 1e-12 * length;
    if (!breaks(x - apart, x + apart)) return slope(x, t);
    const double below = x < apart ? x + apart : x - apart, above = x + apart > length ? below : x + apart;
    return 0.5 * (slope(below, t) + slope(above, t));
  };
}

TimeFunction Formula::derivative_of_t(int order, std::string_view by) const {
  if (series_)
    return [series = series_, order, none = !by.empty()](double t) { return none ? 0.0 : (*series)(t, order); };
  if (by.empty() && order == 0) return of_t();
  if (is_constant() && order > 0) return [](double) { return 0.0; };
  const SpaceTimeFunction f = by.empty()
                                  ? order == 1 ? derived<First, 1>(tree_, {"t"}) : derived<Second, 2>(tree_, {"t", "t"})
                              : order == 0 ? derived<First, 1>(tree_, {by})
                              : order == 1 ? derived<Second, 2>(tree_, {by, "t"})
                                           : derived<Third, 3>(tree_, {by, "t", "t"});
  return [f](double t) { return f(0.0, t); };
}

bool Formula::moves_jump(std::string_view by) const { return !series_ && dependence(*tree_, by).by_jumps; }

}  // namespace viscobar
