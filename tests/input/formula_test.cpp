#include "input/formula.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <thread>
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
