#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <locale>
#include <numbers>
#include <sstream>
#include <utility>

#include "input/formula_tree.hpp"
#include "input/input_text.hpp"
#include "input/toml_text.hpp"
#include "text/nearest_name.hpp"

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
constexpr std::string_view signs[] = {"||", "&&", "<=", ">=", "==", "!=", "<", ">", "+",
                                      "-",  "*",  "/",  "^",  "(",  ")",  ",", "?", ":"};

constexpr Operation functions[] = {Operation::sin,  Operation::cos, Operation::tan, Operation::exp, Operation::log,
                                   Operation::sqrt, Operation::abs, Operation::min, Operation::max};
constexpr std::array<std::string_view, 10> known_names = {"sin",  "cos", "tan", "exp", "log",
                                                          "sqrt", "abs", "min", "max", "pi"};

/// Words of other languages, and what to write instead.
constexpr std::pair<std::string_view, std::string_view> habits[] = {
    {"ln", "log is the natural logarithm"},
    {"pow", "a power is written x^2"},
    {"e", "the exponential function is exp"},
    {"if", "a case is written condition ? then : else"},
    {"heaviside", "a step is written x < 0.5 ? 0 : 1"},
    {"step", "a step is written x < 0.5 ? 0 : 1"},
    {"sign", "a sign is written x < 0 ? -1 : 1"},
    {"and", "both is written &&"},
    {"or", "one of two is written ||"},
    {"not", "not is written == 0"},
    {"L", "the length is written as a number"},
};

// The parser's stack grows with the depth, the memory of a computation with the length.
constexpr std::size_t longest_formula = 4096;
constexpr int deepest = 200;

std::string at(std::size_t index) { return fmt::format(" at character {}", index + 1); }

bool starts_name(char c) { return is_letter(c) || c == '_'; }
bool in_name(char c) { return starts_name(c) || is_digit(c); }

template <class... Values>
[[noreturn]] void refuse(fmt::format_string<Values...> problem, Values&&... values) {
  throw FormulaError("the formula " + fmt::format(problem, std::forward<Values>(values)...));
}

class Parser {
 public:
  Parser(std::string_view text, const Parameters& parameters, std::string_view variables)
      : text_(text), parameters_(parameters), variables_(variables) {}

  FormulaTree operator()() {
    if (text_.size() > longest_formula) refuse("is too long: {} characters, at most {}", text_.size(), longest_formula);
    if (rest().empty()) refuse("is empty");
    tree_.root = choice();
    if (!rest().empty()) expected();
    return std::move(tree_);
  }

 private:
  std::string_view rest() {
    at_ = std::min(text_.find_first_not_of(" \t\r\n", at_), text_.size());
    return text_.substr(at_);
  }
  bool take(std::string_view token) {
    if (!rest().starts_with(token)) return false;
    at_ += token.size();
    return true;
  }
  // A name, or digits and what is written with them.
  std::string_view word() {
    const std::string_view here = rest();
    const bool number = !here.empty() && (is_digit(here.front()) || here.front() == '.');
    const auto part = [number](char c) { return in_name(c) || (number && c == '.'); };
    return here.substr(0, static_cast<std::size_t>(std::ranges::find_if_not(here, part) - here.begin()));
  }

  // The formula, read as far as this, cannot go on like that.
  [[noreturn]] void unexpected() {
    const std::string_view here = rest();
    std::string_view token = word();
    if (!token.empty() && starts_name(token.front()) && !knows(token)) refuse("{}", unknown_name(token));
    for (const std::string_view sign : signs)
      if (token.empty() && here.starts_with(sign)) token = sign;
    if (const char c = here.front(); c < ' ' || c > '~' || c == '"') {
      const std::string_view ascii = ascii_for(here.substr(0, character_length(text_, at_)));
      refuse("holds a character that is no part of a formula{}{}{}", at(characters(text_.substr(0, at_))),
             ascii.empty() ? "" : "; write ", ascii == " " ? "a plain blank" : ascii);
    }
    if (token == "*" && at_ > 0 && text_[at_ - 1] == '*') refuse("has **{}; a power is written ^", at(at_ - 1));
    if (token.empty() && here.front() == '=') refuse("assigns with ={}; comparison is ==", at(at_));
    if (!token.empty()) refuse("does not expect \"{}\"{}{}", token, at(at_), product_advice());
    refuse("cannot be understood from \"{}\"{} on", here.substr(0, here.find_first_of(" \t\r\n")), at(at_));
  }
  // The same, behind a value.
  [[noreturn]] void expected() {
    if (rest().empty()) refuse("does not close a parenthesis");
    if (rest().starts_with(','))
      refuse("has a comma outside of a function's arguments; decimals are written with a point");
    if (take(":")) refuse("has a : without its ?,{}", at(at_));
    unexpected();
  }

