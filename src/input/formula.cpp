#include "input/formula.hpp"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "input/input_text.hpp"
#include "input/of_thread.hpp"
#include "input/toml_text.hpp"
#include "scene/message_text.hpp"
#include "text/nearest_name.hpp"

namespace viscobar {

namespace {

constexpr std::array<std::string_view, 10> functions = {"sin",  "cos", "tan", "exp", "log",
                                                        "sqrt", "abs", "min", "max", "pi"};

// Binds the names a formula knows, and nothing else of what the library would offer.
void define_names(mu::Parser& parser, const Parameters& parameters) {
  parser.ClearFun();
  parser.ClearConst();
  using Unary = double (*)(double);
  constexpr std::pair<const char*, Unary> unary[] = {{"sin", std::sin}, {"cos", std::cos}, {"tan", std::tan},
                                                     {"exp", std::exp}, {"log", std::log}, {"sqrt", std::sqrt},
                                                     {"abs", std::fabs}};
  for (const auto& [name, function] : unary) parser.DefineFun(name, function);
  parser.DefineFun(
      "min", +[](const double* values, int n) { return *std::min_element(values, values + n); });
  parser.DefineFun(
      "max", +[](const double* values, int n) { return *std::max_element(values, values + n); });
  parser.DefineConst("pi", std::numbers::pi);
  for (const auto& [name, value] : parameters) parser.DefineConst(name, value);
}

// A parser reads its variables through pointers, so they are beside it and it does not move.
struct Machine {
  Machine(const std::string& of, const Parameters& with) : text(of), parameters(with) {
    define_names(parser, parameters);
    parser.DefineVar("x", &x);
    parser.DefineVar("t", &t);
    parser.SetExpr(text);
  }
  const std::string text;
  const Parameters parameters;
  double x = 0.0, t = 0.0;
  mu::Parser parser;
};

// Parsers that nobody uses, of the thread. A sweep asks for those of the same few formulas thousands of times, and to
// make one takes longer than to evaluate it on a small mesh.
class IdleMachines {
 public:
  static std::unique_ptr<Machine> take(const std::string& text, const Parameters& parameters) {
    for (auto& idle : (*of_thread()).idle_)
      if (idle && idle->text == text && idle->parameters == parameters) return std::move(idle);
    return std::make_unique<Machine>(text, parameters);
  }
  static void give(std::unique_ptr<Machine> machine) noexcept {
    if (IdleMachines* own = of_thread().if_any()) std::swap(own->idle_[own->next_++ % own->idle_.size()], machine);
  }

 private:
  static const OfThread<IdleMachines>& of_thread() {
    static const OfThread<IdleMachines> machines;
    return machines;
  }

  std::array<std::unique_ptr<Machine>, 8> idle_;
  std::size_t next_ = 0;
};

// A copy has a parser of its own. It gets it when it is called first: most copies of a scene's functions never are.
class Compiled {
 public:
  Compiled(std::string text, const Parameters& parameters) : text_(std::move(text)), parameters_(parameters) {}
  Compiled(const Compiled& other) : Compiled(other.text_, other.parameters_) {}
  Compiled& operator=(const Compiled&) = delete;
  ~Compiled() {
    if (machine_) IdleMachines::give(std::move(machine_));
  }

  double operator()(double x, double t) {
    if (!machine_) machine_ = IdleMachines::take(text_, parameters_);
    machine_->x = x;
    machine_->t = t;
    return machine_->parser.Eval();
  }

