#include "input/formula_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>

#include "input/formula.hpp"
#include "input/input_text.hpp"

namespace viscobar {

namespace {

using Operation = FormulaTree::Operation;

struct Operator {
  std::string_view sign;
  Operation operation;
  int level = 0;  // of binary ones: those of a higher level bind tighter, those of one are taken from the left
};
constexpr Operator binary_operators[] = {
    {"||", Operation::either, 0},   {"&&", Operation::both, 1},    {"<=", Operation::at_most, 2},
    {">=", Operation::at_least, 2}, {"==", Operation::equal, 2},   {"!=", Operation::unequal, 2},
    {"<", Operation::less, 2},      {">", Operation::greater, 2},  {"+", Operation::add, 3},
    {"-", Operation::subtract, 3},  {"*", Operation::multiply, 4}, {"/", Operation::divide, 4},
};
constexpr int tightest = 4;

constexpr Operator function_operators[] = {{"sin", Operation::sin}, {"cos", Operation::cos}, {"tan", Operation::tan},
                                           {"exp", Operation::exp}, {"log", Operation::log}, {"sqrt", Operation::sqrt},
                                           {"abs", Operation::abs}, {"min", Operation::min}, {"max", Operation::max}};

class Parser {
 public:
  Parser(std::string_view text, const Parameters& parameters) : text_(text), parameters_(parameters) {}

  FormulaTree operator()() {
    const int root = choice();
    if (!rest().empty()) refuse();
    // Sub-expressions are computed before what holds them, so that the root is the last.
    if (root + 1 != static_cast<int>(tree_.nodes.size())) refuse();
    return std::move(tree_);
  }

 private:
  [[noreturn]] void refuse() const {
    throw FormulaError(fmt::format("the formula cannot be understood from character {} on", at_ + 1));
  }

  std::string_view rest() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos) ++at_;
    return std::string_view(text_).substr(at_);
  }
  bool take(std::string_view token) {
    if (!rest().starts_with(token)) return false;
    at_ += token.size();
    return true;
  }
  void require(std::string_view token) {
    if (!take(token)) refuse();
  }

  int add(FormulaTree::Node node) {
    node.uses_x = node.operation == Operation::x;
    node.uses_t = node.operation == Operation::t;
    node.branch = branch_;
    for (const int operand : {node.a, node.b, node.c}) {
      if (operand < 0) continue;
      node.uses_x |= tree_.nodes[operand].uses_x;
      node.uses_t |= tree_.nodes[operand].uses_t;
    }
    tree_.nodes.push_back(node);
    return static_cast<int>(tree_.nodes.size()) - 1;
  }

  int branch_of(int condition, bool when) {
    const int outer = branch_;
    tree_.branches.push_back({condition, outer, when});
    branch_ = static_cast<int>(tree_.branches.size()) - 1;
    const int value = choice();
    branch_ = outer;
    return value;
  }

  int choice() {
    const int condition = binary(0);
    if (!take("?")) return condition;
    const int then = branch_of(condition, true);
    require(":");
    const int otherwise = branch_of(condition, false);
    return add({Operation::choose, condition, then, otherwise});
  }

  int binary(int level) {
    if (level > tightest) return signed_power();
    int left = binary(level + 1);
    const auto follows = [&](const Operator& each) { return each.level == level && take(each.sign); };
    while (true) {
      const auto* found = std::ranges::find_if(binary_operators, follows);
      if (found == std::end(binary_operators)) return left;
      const int right = binary(level + 1);
      left = add({found->operation, left, right});
    }
  }

  int signed_power() {
    if (take("+")) return signed_power();
    if (take("-")) {
      const int operand = signed_power();
      return add({Operation::negate, operand});
    }
    const int base = primary();
    if (!take("^")) return base;
    const int exponent = signed_power();
    return add({Operation::power, base, exponent});
  }

  int primary() {
    if (take("(")) {
      const int inside = choice();
      require(")");
      return inside;
    }
    if (const std::string_view here = rest(); !here.empty() && (is_digit(here.front()) || here.front() == '.')) {
      char* end = nullptr;
      const double number = std::strtod(text_.c_str() + at_, &end);
      if (end == text_.c_str() + at_) refuse();
      at_ = static_cast<std::size_t>(end - text_.c_str());
      return add({Operation::number, -1, -1, -1, number});
    }
    if (const auto named = parameters_.find(name()); named != parameters_.end()) return parameter(*named);
    for (const Operator& function : function_operators)
      if (take(function.sign)) return call(function.operation);
    if (take("pi")) return add({Operation::number, -1, -1, -1, std::numbers::pi});
    if (take("x")) return add({Operation::x});
    if (take("t")) return add({Operation::t});
    refuse();
  }

  std::string_view name() {
    const std::string_view here = rest();
    const auto part = [](char c) { return is_letter(c) || is_digit(c) || c == '_'; };
    return here.substr(0, static_cast<std::size_t>(std::ranges::find_if_not(here, part) - here.begin()));
  }