  bool knows(std::string_view token) const {
    const bool called = text_.substr(at_ + token.size()).starts_with('(');
    return parameters_.contains(token) || token == "pi" ||
           (called && std::ranges::find(known_names, token) != known_names.end()) ||
           (token.size() == 1 && variables_.find(token) != variables_.npos);
  }

  std::string unknown_name(std::string_view token) const {
    if (token == "x" || token == "t")
      return fmt::format("uses {}{}, but is a function of {} alone", token, at(at_), variables_);
    if (std::ranges::find(known_names, token) != known_names.end())
      return fmt::format("names the function {}{} without its arguments in parentheses", token, at(at_));
    for (const auto& [word, instead] : habits)
      if (word == token) return fmt::format("knows no \"{}\"{}; {}", token, at(at_), instead);
    std::optional<std::string_view> nearest;
    if (token.size() > 1) nearest = nearest_name(token, known_names);
    for (const auto& [name, value] : parameters_)
      if (nearest_name(token, std::array{std::string_view(name)})) nearest = name;
    for (std::size_t i = 0; i < variables_.size(); ++i)
      if (plain_name(token) == variables_.substr(i, 1)) nearest = variables_.substr(i, 1);
    return fmt::format("knows no \"{}\"{}{}", token, at(at_),
                       nearest ? fmt::format("; nearest is \"{}\"", *nearest)
                               : fmt::format("; it may use {}{} and {}", variables_.substr(0, 1),
                                             variables_.size() > 1 ? ", t" : "", fmt::join(known_names, " ")));
  }

  // A factor beside another, as on paper.
  std::string_view product_advice() const {
    const std::size_t before = text_.substr(0, at_).find_last_not_of(' ');
    if (before == text_.npos) return {};
    const char ends = text_[before], begins = text_[at_];
    return (in_name(ends) || ends == ')' || ends == '.') && (in_name(begins) || begins == '(')
               ? "; a product is written with *"
               : "";
  }

  FormulaTree::Node& node(int index) { return tree_.nodes[static_cast<std::size_t>(index)]; }

  int add(Operation operation, std::initializer_list<int> operands) {
    FormulaTree::Node added{operation};
    std::ranges::copy(operands, added.of.begin());
    added.operands = static_cast<unsigned char>(operands.size());
    added.branch = branch_;
    if (operation > Operation::otherwise && operation != Operation::choose &&
        std::ranges::all_of(operands, [&](int k) { return is_number(k); }))
      return computed(added);
    for (const int operand : operands) {
      added.uses_x |= tree_.uses_x(operand);
      added.uses_t |= tree_.uses_t(operand);
    }
    tree_.nodes.push_back(added);
    return static_cast<int>(tree_.nodes.size()) - 1;
  }
  bool is_number(int k) const { return k <= FormulaTree::first_number && tree_.number(k).parameter < 0; }
  int add_number(double value, int parameter = -1) {
    tree_.numbers.push_back({value, parameter});
    return FormulaTree::first_number + 1 - static_cast<int>(tree_.numbers.size());
  }

  // An operation on numbers, which are the last ones.
  int computed(FormulaTree::Node node) {
    FormulaTree part;
    part.numbers.assign(tree_.numbers.end() - node.operands, tree_.numbers.end());
    tree_.numbers.resize(tree_.numbers.size() - node.operands);
    node.of = {FormulaTree::first_number, FormulaTree::first_number - 1};
    part.nodes.push_back(node);
    return add_number(part(0.0, 0.0));
  }

  int branch(int condition, bool when) {
    tree_.branches.push_back({condition, branch_, when});
    const int outer = std::exchange(branch_, static_cast<int>(tree_.branches.size()) - 1), value = choice();
    branch_ = outer;
    return value;
  }

  int choice() {
    const int condition = binary(0);
    if (!take("?")) return condition;
    const int then = add(Operation::then, {condition}), a = branch(condition, true);
    if (!take(":")) {
      if (rest().empty() ? open_ == 0 : rest().starts_with(')') && open_ > 0) refuse("has a ? without its :");
      expected();
    }
    const int otherwise = add(Operation::otherwise, {condition}), b = branch(condition, false);
    const int choose = add(Operation::choose, {condition, a, b});
    node(then).of[1] = otherwise;
    node(otherwise).of[1] = choose;
    return choose;
  }

