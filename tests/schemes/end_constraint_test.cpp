#include "schemes/end_constraint.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace viscobar::testing_end_constraint {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

struct Problem {
  BandedMatrix matrix;
  std::vector<double> b, bound;
  std::vector<std::size_t> entries;
};

Problem random_problem(std::size_t n, std::size_t ends, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Problem problem;
  problem.matrix.diagonal.assign(n, 0.05);
  problem.matrix.off_diagonal.resize(n - 1);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double off = problem.matrix.off_diagonal[i] = uniform(random);
    problem.matrix.diagonal[i] += std::abs(off);
    problem.matrix.diagonal[i + 1] += std::abs(off);
  }
  for (std::size_t i = 0; i < n; ++i) problem.b.push_back(uniform(random));
  problem.entries = ends == 2 ? std::vector<std::size_t>{0, n - 1} : std::vector<std::size_t>{random() % 2 ? 0 : n - 1};
  for (std::size_t k = 0; k < ends; ++k) problem.bound.push_back(uniform(random));
  return problem;
}

// Every contact state by itself: the states that fit, to rounding.
int fitting_states(const Problem& problem, std::span<const unsigned char> state_found, double tolerance) {
  int fitting = 0;
  bool found = false;
  const std::size_t n = problem.matrix.size(), ends = problem.entries.size();
  for (unsigned state = 0; state < (1u << ends); ++state) {
    BandedMatrix held = problem.matrix;
    std::vector<double> x = problem.b, row(n);
    for (std::size_t k = 0; k < ends; ++k) {
      if (!(state >> k & 1)) continue;
      const std::size_t i = problem.entries[k];
      // A spring that is stiff beyond rounding holds the entry at its bound.
      held.diagonal[i] = 1e20;
      x[i] = 1e20 * problem.bound[k];
    }
    TridiagonalFactor(held).solve(x);
    problem.matrix.multiply(x, row);
    bool fits = true, same = true;
    for (std::size_t k = 0; k < ends; ++k) {
      const std::size_t i = problem.entries[k];
      const bool active = state >> k & 1;
      fits &= active ? row[i] - problem.b[i] >= -tolerance : x[i] >= problem.bound[k] - tolerance;
      same &= active == static_cast<bool>(state_found[k]);
    }
    fitting += fits;
    found |= fits && same;
  }
  return found ? fitting : 0;
}

TEST(EndConstraint, FindsTheOneContactStateOfAllThatFits) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 20000; ++trial) {
    const std::size_t ends = 1 + random() % 2, n = ends + random() % 5;
    const Problem problem = random_problem(n, ends, random);
    EndConstraint constraint(problem.matrix, {problem.entries.begin(), problem.entries.end()});
    std::vector<double> x = problem.b, multiplier(ends), row(n);
    constraint.solve(x, problem.bound, multiplier);
    double largest = 1.0;
    for (const double value : x) largest = std::max(largest, std::abs(value));
    const double condition = 5.0 / 0.05, rounding = 50 * condition * eps * largest;
    EXPECT_EQ(fitting_states(problem, constraint.active(), rounding), 1) << trial;

    problem.matrix.multiply(x, row);
    for (std::size_t k = 0; k < ends; ++k) row[problem.entries[k]] -= multiplier[k];
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(row[i], problem.b[i], rounding) << trial;
    for (std::size_t k = 0; k < ends; ++k) {
      EXPECT_GE(multiplier[k], 0.0);
      if (constraint.active()[k])
        EXPECT_EQ(x[problem.entries[k]], problem.bound[k]);
      else
        EXPECT_EQ(multiplier[k], 0.0);
    }
  }
}

TEST(EndConstraint, TiesAreHeldWithoutForceOrLeftOpen) {
  const BandedMatrix matrix{{2.0, 3.0, 2.0}, {-1.0, -1.0}};
  EndConstraint constraint(matrix, {0, 2});
  std::vector<double> multiplier(2), x{1.0, 1.0, 1.0};  // A (1, 1, 1) = (1, 1, 1)
  constraint.solve(x, std::vector<double>{1.0, 1.0}, multiplier);
  for (const double value : x) EXPECT_NEAR(value, 1.0, 4 * eps);
  for (const double lambda : multiplier) EXPECT_NEAR(lambda, 0.0, 8 * eps);
}

// An end held at its bound can press the other one off its obstacle or onto it: one is active although both, or
// neither of them alone, would be without the other.
TEST(EndConstraint, OneEndMayOpenOrCloseTheOther) {
  std::vector<double> multiplier(2);
  EndConstraint pushing({{2.0, 2.0}, {-1.0}}, {0, 1});  // A^{-1} = [2 1; 1 2] / 3
  std::vector<double> lifted{-3.0, -1.5};               // x = (-2.5, -2) before contact
  pushing.solve(lifted, std::vector<double>{0.0, -1.5}, multiplier);
  EXPECT_EQ(pushing.active()[0], 1);
  EXPECT_EQ(pushing.active()[1], 0);
  EndConstraint pulling({{2.0, 2.0}, {1.0}}, {0, 1});  // A^{-1} = [2 -1; -1 2] / 3
  std::vector<double> dragged{-3.0, 0.0};              // x = (-2, 1) before contact, (0, 0) with the first one held
  pulling.solve(dragged, std::vector<double>{0.0, 0.5}, multiplier);
  EXPECT_EQ(pulling.active()[0], 1);
  EXPECT_EQ(pulling.active()[1], 1);
}

}  // namespace
}  // namespace viscobar::testing_end_constraint
