#include "input/formula.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace viscobar {
namespace {

constexpr double rounding = 4 * std::numeric_limits<double>::epsilon();  // a few operations, each correct to eps / 2

std::string complaint_about(const std::string& text, const char* variables = "x") {
  try {
    Formula(text, variables);
  } catch (const FormulaError& error) {
    return error.what();
  }
  return {};
}

struct Expected {
  const char* text;
  double (*value)(double x, double t);
};

class Values : public testing::TestWithParam<Expected> {};

TEST_P(Values, AreThoseOfTheSameExpressionInCpp) {
  const SpaceTimeFunction f = Formula(GetParam().text, "xt").of_x_t();
  for (const double x : {-1.5, 0.0, 0.25, 1.0, 26.0})
    for (const double t : {0.0, 0.5, 3.0}) {
      const double expected = GetParam().value(x, t);
      EXPECT_NEAR(f(x, t), expected, rounding * std::max(1.0, std::abs(expected))) << "x = " << x << ", t = " << t;
    }
}

const Expected expected_values[] = {
    {"0.5", [](double, double) { return 0.5; }},
    {" -2.5e-1 ", [](double, double) { return -0.25; }},
    {"x*(1-x)", [](double x, double) { return x * (1 - x); }},
    {"x - t/2 + x*t", [](double x, double t) { return x - t / 2 + x * t; }},
    {"-x^2", [](double x, double) { return -(x * x); }},
    {"2^3^2", [](double, double) { return 512.0; }},
    {"2^-2", [](double, double) { return 0.25; }},
    {"sin(t*sqrt(2))*cos(2*x)", [](double x, double t) { return std::sin(t * std::numbers::sqrt2) * std::cos(2 * x); }},
    {"tan(x/50)", [](double x, double) { return std::tan(x / 50); }},
    {"exp(-t)", [](double, double t) { return std::exp(-t); }},
    {"log(1 + t)", [](double, double t) { return std::log(1 + t); }},
    {"abs(x)", [](double x, double) { return std::abs(x); }},
    {"min(x, t)", [](double x, double t) { return std::min(x, t); }},
    {"max(x, t, 1)",
     [](double x, double t) {
       return std::max({x, t, 1.0});
     }},
    {"pi*x", [](double x, double) { return std::numbers::pi * x; }},
    {"x < 0.5 ? 1 : 2", [](double x, double) { return x < 0.5 ? 1.0 : 2.0; }},
    {"x <= 1 && t >= 0.5 || x == 26", [](double x, double t) { return (x <= 1 && t >= 0.5) || x == 26 ? 1.0 : 0.0; }},
    {"x != 1", [](double x, double) { return x != 1 ? 1.0 : 0.0; }},
    {"0.5 && 1", [](double, double) { return 1.0; }},
    {"x^3 - t^4", [](double x, double t) { return x * x * x - t * t * t * t; }},
    {"x > 1 ? t > 1 ? 3 : 2 : 1", [](double x, double t) { return x > 1 ? (t > 1 ? 3.0 : 2.0) : 1.0; }},
};

INSTANTIATE_TEST_SUITE_P(Formula, Values, testing::ValuesIn(expected_values));

TEST(Formula, KnowsWhichVariablesItUses) {
  EXPECT_TRUE(Formula("x*t", "xt").uses('x'));
  EXPECT_TRUE(Formula("x*t", "xt").uses('t'));
  EXPECT_FALSE(Formula("tan(x)", "xt").uses('t'));
  EXPECT_FALSE(Formula("max(t, 1)", "xt").uses('x'));
  EXPECT_FALSE(Formula("x", "x").is_constant());
}

TEST(Formula, WithoutVariablesIsItsValue) {
  const Formula half("sqrt(1/4)", "xt");
  ASSERT_TRUE(half.is_constant());
  EXPECT_EQ(half.constant(), 0.5);
  EXPECT_EQ(half.of_x()(3.0), 0.5);
  EXPECT_EQ(half.of_t()(3.0), 0.5);
  EXPECT_EQ(half.of_x_t()(3.0, 4.0), 0.5);
  EXPECT_EQ(Formula(-2.0).of_x()(3.0), -2.0);
}

TEST(Formula, OfOneVariableTakesItAsItsArgument) {
  EXPECT_EQ(Formula("2*x", "x").of_x()(3.0), 6.0);
  EXPECT_EQ(Formula("2*t", "t").of_t()(3.0), 6.0);
}

TEST(Formula, OutlivesItsSource) {
  SpaceFunction f;
  {
    const Formula source("x + 1", "x");
    f = source.of_x();
  }
  EXPECT_EQ(f(1.0), 2.0);
}

TEST(Formula, CopiesOfAFunctionWorkApart) {
  SpaceFunction original = Formula("x", "x").of_x();
  EXPECT_EQ(original(1.0), 1.0);
  const SpaceFunction copy = original;
  EXPECT_EQ(copy(2.0), 2.0);
  EXPECT_EQ(original(3.0), 3.0);
  original = nullptr;
  EXPECT_EQ(copy(4.0), 4.0);
}

TEST(Formula, CopiesOfAFunctionServeSeveralThreadsAtOnce) {
  const SpaceFunction f = Formula("sin(x)^2 + cos(x)^2 + x", "x").of_x();
  std::vector<int> wrong(4, 0);
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < wrong.size(); ++k)
    threads.emplace_back([copy = f, k, &wrong] {
      for (int i = 0; i < 20000; ++i) {
        const double x = static_cast<double>(k) + i * 1e-3;
        if (std::abs(copy(x) - (1 + x)) > rounding * (1 + x)) ++wrong[k];
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

TEST(Formula, AFunctionServesSeveralThreadsAtOnce) {
  const SpaceTimeFunction f = Formula("x < 1 ? sin(t)^2 + cos(t)^2 + x : x + 1", "xt").of_x_t();
  std::vector<int> wrong(4, 0);
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < wrong.size(); ++k)
    threads.emplace_back([&f, k, &wrong] {
      for (int i = 0; i < 20000; ++i) {
        const double x = static_cast<double>(k) * 0.5, t = i * 1e-3;
        if (std::abs(f(x, t) - (1 + x)) > rounding * (1 + x)) ++wrong[k];
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

/// A random formula, its value at some x and t by the operations of C++ as it is made, and how tightly it binds.
struct Made {
  std::string text;
  double value;
  int level;
};

class Maker {
 public:
  Made any(int depth) {
    if (depth == 0) return leaf();
    switch (pick(9)) {
      case 0: return call(depth);
      case 1: {
        const Made a = at_least(1, depth), b = any(depth - 1), c = any(depth - 1);
        return {a.text + " ? " + b.text + ":" + c.text, a.value != 0.0 ? b.value : c.value, 0};
      }
      case 2: {
        const Made a = any(depth - 1), b = any(depth - 1);
        return pick(2) ? Made{"min(" + a.text + ", " + b.text + ")", std::min(a.value, b.value), atom}
                       : Made{"max(" + a.text + "," + b.text + ")", std::max(a.value, b.value), atom};
      }
      case 3: {
        const Made a = at_least(7, depth);
        return {"-" + a.text, -a.value, 6};
      }
      case 4: return power(depth);
      default: return binary(depth);
    }
  }

  std::mt19937 random{1};
  double x = 0.0, t = 0.0;

 private:
  static constexpr int atom = 8;
  int pick(int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); }

  Made leaf() {
    const Made leaves[] = {{"x", x, atom},     {"t", t, atom},     {"pi", std::numbers::pi, atom},
                           {"2", 2, atom},     {"0.3", 0.3, atom}, {"1e-1", 1e-1, atom},
                           {".25", .25, atom}, {"3.", 3, atom},    {"1E+2", 100, atom},
                           {"p_1", 0.7, atom}};
    return leaves[pick(10)];
  }
  Made at_least(int level, int depth) {
    Made made = any(depth - 1);
    return made.level >= level ? made : Made{"(" + made.text + ")", made.value, atom};
  }
  Made call(int depth) {
    const std::pair<const char*, double (*)(double)> known[] = {
        {"sin", std::sin}, {"cos", std::cos},   {"tan", std::tan}, {"exp", std::exp},
        {"log", std::log}, {"sqrt", std::sqrt}, {"abs", std::fabs}};
    const auto& [name, function] = known[pick(7)];
    const Made a = any(depth - 1);
    return {std::string(name) + "(" + a.text + ")", function(a.value), atom};
  }
  // From the right. A square is a product, and 3 or 4 of a variable.
  Made power(int depth) {
    const Made a = at_least(atom, depth), b = at_least(6, depth);
    const bool product = b.value == 2.0 || ((a.text == "x" || a.text == "t") && b.text == "3.");
    double value = a.value;
    for (int k = 1; product && k < b.value; ++k) value *= a.value;
    return {a.text + "^" + b.text, product ? value : std::pow(a.value, b.value), 7};
  }
  // From the left.
  Made binary(int depth) {
    constexpr std::pair<const char*, int> known[] = {{"||", 1}, {"&&", 2}, {"<", 3}, {"<=", 3}, {">", 3}, {">=", 3},
                                                     {"==", 3}, {"!=", 3}, {"+", 4}, {"-", 4},  {"*", 5}, {"/", 5}};
    const int k = pick(12);
    const auto [sign, level] = known[k];
    const Made left = at_least(level, depth), right = at_least(level + 1, depth);
    const double a = left.value, b = right.value;
    const double values[] = {double(a || b), double(a && b), double(a < b),  double(a <= b),
                             double(a > b),  double(a >= b), double(a == b), double(a != b),
                             a + b,          a - b,          a * b,          a / b};
    return {left.text + " " + sign + right.text, values[k], level};
  }
};

TEST(Formula, HasTheValueOfTheSameOperationsInCppToTheLastDigit) {
  Maker maker;
  int compared = 0;
  for (int i = 0; i < 20000; ++i) {
    maker.x = (i % 7) * 0.3;
    maker.t = (i % 11) * 0.27;
    const Made made = maker.any(1 + i % 5);
    std::optional<Formula> formula;
    try {
      formula.emplace(made.text, "xt", Parameters{{"p_1", 0.7}});
    } catch (const FormulaError& error) {
      EXPECT_FALSE(std::isfinite(made.value)) << made.text << ": " << error.what();
      continue;
    }
    const double value = formula->of_x_t()(maker.x, maker.t);
    EXPECT_TRUE(value == made.value || (std::isnan(value) && std::isnan(made.value)))
        << made.text << " at " << maker.x << ", " << maker.t << ": " << value << " for " << made.value;
    ++compared;
  }
  EXPECT_GT(compared, 15000);
}

TEST(Formula, HasTheSameDigitsAtManyPlacesAtOnceAsAtEach) {
  Maker maker;
  int compared = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    std::optional<Formula> formula;
    try {
      text = maker.any(1 + i % 5).text;
      formula.emplace(text, "xt", Parameters{{"p_1", 0.7}});
    } catch (const FormulaError&) {
      continue;
    }
    const SpaceTimeFunction f = formula->of_x_t();
    const auto* rows = f.target<RowFunction>();
    if (!rows) continue;
    std::vector<double> x(1 + i % 75), values(x.size());
    for (std::size_t j = 0; j < x.size(); ++j) x[j] = 0.3 * static_cast<double>(j % 8);
    rows->row(x, maker.t, values);
    for (std::size_t j = 0; j < x.size(); ++j) {
      const double value = f(x[j], maker.t);
      EXPECT_TRUE(value == values[j] || (std::isnan(value) && std::isnan(values[j])))
          << text << " at " << x[j] << ": " << values[j] << " for " << value;
      compared += x[j] > 0.0;
    }
  }
  EXPECT_GT(compared, 200000);
}

TEST(Formula, OfAProductHasAFactorOfXAndOneOfT) {
  const Parameters parameters{{"p", 0.7}, {"q", -3.0}};
  for (const char* text :
       {"x*t", "sin(t*sqrt(2))*cos(2*x)", "-(x*sin(t))/2", "-x*-t", "2/(1 + x)/exp(t)", "p*x*(t/q)", "t/(q - x)/(p/t)",
        "(t < 0.3 ? 1 : 0)*(x < 0.5 ? x : 1 - x)*3", "(x < p ? (x < 0.2 ? 1 : p) : x^3)*(t < q ? 0 : t)",
        "(t > 0.1 && t < 0.4 ? sin(t) : max(t, p))*min(x, 0.5)*abs(x - 0.3)*(t + 1)^2.5"}) {
    const Formula formula(text, "xt", parameters);
    const auto factors = formula.factors();
    ASSERT_TRUE(factors) << text;
    EXPECT_FALSE(factors->first.uses('t') || factors->second.uses('x')) << text;
    const SpaceTimeFunction whole = formula.of_x_t();
    const SpaceFunction profile = factors->first.of_x();
    const TimeFunction history = factors->second.of_t();
    for (const double x : {0.0, 0.1, 0.35, 0.5, 0.65, 1.0})
      for (const double t : {0.05, 0.2, 0.3, 0.39, 1.0})
        EXPECT_NEAR(profile(x) * history(t), whole(x, t), 4.0 * rounding * std::abs(whole(x, t))) << text;
  }
  for (const char* text : {"x*t + 1", "x*sin(x*t)", "(x ? t : 2)*x", "(x*t)^2", "x - t", "x*3", "t", "x < t"})
    EXPECT_FALSE(Formula(text, "xt", parameters).factors()) << text;
}

TEST(Formula, FactorsOfAProductKnowTheirOwnBreaks) {
  const auto factors = Formula("(t < 0.3 ? 1 : 2)*(x < 0.5 ? x : (x < 0.75 ? 1 : 3))", "xt").factors();
  ASSERT_TRUE(factors);
  const Places places = factors->first.places(1.0);
  EXPECT_NEAR(places.breaks(0.0, 1.0).value_or(0.0), 0.5, rounding);
  EXPECT_NEAR(places.breaks(0.6, 1.0).value_or(0.0), 0.75, rounding);
  const NextBreak breaks = factors->second.breaks();
  EXPECT_NEAR(breaks(0.0, 1.0).value_or(0.0), 0.3, rounding);
  EXPECT_FALSE(breaks(0.4, 1.0));
}

TEST(Formula, CannotChangeItsVariables) {
  for (const char* text : {"x = 3", "x=3", "(x = 3) + 1", "x === 1", "x == = 1", "x += 1", "t = 1"})
    EXPECT_NE(complaint_about(text, "xt"), "") << text;
  EXPECT_EQ(complaint_about("x == 3", "xt"), "");
}

TEST(Formula, KnowsNothingOfTheLibraryBeyondItsOwnNames) {
  for (const char* text :
       {"_pi", "_e", "e", "rnd()", "rint(x)", "sum(x, 1)", "avg(x, 1)", "log2(x)", "log10(x)", "ln(x)", "sign(x)",
        "sinh(x)", "atan2(x, 1)", "\"text\"", "x, 1", "(x, 1)", "sin(x), cos(x)"})
    EXPECT_NE(complaint_about(text), "") << text;
}

TEST(Formula, SaysWhereAnUnknownNameStandsAndWhichIsNearest) {
  EXPECT_EQ(complaint_about("1 + coz(x)"), "the formula knows no \"coz\" at character 5; nearest is \"cos\"");
}

TEST(Formula, RefusesTheVariableOfAnotherFunction) {
  EXPECT_NE(complaint_about("t", "x").find("function of x alone"), std::string::npos);
  EXPECT_NE(complaint_about("x", "t").find("function of t alone"), std::string::npos);
}

TEST(Formula, OfAnyBytesIsTakenOrRefusedButNeverBreaks) {
  // Short texts over the alphabet that the grammar knows, from a generator of fixed seed.
  const std::string alphabet = "xt0123456789.+-*/^()<>=!&|?:, eEsincomaxlgpi\"\\_#\n";
  unsigned long state = 1;
  const auto next = [&state](std::size_t n) {
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return static_cast<std::size_t>(state >> 33) % n;
  };
  int taken = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    for (std::size_t n = 1 + next(10); n > 0; --n) text += alphabet[next(alphabet.size())];
    const std::string problem = complaint_about(text, "xt");
    if (problem.empty()) {
      ++taken;
      Formula(text, "xt").of_x_t()(0.5, 0.25);
    } else {
      EXPECT_TRUE(problem.starts_with("the formula ") || problem.starts_with("must be finite")) << text;
    }
  }
  EXPECT_GT(taken, 100);
}

}  // namespace
}  // namespace viscobar
