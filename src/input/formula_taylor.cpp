#include <cmath>
#include <type_traits>
#include <utility>

#include "input/formula_tree.hpp"

namespace viscobar {

namespace {

using Operation = FormulaTree::Operation;

double plain_value(double a) { return a; }
double plain_value(const Dual& a) { return a.value; }
bool is_zero(double a) { return a == 0.0; }
bool is_zero(const Dual& a) { return a.value == 0.0 && a.slope == 0.0; }

Dual operator-(const Dual& a) { return {-a.value, -a.slope}; }
Dual operator+(const Dual& a, const Dual& b) { return {a.value + b.value, a.slope + b.slope}; }
Dual operator-(const Dual& a, const Dual& b) { return {a.value - b.value, a.slope - b.slope}; }
Dual operator*(const Dual& a, const Dual& b) { return {a.value * b.value, a.slope * b.value + a.value * b.slope}; }
Dual operator*(double a, const Dual& b) { return {a * b.value, a * b.slope}; }
Dual operator/(const Dual& a, const Dual& b) {
  const double value = a.value / b.value;
  return {value, (a.slope - value * b.slope) / b.value};
}
Dual operator/(double a, const Dual& b) { return Dual{a} / b; }

// g(a) of slope g'(a), which may be infinite where nothing is moved.
Dual of(const Dual& a, double g, double slope) { return {g, a.slope == 0.0 ? 0.0 : slope * a.slope}; }
Dual sin(const Dual& a) { return of(a, std::sin(a.value), std::cos(a.value)); }
Dual cos(const Dual& a) { return of(a, std::cos(a.value), -std::sin(a.value)); }
Dual tan(const Dual& a) { return of(a, std::tan(a.value), 1.0 + std::tan(a.value) * std::tan(a.value)); }
Dual exp(const Dual& a) { return of(a, std::exp(a.value), std::exp(a.value)); }
Dual log(const Dual& a) { return of(a, std::log(a.value), 1.0 / a.value); }
Dual sqrt(const Dual& a) { return of(a, std::sqrt(a.value), 0.5 / std::sqrt(a.value)); }
Dual pow(const Dual& a, const Dual& b) {
  const double value = std::pow(a.value, b.value);
  Dual result = of(a, value, b.value == 0.0 ? 0.0 : b.value * std::pow(a.value, b.value - 1.0));
  if (b.slope != 0.0 && value != 0.0) result.slope += value * std::log(a.value) * b.slope;
  return result;
}
using std::cos, std::exp, std::log, std::pow, std::sin, std::sqrt, std::tan;

// g(f), of g and its derivatives at f: (g, g' f', g'' f'^2 + g' f''). What does not change makes no derivative, even
// where that of g is infinite.
template <class N>
TaylorOf<N> chain(const TaylorOf<N>& f, N g, N slope, N bend) {
  const auto product = [](const N& a, const N& b) { return is_zero(b) ? N{} : a * b; };
  return {g, product(slope, f[1]), product(bend, f[1] * f[1]) + product(slope, f[2])};
}

template <class N>
TaylorOf<N> sum(const TaylorOf<N>& a, double factor, const TaylorOf<N>& b) {
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}

template <class N>
TaylorOf<N> product(const TaylorOf<N>& a, const TaylorOf<N>& b) {
  return {a[0] * b[0], a[1] * b[0] + a[0] * b[1], a[2] * b[0] + 2.0 * a[1] * b[1] + a[0] * b[2]};
}

template <class N>
TaylorOf<N> quotient(const TaylorOf<N>& a, const TaylorOf<N>& b) {
  const N value = a[0] / b[0], slope = (a[1] - value * b[1]) / b[0];
  return {value, slope, (a[2] - 2.0 * slope * b[1] - value * b[2]) / b[0]};
}

template <class N>
TaylorOf<N> logarithm(const TaylorOf<N>& a) {
  return chain<N>(a, log(a[0]), 1.0 / a[0], -1.0 / (a[0] * a[0]));
}

template <class N>
TaylorOf<N> exponential(const TaylorOf<N>& a) {
  const N value = exp(a[0]);
  return chain<N>(a, value, value, value);
}

template <class N>
TaylorOf<N> power(const TaylorOf<N>& a, const TaylorOf<N>& b) {
  const N n = b[0], one{1.0}, two{2.0}, value = pow(a[0], n);
  const N slope = is_zero(n) ? N{} : n * pow(a[0], n - one);
  const N bend = is_zero(n) || is_zero(n - one) ? N{} : n * (n - one) * pow(a[0], n - two);
  const TaylorOf<N> of_base = chain<N>(a, value, slope, bend);
  if (is_zero(b[1]) && is_zero(b[2])) return of_base;
  if (is_zero(value)) return {value, of_base[1], N{}};  // where the logarithm has no end
  const TaylorOf<N> whole = exponential(product(b, logarithm(a)));
  return {value, of_base[1] + value * log(a[0]) * b[1], whole[2]};
}

template <class N>
TaylorOf<N> computed(Operation operation, const TaylorOf<N>& a, const TaylorOf<N>& b, const TaylorOf<N>& c) {
  const double left = plain_value(a[0]), right = plain_value(b[0]);
  const auto truth = [](bool value) { return TaylorOf<N>{N{value ? 1.0 : 0.0}, N{}, N{}}; };
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
    case Operation::less: return truth(left < right);
    case Operation::at_most: return truth(left <= right);
    case Operation::greater: return truth(left > right);
    case Operation::at_least: return truth(left >= right);
    case Operation::equal: return truth(left == right);
    case Operation::unequal: return truth(left != right);
    case Operation::both: return truth(left != 0.0 && right != 0.0);
    case Operation::either: return truth(left != 0.0 || right != 0.0);
    case Operation::choose: return left != 0.0 ? b : c;
    case Operation::sin: return chain<N>(a, sin(a[0]), cos(a[0]), -sin(a[0]));
    case Operation::cos: return chain<N>(a, cos(a[0]), -sin(a[0]), -cos(a[0]));
    case Operation::tan: {
      const N tangent = tan(a[0]), slope = N{1.0} + tangent * tangent;
      return chain<N>(a, tangent, slope, 2.0 * tangent * slope);
    }
    case Operation::exp: return exponential(a);
    case Operation::log: return logarithm(a);
    case Operation::sqrt: {
      const N root = sqrt(a[0]);
      return chain<N>(a, root, 0.5 / root, -0.25 / (root * a[0]));
    }
    case Operation::abs: return left < 0.0 ? TaylorOf<N>{-a[0], -a[1], -a[2]} : a;
    case Operation::min: return right < left ? b : a;
    case Operation::max: return right > left ? b : a;
  }
  return {};
}

bool is_condition(Operation operation) { return operation >= Operation::less && operation <= Operation::either; }

}  // namespace

