#include "input/formula_taylor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace viscobar {

namespace {

using Operation = FormulaTree::Operation;

// g(f), of g and its derivatives at f: (g, g' f', g'' f'^2 + g' f''). What does not change makes no derivative, even
// where that of g is infinite.
Taylor chain(const Taylor& f, double g, double slope, double bend) {
  const auto product = [](double a, double b) { return b == 0.0 ? 0.0 : a * b; };
  return {g, product(slope, f[1]), product(bend, f[1] * f[1]) + product(slope, f[2])};
}

Taylor sum(const Taylor& a, double factor, const Taylor& b) {
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}

Taylor product(const Taylor& a, const Taylor& b) {
  return {a[0] * b[0], a[1] * b[0] + a[0] * b[1], a[2] * b[0] + 2.0 * a[1] * b[1] + a[0] * b[2]};
}

Taylor quotient(const Taylor& a, const Taylor& b) {
  const double value = a[0] / b[0], slope = (a[1] - value * b[1]) / b[0];
  return {value, slope, (a[2] - 2.0 * slope * b[1] - value * b[2]) / b[0]};
}

Taylor logarithm(const Taylor& a) { return chain(a, std::log(a[0]), 1.0 / a[0], -1.0 / (a[0] * a[0])); }

Taylor exponential(const Taylor& a) {
  const double value = std::exp(a[0]);
  return chain(a, value, value, value);
}

Taylor power(const Taylor& a, const Taylor& b) {
  const double n = b[0], value = std::pow(a[0], n);
  const double slope = n == 0.0 ? 0.0 : n * std::pow(a[0], n - 1.0);
  const double bend = n == 0.0 || n == 1.0 ? 0.0 : n * (n - 1.0) * std::pow(a[0], n - 2.0);
  const Taylor of_base = chain(a, value, slope, bend);
  if (b[1] == 0.0 && b[2] == 0.0) return of_base;
  if (value == 0.0) return {value, of_base[1], 0.0};  // where the logarithm has no end
  const Taylor whole = exponential(product(b, logarithm(a)));
  return {value, of_base[1] + value * std::log(a[0]) * b[1], whole[2]};
}

Taylor truth(bool value) { return {value ? 1.0 : 0.0, 0.0, 0.0}; }

Taylor computed(Operation operation, const Taylor& a, const Taylor& b, const Taylor& c) {
  switch (operation) {
    case Operation::number:
    case Operation::x:
    case Operation::t: break;  // have no operands
    case Operation::negate: return {-a[0], -a[1], -a[2]};
    case Operation::add: return sum(a, 1.0, b);
    case Operation::subtract: return sum(a, -1.0, b);
    case Operation::multiply: return product(a, b);
    case Operation::divide: return quotient(a, b);
    case Operation::power: return power(a, b);
    case Operation::less: return truth(a[0] < b[0]);
    case Operation::at_most: return truth(a[0] <= b[0]);
    case Operation::greater: return truth(a[0] > b[0]);
    case Operation::at_least: return truth(a[0] >= b[0]);
    case Operation::equal: return truth(a[0] == b[0]);
    case Operation::unequal: return truth(a[0] != b[0]);
    case Operation::both: return truth(a[0] != 0.0 && b[0] != 0.0);
    case Operation::either: return truth(a[0] != 0.0 || b[0] != 0.0);
    case Operation::choose: return a[0] != 0.0 ? b : c;
    case Operation::sin: return chain(a, std::sin(a[0]), std::cos(a[0]), -std::sin(a[0]));
    case Operation::cos: return chain(a, std::cos(a[0]), -std::sin(a[0]), -std::cos(a[0]));
    case Operation::tan: {
      const double tangent = std::tan(a[0]), slope = 1.0 + tangent * tangent;
      return chain(a, tangent, slope, 2.0 * tangent * slope);
    }
    case Operation::exp: return exponential(a);
    case Operation::log: return logarithm(a);
    case Operation::sqrt: {
      const double root = std::sqrt(a[0]);
      return chain(a, root, 0.5 / root, -0.25 / (root * a[0]));
    }
    case Operation::abs: return a[0] < 0.0 ? Taylor{-a[0], -a[1], -a[2]} : a;
    case Operation::min: return b[0] < a[0] ? b : a;
    case Operation::max: return b[0] > a[0] ? b : a;
  }
  return {};
}

bool is_condition(Operation operation) { return operation >= Operation::less && operation <= Operation::either; }

}  // namespace

FormulaTaylor::FormulaTaylor(FormulaTree tree, std::string_view by)
    : tree_(std::move(tree)), of_nodes_(tree_.nodes.size()) {
  for (const FormulaTree::Node& node : tree_.nodes) {
    bool depends = (by == "x" && node.operation == Operation::x) || (by == "t" && node.operation == Operation::t) ||
                   (node.parameter >= 0 && tree_.parameters[node.parameter] == by);
    for (const int operand : {node.a, node.b, node.c})
      if (operand >= 0) depends = depends || depends_[operand];
    moves_jump_ |= depends && is_condition(node.operation);
    // A number taken for a condition.
    moves_jump_ |= node.operation == Operation::choose && depends_[node.a];
    depends_.push_back(depends && !is_condition(node.operation));
  }
}

Taylor FormulaTaylor::operator()(double x, double t) {
  for (std::size_t i = 0; i < tree_.nodes.size(); ++i) {
    const FormulaTree::Node& node = tree_.nodes[i];
    const auto operand = [&](int index) { return index < 0 ? Taylor{} : of_nodes_[static_cast<std::size_t>(index)]; };
    const Taylor a = operand(node.a), b = operand(node.b);
    const bool leaf = node.operation <= Operation::t;
    const double value = node.operation == Operation::x ? x : node.operation == Operation::t ? t : node.number;
    of_nodes_[i] = leaf ? Taylor{value, depends_[i] ? 1.0 : 0.0, 0.0} : computed(node.operation, a, b, operand(node.c));
  }
  return of_nodes_.back();
}

}  // namespace viscobar