 private:
  std::string text_;
  Parameters parameters_;
  std::unique_ptr<Machine> machine_;
};

// muParser's time grows with the square of the length, its stack with the depth.
constexpr std::size_t longest = 4096, deepest = 200;

std::string at(std::size_t index) { return fmt::format(" at character {}", index + 1); }

/// What other languages know, and what to write instead.
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

bool starts_name(char c) { return is_letter(c) || c == '_'; }

std::string foreign_character(std::string_view text, std::size_t i) {
  const std::string_view ascii = ascii_for(text.substr(i, character_length(text, i)));
  return fmt::format("the formula holds a character that is no part of a formula{}{}{}",
                     at(characters(text.substr(0, i))), ascii.empty() ? "" : "; write ",
                     ascii == " " ? "a plain blank" : ascii);
}

void check_size(std::string_view text) {
  if (text.size() > longest)
    throw FormulaError(fmt::format("the formula is too long: {} characters, at most {}", text.size(), longest));
  std::size_t depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == ')' && depth > 0) --depth;
    if (text[i] == '(' && ++depth > deepest)
      throw FormulaError(fmt::format("the formula nests parentheses more than {} deep{}", deepest, at(i)));
  }
}

// What the library takes but a formula must not hold: assignments, bytes that are no printable ASCII, strings.
void check_characters(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool blank = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (!blank && (c < ' ' || c > '~' || c == '"')) throw FormulaError(foreign_character(text, i));
    if (text.substr(i).starts_with("**")) throw FormulaError("the formula has **" + at(i) + "; a power is written ^");
    if (c != '=') continue;
    const bool equality = text.substr(i).starts_with("==");
    if (!equality && (i == 0 || std::string_view("<>!").find(text[i - 1]) == std::string_view::npos))
      throw FormulaError("the formula assigns with =" + at(i) + "; comparison is ==");
    if (equality) ++i;
  }
}

std::string unknown_token(std::string_view token, std::string_view variables, std::size_t position,
                          const Parameters& parameters) {
  token = token.substr(0, token.find_first_of(" \t\r\n"));
  if (token.empty() || !starts_name(token.front()))
    return fmt::format("cannot be understood from \"{}\"{} on", token, at(position));
  if (token == "x" || token == "t")
    return fmt::format("uses {}{}, but is a function of {} alone", token, at(position), variables);
  if (std::ranges::find(functions, token) != functions.end())
    return fmt::format("names the function {}{} without its arguments in parentheses", token, at(position));
  for (const auto& [word, instead] : habits)
    if (word == token) return fmt::format("knows no \"{}\"{}; {}", token, at(position), instead);
  std::optional<std::string_view> nearest;
  if (token.size() > 1) nearest = nearest_name(token, functions);
  for (const auto& [name, value] : parameters)
    if (nearest_name(token, std::array{std::string_view(name)})) nearest = name;
  for (std::size_t i = 0; i < variables.size(); ++i)
    if (plain_name(token) == variables.substr(i, 1)) nearest = variables.substr(i, 1);
  return fmt::format("knows no \"{}\"{}{}", token, at(position),
                     nearest ? fmt::format("; nearest is \"{}\"", *nearest)
                             : fmt::format("; it may use {}{} and {}", variables.substr(0, 1),
                                           variables.size() > 1 ? ", t" : "", fmt::join(functions, " ")));
}

// A factor beside another, as on paper.
std::string_view product_advice(std::string_view text, std::size_t position) {
  const std::size_t before = text.substr(0, position).find_last_not_of(' ');
  if (position >= text.size() || before == text.npos) return {};
  const auto part = [](char c) { return starts_name(c) || is_digit(c); };
  const char ends = text[before], begins = text[position];
  return (part(ends) || ends == ')' || ends == '.') && (part(begins) || begins == '(') ? "; a product is written with *"
                                                                                       : "";
}

constexpr std::string_view outer_comma =
    "has a comma outside of a function's arguments; decimals are written with a point";