  int parameter(const Parameters::value_type& named) {
    take(named.first);
    const auto known = std::ranges::find(tree_.parameters, named.first);
    FormulaTree::Node node{Operation::number, -1, -1, -1, named.second};
    node.parameter = static_cast<int>(known - tree_.parameters.begin());
    if (known == tree_.parameters.end()) tree_.parameters.push_back(named.first);
    return add(node);
  }

  int call(Operation operation) {
    require("(");
    int value = choice();
    if (operation == Operation::min || operation == Operation::max) {
      while (take(",")) {
        const int next = choice();
        value = add({operation, value, next});
      }
    } else {
      value = add({operation, value});
    }
    require(")");
    return value;
  }

  std::string text_;
  const Parameters& parameters_;
  std::size_t at_ = 0;
  int branch_ = -1;
  FormulaTree tree_;
};

std::optional<bool> negated(std::optional<bool> a) { return a ? std::optional(!*a) : std::nullopt; }

// Whether d, a difference, compares with 0 like that; nothing where some of its values do and some do not.
std::optional<bool> compared(Operation operation, Interval d) {
  switch (operation) {
    case Operation::less:
      return d.high < 0.0 ? std::optional(true) : d.low >= 0.0 ? std::optional(false) : std::nullopt;
    case Operation::at_most:
      return d.high <= 0.0 ? std::optional(true) : d.low > 0.0 ? std::optional(false) : std::nullopt;
    case Operation::greater: return compared(Operation::less, -d);
    case Operation::at_least: return compared(Operation::at_most, -d);
    case Operation::unequal: return truth(d);
    default: return negated(truth(d));
  }
}

bool rests(const Jet& a) { return a.slope.is(0.0); }

// A condition that s does not move does not jump, though it may be true for some values of the other variable alone.
Jet of_truth(std::optional<bool> value, bool rests) {
  if (!value) return {{0.0, 1.0}, rests ? Interval{} : any_number};
  return *value ? Jet{{1.0, 1.0}, {}} : Jet{};
}

std::optional<bool> both(std::optional<bool> a, std::optional<bool> b) {
  if (a == false || b == false) return false;
  return a == true && b == true ? std::optional(true) : std::nullopt;
}

Jet chosen(const Jet& condition, const Jet& then, const Jet& otherwise) {
  if (const auto known = truth(condition.value)) return *known ? then : otherwise;
  return {hull(then.value, otherwise.value), rests(condition) ? hull(then.slope, otherwise.slope) : any_number};
}

}  // namespace

void FormulaTree::bound(const Jet& x, const Jet& t, std::vector<Jet>& out,
                        const std::function<void(std::size_t, Jet&)>& tighten) const {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Node& node = nodes[i];
    const auto operand = [&](int index) { return index < 0 ? Jet{} : out[static_cast<std::size_t>(index)]; };
    const Jet a = operand(node.a), b = operand(node.b);
    switch (node.operation) {
      case Operation::number: out[i] = {{node.number, node.number}, {}}; break;
      case Operation::x: out[i] = x; break;
      case Operation::t: out[i] = t; break;
      case Operation::negate: out[i] = -a; break;
      case Operation::add: out[i] = a + b; break;
      case Operation::subtract: out[i] = a - b; break;
      case Operation::multiply: out[i] = a * b; break;
      case Operation::divide: out[i] = a / b; break;
      case Operation::power: out[i] = viscobar::power(a, b); break;
      case Operation::both:
        out[i] = of_truth(viscobar::both(truth(a.value), truth(b.value)), rests(a) && rests(b));
        break;
      case Operation::either:
        out[i] =
            of_truth(negated(viscobar::both(negated(truth(a.value)), negated(truth(b.value)))), rests(a) && rests(b));
        break;
      case Operation::choose: out[i] = chosen(a, b, operand(node.c)); break;
      case Operation::sin: out[i] = viscobar::sin(a); break;
      case Operation::cos: out[i] = viscobar::cos(a); break;
      case Operation::tan: out[i] = viscobar::tan(a); break;
      case Operation::exp: out[i] = viscobar::exp(a); break;
      case Operation::log: out[i] = viscobar::log(a); break;
      case Operation::sqrt: out[i] = viscobar::sqrt(a); break;
      case Operation::abs: out[i] = viscobar::abs(a); break;
      case Operation::min: out[i] = viscobar::min(a, b); break;
      case Operation::max: out[i] = viscobar::max(a, b); break;
      default: out[i] = of_truth(compared(node.operation, (a - b).value), rests(a - b));
    }
    if (tighten) tighten(i, out[i]);
  }
}

FormulaTree parse_formula(std::string_view text, const Parameters& parameters) { return Parser(text, parameters)(); }

}  // namespace viscobar
