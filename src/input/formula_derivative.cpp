#include "input/formula_derivative.hpp"

#include <cmath>
#include <utility>

namespace viscobar {

namespace {

using Operation = FormulaTree::Operation;

bool is_condition(Operation operation) { return operation >= Operation::less && operation <= Operation::either; }

}  // namespace

FormulaDerivative::FormulaDerivative(FormulaTree tree, std::string_view by) : tree_(std::move(tree)) {
  for (const FormulaTree::Node& node : tree_.nodes) {
    bool depends =
        by == "x" ? node.operation == Operation::x : node.parameter >= 0 && tree_.parameters[node.parameter] == by;
    for (const int operand : {node.a, node.b, node.c})
      if (operand >= 0) depends = depends || depends_[operand];
    moves_jump_ |= depends && is_condition(node.operation);
    // A number taken for a condition.
    moves_jump_ |= node.operation == Operation::choose && depends_[node.a];
    depends_.push_back(depends && !is_condition(node.operation));
  }
  duals_.resize(tree_.nodes.size());
}

double FormulaDerivative::operator()(double x, double t) {
  for (std::size_t i = 0; i < tree_.nodes.size(); ++i) {
    const FormulaTree::Node& node = tree_.nodes[i];
    const auto operand = [&](int index) { return index < 0 ? Dual{} : duals_[static_cast<std::size_t>(index)]; };
    const Dual a = operand(node.a), b = operand(node.b);
    // A factor that may be infinite where nothing is moved.
    const auto moved = [](double slope, double by) { return by == 0.0 ? 0.0 : slope * by; };
    Dual& out = duals_[i];
    switch (node.operation) {
      case Operation::number: out = {node.number, depends_[i] ? 1.0 : 0.0}; break;
      case Operation::x: out = {x, depends_[i] ? 1.0 : 0.0}; break;
      case Operation::t: out = {t, 0.0}; break;
      case Operation::negate: out = {-a.value, -a.slope}; break;
      case Operation::add: out = {a.value + b.value, a.slope + b.slope}; break;
      case Operation::subtract: out = {a.value - b.value, a.slope - b.slope}; break;
      case Operation::multiply: out = {a.value * b.value, a.slope * b.value + a.value * b.slope}; break;
      case Operation::divide:
        out.value = a.value / b.value;
        out.slope = (a.slope - out.value * b.slope) / b.value;
        break;
      case Operation::power:
        out.value = std::pow(a.value, b.value);
        out.slope = moved(b.value * std::pow(a.value, b.value - 1.0), a.slope) +
                    (out.value == 0.0 ? 0.0 : moved(out.value * std::log(a.value), b.slope));
        break;
      case Operation::less: out = {a.value < b.value ? 1.0 : 0.0, 0.0}; break;
      case Operation::at_most: out = {a.value <= b.value ? 1.0 : 0.0, 0.0}; break;
      case Operation::greater: out = {a.value > b.value ? 1.0 : 0.0, 0.0}; break;
      case Operation::at_least: out = {a.value >= b.value ? 1.0 : 0.0, 0.0}; break;
      case Operation::equal: out = {a.value == b.value ? 1.0 : 0.0, 0.0}; break;
      case Operation::unequal: out = {a.value != b.value ? 1.0 : 0.0, 0.0}; break;
      case Operation::both: out = {a.value != 0.0 && b.value != 0.0 ? 1.0 : 0.0, 0.0}; break;
      case Operation::either: out = {a.value != 0.0 || b.value != 0.0 ? 1.0 : 0.0, 0.0}; break;
      case Operation::choose: out = a.value != 0.0 ? b : operand(node.c); break;
      case Operation::sin: out = {std::sin(a.value), moved(std::cos(a.value), a.slope)}; break;
      case Operation::cos: out = {std::cos(a.value), moved(-std::sin(a.value), a.slope)}; break;
      case Operation::tan:
        out.value = std::tan(a.value);
        out.slope = moved(1.0 + out.value * out.value, a.slope);
        break;
      case Operation::exp:
        out.value = std::exp(a.value);
        out.slope = moved(out.value, a.slope);
        break;
      case Operation::log: out = {std::log(a.value), moved(1.0 / a.value, a.slope)}; break;
      case Operation::sqrt:
        out.value = std::sqrt(a.value);
        out.slope = moved(0.5 / out.value, a.slope);
        break;
      case Operation::abs: out = {std::abs(a.value), a.value < 0.0 ? -a.slope : a.slope}; break;
      case Operation::min: out = b.value < a.value ? b : a; break;
      case Operation::max: out = a.value < b.value ? b : a; break;
    }
  }
  return duals_.back().slope;
}

}  // namespace viscobar