std::string explain(const mu::ParserError& error, std::string_view text, std::string_view variables,
                    const Parameters& parameters) {
  const std::size_t position = error.GetPos() < 0 ? 0 : static_cast<std::size_t>(error.GetPos());
  switch (error.GetCode()) {
    case mu::ecUNASSIGNABLE_TOKEN: return unknown_token(error.GetToken(), variables, position, parameters);
    case mu::ecUNEXPECTED_EOF: return "ends too early";
    case mu::ecEMPTY_EXPRESSION: return "is empty";
    case mu::ecMISSING_PARENS: return "does not close a parenthesis";
    case mu::ecTOO_MANY_PARAMS: return fmt::format("gives {} too many arguments{}", error.GetToken(), at(position));
    case mu::ecTOO_FEW_PARAMS: return fmt::format("gives {} too few arguments{}", error.GetToken(), at(position));
    case mu::ecMISSING_ELSE_CLAUSE: return "has a ? without its :";
    case mu::ecMISPLACED_COLON: return "has a : without its ?," + at(position);
    case mu::ecUNEXPECTED_ARG:
    case mu::ecUNEXPECTED_ARG_SEP: return std::string(outer_comma);
    case mu::ecEXPRESSION_TOO_LONG: return "is too long";
    default:
      return position < text.size() ? fmt::format("does not expect \"{}\"{}{}", error.GetToken(), at(position),
                                                  product_advice(text, position))
                                    : "is not complete";
  }
}

}  // namespace

std::string parameter_name_problem(std::string_view name) {
  const auto part = [](char c) { return starts_name(c) || is_digit(c); };
  if (name.empty() || !starts_name(name.front()) || !std::ranges::all_of(name, part))
    return "is no name for formulas: letters, digits and _, a letter first";
  constexpr std::size_t longest = 100;  // that muParser takes
  if (name.size() > longest) return fmt::format("is too long a name: {} characters, {} at most", name.size(), longest);
  if (name == "x" || name == "t" || std::ranges::find(functions, name) != functions.end())
    return fmt::format("formulas know \"{}\" already; take another name", name);
  return {};
}

Formula::Formula(std::string text, std::string_view variables, const Parameters& parameters)
    : parameters_(parameters), text_(std::move(text)) {
  // A scene asks for each of its formulas several times, and a sweep for those of thousands of scenes.
  static const OfThread<std::map<std::tuple<std::string, std::string, Parameters>, std::pair<std::string, double>>> own;
  auto& all_known = *own;
  const auto key = std::tuple(text_, std::string(variables), parameters_);
  if (const auto known = all_known.find(key); known != all_known.end()) {
    std::tie(used_, constant_) = known->second;
    return;
  }
  check_size(text_);
  check_characters(text_);
  mu::Parser parser;
  define_names(parser, parameters_);
  double value = 0.0;
  for (const char variable : variables) parser.DefineVar(std::string(1, variable), &value);
  try {
    parser.SetExpr(text_);
    constant_ = parser.Eval();
    if (parser.GetNumResults() != 1) throw FormulaError(fmt::format("the formula {}", outer_comma));
    for (const auto& [name, storage] : parser.GetUsedVar()) used_ += name;
  } catch (const mu::ParserError& error) {
    throw FormulaError("the formula " + explain(error, text_, variables, parameters_));
  }
  if (!is_constant()) parse_formula(text_, parameters_);  // breaks() will
  if (is_constant() && !std::isfinite(constant_))
    throw FormulaError(fmt::format("must be finite, is {}", printable(constant_)));
  constexpr std::size_t most = 100;
  if (all_known.size() >= most) all_known.clear();
  all_known.emplace(key, std::pair(used_, constant_));
}

SpaceFunction Formula::of_x() const {
  if (is_constant()) return [value = constant_](double) { return value; };
  return [f = Compiled(text_, parameters_)](double x) mutable { return f(x, 0.0); };
}

TimeFunction Formula::of_t() const {
  if (is_constant()) return [value = constant_](double) { return value; };
  return [f = Compiled(text_, parameters_)](double t) mutable { return f(0.0, t); };
}