  int binary(int level) {
    if (level > tightest) return signed_power();
    int left = binary(level + 1);
    const auto follows = [&](const Operator& each) { return each.level == level && take(each.sign); };
    while (true) {
      const auto* found = std::ranges::find_if(binary_operators, follows);
      if (found == std::end(binary_operators)) return left;
      const int right = binary(level + 1);
      left = add(found->operation, {left, right});
    }
  }

  int signed_power() {
    if (take("-")) return add(Operation::negate, {power()});
    take("+");
    return power();
  }

  int power() {
    const int base = primary();
    if (!take("^")) return base;
    const int exponent = signed_power();
    const double n = is_number(exponent) ? tree_.number(exponent).value : 0.0;
    if (base < FormulaTree::t || base > FormulaTree::x || (n != 3.0 && n != 4.0))
      return add(Operation::power, {base, exponent});
    // A variable's is a product, in a tenth of the time.
    tree_.numbers.pop_back();
    int product = base;
    for (int k = 1; k < n; ++k) product = add(Operation::multiply, {product, base});
    return product;
  }

  int primary() {
    if (rest().empty()) refuse("ends too early");
    if (take("(")) return in_parentheses(Operation::choose, "");
    const std::string_view token = word();
    if (!token.empty() && !starts_name(token.front())) return add_number(number());
    if (token.empty() || !knows(token)) unexpected();
    at_ += token.size();
    if (const auto named = parameters_.find(token); named != parameters_.end()) {
      const auto there = std::ranges::find(tree_.parameters, named->first);
      const auto index = static_cast<int>(there - tree_.parameters.begin());
      if (there == tree_.parameters.end()) tree_.parameters.push_back(named->first);
      return add_number(named->second, index);
    }
    if (token == "pi") return add_number(std::numbers::pi);
    if (token == "x") return FormulaTree::x;
    if (token == "t") return FormulaTree::t;
    take("(");
    if (take(")")) refuse("gives {} too few arguments{}", token, at(at_));
    return in_parentheses(functions[std::ranges::find(known_names, token) - known_names.begin()], token);
  }

  double number() {
    const std::string_view here = rest();
    double number = 0.0;
    const auto [end, error] = std::from_chars(here.data(), here.data() + here.size(), number);
    const std::string_view behind = here.substr(static_cast<std::size_t>(end - here.data()));
    bool sound = error == std::errc{} && !behind.starts_with('e') && !behind.starts_with('E');
    if (error == std::errc::result_out_of_range) {  // or too close to 0
      std::istringstream stream{std::string(here)};
      stream.imbue(std::locale::classic());
      sound = static_cast<bool>(stream >> number);
    }
    if (!sound) refuse("cannot be understood from \"{}\"{} on", word(), at(at_));
    at_ += here.size() - behind.size();
    return number;
  }

  // The arguments of a function, up to the closing parenthesis; `choose` is none.
  int in_parentheses(Operation function, std::string_view name) {
    if (++open_ > deepest) refuse("nests parentheses more than {} deep{}", deepest, at(at_ - 1));
    const bool several = function == Operation::min || function == Operation::max;
    int value = choice();
    if (!name.empty() && !several) value = add(function, {value});
    while (!name.empty() && take(",")) {
      if (!several) refuse("gives {} too many arguments{}", name, at(at_ - 1));
      const int next = choice();
      value = add(function, {value, next});
    }
    if (!take(")")) expected();
    --open_;
    return value;
  }

  const std::string_view text_;
  const Parameters& parameters_;
  const std::string_view variables_;
  std::size_t at_ = 0;
  int branch_ = -1, open_ = 0;
  FormulaTree tree_;
};

}  // namespace

std::string parameter_name_problem(std::string_view name) {
  if (name.empty() || !starts_name(name.front()) || !std::ranges::all_of(name, in_name))
    return "is no name for formulas: letters, digits and _, a letter first";
  constexpr std::size_t longest = 100;
  if (name.size() > longest) return fmt::format("is too long a name: {} characters, {} at most", name.size(), longest);
  if (name == "x" || name == "t" || std::ranges::find(known_names, name) != known_names.end())
    return fmt::format("formulas know \"{}\" already; take another name", name);
  return {};
}

FormulaTree parse_formula(std::string_view text, const Parameters& parameters, std::string_view variables) {
  return Parser(text, parameters, variables)();
}

}  // namespace viscobar