template <class N>
TaylorFormula<N>::TaylorFormula(FormulaTree tree, std::string_view by, std::string_view slope_by)
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
    has_slope_.push_back(node.parameter >= 0 && tree_.parameters[static_cast<std::size_t>(node.parameter)] == slope_by);
  }
}

template <class N>
TaylorOf<N> TaylorFormula<N>::operator()(double x, double t) {
  for (std::size_t i = 0; i < tree_.nodes.size(); ++i) {
    const FormulaTree::Node& node = tree_.nodes[i];
    const auto operand = [&](int index) {
      return index < 0 ? TaylorOf<N>{} : of_nodes_[static_cast<std::size_t>(index)];
    };
    if (node.operation > Operation::t) {
      of_nodes_[i] = computed<N>(node.operation, operand(node.a), operand(node.b), operand(node.c));
      continue;
    }
    const double value = node.operation == Operation::x ? x : node.operation == Operation::t ? t : node.number;
    of_nodes_[i] = {N{value}, N{depends_[i] ? 1.0 : 0.0}, N{}};
    if constexpr (std::is_same_v<N, Dual>) of_nodes_[i][0].slope = has_slope_[i] ? 1.0 : 0.0;
  }
  return of_nodes_.back();
}

template class TaylorFormula<double>;
template class TaylorFormula<Dual>;

}  // namespace viscobar