SpaceTimeFunction Formula::of_x_t() const {
  if (is_constant()) return [value = constant_](double, double) { return value; };
  return [f = Compiled(text_, parameters_)](double x, double t) mutable { return f(x, t); };
}

NextBreak Formula::breaks() const {
  if (!uses('t')) return {};
  const FormulaTree tree = parse_formula(text_, parameters_);
  FormulaSwitches switches(tree, false);
  if (switches.empty()) return {};
  return [switches](double after, double until) mutable { return switches.first(0.0, after, until); };
}

NextBreak Formula::breaks_and_pulses(double length) const {
  if (!uses('t')) return {};
  // A jump or kink that travels is at each time somewhere in x: of all x at once no pulse can be told from it.
  if (breaks_at()) return breaks();
  FormulaDetail pulses(parse_formula(text_, parameters_), false, {0.0, uses('x') ? length : 0.0});
  const NextBreak breaks = this->breaks();
  return breaks ? either_of(breaks, pulses) : pulses;
}

NextBreakAt Formula::breaks_at() const {
  if (!uses('t') || !uses('x')) return {};
  FormulaSwitches switches(parse_formula(text_, parameters_), true);
  if (switches.empty()) return {};
  return [switches](double x, double after, double until) mutable { return switches.first(x, after, until); };
}

NextBreakAt Formula::breaks_in_x_at() const {
  if (!uses('x')) return {};
  auto switches = FormulaSwitches::along_x(parse_formula(text_, parameters_));
  if (switches.empty()) return {};
  return [switches](double t, double after, double until) mutable { return switches.first(t, after, until); };
}

NextBreakAt Formula::detail_in_x_at(double length) const {
  if (!uses('x')) return {};
  std::optional<FormulaDetail> at_time;
  return [=, *this, known = 0.0](double t, double after, double until) mutable {
    if (!at_time || t != known) at_time.emplace(parse_formula(text_, parameters_), true, Interval{t, t});
    known = t;
    (*at_time)(0.0, length);
    return (*at_time)(after, until);
  };
}

Places Formula::places(double length) const {
  if (!uses('x')) return {};
  // The same few formulas in thousands of scenes of a sweep.
  static const OfThread<std::map<std::tuple<std::string, Parameters, double>, Places>> own;
  auto& all_known = *own;
  const auto key = std::tuple(text_, parameters_, length);
  if (const auto known = all_known.find(key); known != all_known.end()) return known->second;
  const FormulaTree tree = parse_formula(text_, parameters_);
  FormulaDetail detail(tree, true, {0.0, 0.0});
  detail(0.0, length);  // found once, for all copies
  constexpr std::size_t most = 100;
  if (all_known.size() >= most) all_known.clear();
  return all_known[key] = {[switches = FormulaSwitches::along_x(tree)](double after, double until) mutable {
                             return switches.first(0.0, after, until);
                           },
                           detail};
}

SpaceTimeFunction Formula::derivative(std::string_view by) const {
  if (text_.empty()) return {};
  FormulaTaylor derivative(parse_formula(text_, parameters_), by);
  if (derivative.is_zero()) return {};
  return [derivative](double x, double t) mutable { return derivative(x, t)[1]; };
}

TimeFunction Formula::derivative_of_t(int order, std::string_view by) const {
  if (by.empty() && order == 0) return of_t();
  if (is_constant() && order > 0) return [](double) { return 0.0; };
  const auto k = static_cast<std::size_t>(order);
  const FormulaTree tree = parse_formula(text_, parameters_);
  if (by.empty()) return [f = FormulaTaylor(tree, "t"), k](double t) mutable { return f(0.0, t)[k]; };
  return [f = TaylorFormula<Dual>(tree, "t", by), k](double t) mutable { return f(0.0, t)[k].slope; };
}

bool Formula::moves_jump(std::string_view by) const {
  return !text_.empty() && FormulaTaylor(parse_formula(text_, parameters_), by).moves_jump();
}

}  // namespace viscobar
