#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "input/formula.hpp"
#include "input/formula_tree.hpp"

namespace viscobar {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

// The same steps as a run: a break is passed by a few roundings of the time.
std::vector<double> breaks_in(const std::string& text, double end, double x = 0.0) {
  const Formula formula(text, "xt");
  const NextBreak breaks = formula.breaks();
  const NextBreakAt breaks_at = formula.breaks_at();
  std::vector<double> found;
  for (double t = 64 * eps * end;;) {
    std::optional<double> next;
    if (breaks) next = breaks(t, end);
    if (breaks_at)
      if (const auto here = breaks_at(x, t, end); here && (!next || *here < *next)) next = here;
    if (!next || found.size() > 1000) return found;
    found.push_back(*next);
    t = *next + 64 * eps * end;
  }
}

void expect_breaks(const std::string& text, double end, const std::vector<double>& expected, double x = 0.0) {
  const std::vector<double> found = breaks_in(text, end, x);
  ASSERT_EQ(found.size(), expected.size()) << text;
  for (std::size_t k = 0; k < expected.size(); ++k)
    EXPECT_NEAR(found[k], expected[k], 4 * eps * end) << text << ", break " << k;
}

TEST(FormulaSwitches, AreWhereAnArgumentChangesSign) {
  expect_breaks("5.794*((t>1.8226)*(t<1.89)-(t>1.89)*(t<1.9574))", 4.0, {1.8226, 1.89, 1.9574});
  expect_breaks("t <= 0.5 ? 1 : t >= 2 ? 3 : -t", 4.0, {0.5, 2.0});
  expect_breaks("2*t - 1 < 4 - 3*t", 4.0, {1.0});
  expect_breaks("t == 1 || t != 3", 4.0, {1.0, 3.0});
  expect_breaks("t > 1 && t < 1.0000000001 ? 1e9 : 0", 4.0, {1.0, 1.0000000001});
  expect_breaks("abs(t - 0.7)", 4.0, {0.7});
  expect_breaks("min(t, 1, 3 - t)", 4.0, {1.0, 2.0});
  expect_breaks("max(t, 2*t - 1)^2", 4.0, {1.0});
  expect_breaks("t^2 > 2", 4.0, {std::numbers::sqrt2});
  expect_breaks("exp(-t) < 0.125", 4.0, {3 * std::numbers::ln2});
  expect_breaks("log(t + 1) > 1", 4.0, {std::numbers::e - 1});
  expect_breaks("sqrt(t) > 1.5", 4.0, {2.25});
  expect_breaks("tan(t) > 1 && t < 1.5", 1.55, {std::numbers::pi / 4, 1.5});
  expect_breaks("(t + 1)^2.5 > 32", 4.0, {3.0});
  expect_breaks("2^t >= 8", 4.0, {3.0});
  expect_breaks("abs((t > 1)*(t - 2))", 4.0, {1.0, 2.0});
  expect_breaks("1/(1 + t) < 0.5", 4.0, {1.0});
}

TEST(FormulaSwitches, OfASmoothFormulaAreNone) {
  for (const char* text : {"1", "t", "sin(40*t)*cos(3*x)", "exp(-400*(t-1.6)^2)", "x < 0.5 ? t : t^2", "abs(x)*t"}) {
    EXPECT_FALSE(Formula(text, "xt").breaks()) << text;
    EXPECT_FALSE(Formula(text, "xt").breaks_at()) << text;
  }
}

TEST(FormulaSwitches, AreNoneWhereAnArgumentKeepsItsSignOrItsBranchIsNotTaken) {
  expect_breaks("(t - 1)^2 > -1e-9", 4.0, {});
  expect_breaks("abs(t^2 - 2*t + 1.000001)", 4.0, {});
  expect_breaks("sin(t) > 1.5", 4.0, {});
  expect_breaks("t < 2 ? 0 : abs(sin(10*t))", 2.5, {2.0, 0.7 * std::numbers::pi});
  expect_breaks("t < 2 ? sqrt(2 - t) : max(sqrt(t - 2), 0.5)", 4.0, {2.0, 2.25});
}

TEST(FormulaSwitches, OfASquareWaveComeOneByOneHoweverMany) {
  std::vector<double> expected;
  for (int k = 1; k < 13; ++k) expected.push_back(k * std::numbers::pi / 10);
  expect_breaks("sin(10*t) > 0 ? 1 : -1", 4.0, expected);
  // A hundred million periods: the next one is found as fast.
  const NextBreak breaks = Formula("cos(2e5*pi*t) > 0", "t").breaks();
  for (double t = 700.00001; t < 700.0001;) {
    const auto next = breaks(t, 1000.0);
    ASSERT_TRUE(next.has_value());
    const double k = std::round(*next * 2e5 - 0.5);
    EXPECT_NEAR(*next, (k + 0.5) / 2e5, 4 * eps * 700);
    EXPECT_LT(*next - t, 1.0 / 2e5);
    t = *next + 1e-9;
  }
}

TEST(FormulaSwitches, OfAFrontDependOnThePlace) {
  const std::string front = "x < 0.25*t ? 1 : 0";
  EXPECT_FALSE(Formula(front, "xt").breaks());
  expect_breaks(front, 4.0, {2.0}, 0.5);
  expect_breaks(front, 4.0, {}, 1.5);
  expect_breaks("abs(x - 0.5 - 0.3*sin(t))", 6.0, {std::asin(0.5), std::numbers::pi - std::asin(0.5)}, 0.65);
  expect_breaks("(t > 1)*(x < t)", 4.0, {1.0, 3.0}, 3.0);
}

// Two roots closer than any sampling of the run would see.
TEST(FormulaSwitches, MissNoShortPulseOfANonlinearArgument) {
  for (const double width : {1e-3, 1e-5, 1e-7}) {
    const double level = std::cos(width / 2), half = std::acos(level);
    char text[80];
    std::snprintf(text, sizeof text, "cos(t - 1.2345678) > %.17g", level);
    const std::vector<double> found = breaks_in(text, 4.0);
    ASSERT_EQ(found.size(), 2u) << width;
    // A rounding of the cosine over its slope, half a width.
    EXPECT_NEAR(found[0], 1.2345678 - half, 4 * eps / width);
    EXPECT_NEAR(found[1], 1.2345678 + half, 4 * eps / width);
  }
}

// A wave that travels is somewhere all the time, and goes on changing as fast: no step misses it. One that is gone
// before a step ends is a pulse, and so is one at a spot.
TEST(FormulaDetail, AWaveThatTravelsIsNoPulse) {
  const auto places = [](const std::string& text, double until) {
    const NextBreak next = Formula(text, "xt").breaks_and_pulses(1.0);
    std::vector<double> all;
    for (auto at = next(0.0, until); at; at = next(*at, until)) all.push_back(*at);
    return all;
  };
  const auto within = [](const std::vector<double>& all, double begin, double end) {
    return std::ranges::count_if(all, [=](double at) { return at > begin && at < end; });
  };
  for (const double until : {1.5, 2.687, 10.0, 30.0})
    EXPECT_LT(places("3*exp(-((x-1.25*t)/0.08)^2)", until).size(), 100U) << until;
  for (const char* text : {"exp(-((x-1000*(t-1))/0.08)^2)", "exp(-((x-0.3)/0.02)^2-((t-1)/0.0005)^2)",
                           "sin(6*x)*exp(-((t-1)/0.0005)^2)"}) {
    const std::vector<double> all = places(text, 3.0);
    EXPECT_GE(within(all, 0.995, 1.005), 4) << text;
    EXPECT_LT(all.size(), 100U) << text;
  }
}

TEST(FormulaSwitches, EndTheirSearchWhereNothingCanBeProven) {
  EXPECT_LT(breaks_in("abs(sin(t) - sin(t))", 1e3).size(), 10u);
  EXPECT_LT(breaks_in("exp(t) - exp(t) > 0", 1.0).size(), 10u);
}

// Bounds of a single x and t are the formula's value, so that a root of theirs is a jump of it.
TEST(FormulaSwitches, AreThoseOfTheFormulaThatIsEvaluated) {
  std::mt19937 random(1);
  const auto pick = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  const std::function<std::string(int)> any = [&](int depth) -> std::string {
    if (depth == 0) {
      const char* leaves[] = {"x", "t", "pi", "2", "0.5", "1e-1", ".25", "3."};
      return leaves[pick(8)];
    }
    const char* unary[] = {"sin(", "cos(", "tan(", "exp(", "log(", "sqrt(", "abs(", "-(", "("};
    const char* binary[] = {"+", "-", "*", "/", "^", "<", "<=", ">", ">=", "==", "!="};
    switch (pick(6)) {
      case 0: return unary[pick(9)] + any(depth - 1) + ")";
      case 1: return any(depth - 1) + " ? " + any(depth - 1) + " : " + any(depth - 1);
      case 2: return std::string(pick(2) ? "min(" : "max(") + any(depth - 1) + "," + any(depth - 1) + ")";
      case 3: return "-" + any(depth - 1);
      case 4: return any(depth - 1) + (pick(2) ? " && " : "||") + any(depth - 1);
      default: return any(depth - 1) + binary[pick(11)] + any(depth - 1);
    }
  };
  int compared = 0;
  for (int i = 0; i < 3000; ++i) {
    const std::string text = any(1 + pick(4));
    std::optional<SpaceTimeFunction> f;
    try {
      f = Formula(text, "xt").of_x_t();
    } catch (const FormulaError&) {
      continue;  // a constant that is not finite
    }
    const FormulaTree tree = parse_formula(text);
    for (const auto& [x, t] : {std::pair{0.3, 0.7}, {1.7, 0.2}, {0.9, 2.6}}) {
      const double expected = (*f)(x, t);
      if (!std::isfinite(expected) || std::abs(expected) > 1e6) continue;
      const Interval value = tree.at(Jet({x, x}, {0.0, 0.0}), Jet({t, t}, {1.0, 1.0}), FormulaTree::bound).value;
      // The tree does not know of infinities and NaN on the way, and rounding may decide a comparison.
      if (value.low != value.high) continue;
      EXPECT_NEAR(value.low, expected, 1e-9 * std::max(1.0, std::abs(expected))) << text << " at " << x << ", " << t;
      ++compared;
    }
  }
  EXPECT_GT(compared, 3000);
}

}  // namespace
}  // namespace viscobar
