#include "viscobar/sweep/sweep.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <set>

#include "case/run_cost.hpp"
#include "input/described_scene.hpp"

namespace viscobar {
namespace {

using Strings = std::vector<std::string>;

SweepPlan plan(Combine combine) {
  return {{{"bar.viscosity", std::vector<double>{1.0, 0.1}},
           {"mesh.elements", std::vector<std::int64_t>{9, 18}},
           {"mesh.mass", Strings{"lumped", "paper"}}},
          combine};
}

Strings texts(const std::vector<Setting>& settings) {
  Strings all;
  for (const Setting& setting : settings) all.push_back(text_of(setting));
  return all;
}

TEST(SweepPlan, AGridTakesEveryCombinationOnceTheLastKeyFastest) {
  const SweepPlan grid = plan(Combine::grid);
  ASSERT_EQ(grid.size(), 8u);
  EXPECT_EQ(texts(grid.settings(0)), (Strings{"bar.viscosity=1.0", "mesh.elements=9", "mesh.mass=\"lumped\""}));
  EXPECT_EQ(texts(grid.settings(1)), (Strings{"bar.viscosity=1.0", "mesh.elements=9", "mesh.mass=\"paper\""}));
  EXPECT_EQ(texts(grid.settings(2)), (Strings{"bar.viscosity=1.0", "mesh.elements=18", "mesh.mass=\"lumped\""}));
  EXPECT_EQ(texts(grid.settings(7)), (Strings{"bar.viscosity=0.1", "mesh.elements=18", "mesh.mass=\"paper\""}));
  std::set<std::vector<std::size_t>> all;
  for (std::size_t i = 0; i < grid.size(); ++i) all.insert(grid.choice(i));
  EXPECT_EQ(all.size(), 8u);
}

TEST(SweepPlan, AZipTakesTheKthValuesTogether) {
  const SweepPlan zip = plan(Combine::zip);
  ASSERT_EQ(zip.size(), 2u);
  EXPECT_EQ(texts(zip.settings(1)), (Strings{"bar.viscosity=0.1", "mesh.elements=18", "mesh.mass=\"paper\""}));
}

TEST(SweepPlan, NumbersReachTheSceneToTheLastBit) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> exponent(-99.0, 99.0);
  std::vector<double> values = {1.0, 3.0, 1e22, 1.0 / 3.0, std::nextafter(1.0, 2.0)};
  for (int k = 0; k < 1000; ++k) values.push_back(std::pow(10.0, exponent(random)));
  const SweepPlan one{{{"bar.length", values}}, Combine::grid};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string text = text_of(one.settings(i).front());
    EXPECT_EQ(std::stod(text.substr(text.find('=') + 1)), values[i]) << text;
    EXPECT_NE(text.find_first_of(".e", text.find('=')), text.npos) << text << " would be a whole number";
  }
}

TEST(DispatchOrder, BeginsWithTheMostExpensiveAndKeepsTheOrderOfEquals) {
  EXPECT_EQ(dispatch_order(std::vector{1.0, 3.0, 2.0, 3.0, 1.0}), (std::vector<std::size_t>{1, 3, 2, 0, 4}));
  EXPECT_TRUE(dispatch_order({}).empty());
}

Case bar(MethodName method) {
  Case run;
  run.scene.bar = {1.0, 1.0, 1.0, 0.01};
  run.scene.left = Obstacle{0.1};
  run.scene.displacement = [](double x) { return x * (1.0 - x); };
  run.scene.velocity = [](double x) { return -x * (1.0 - x); };
  run.elements = 27;
  run.epsilon = 1e-4;
  run.step = 1e-3;
  run.end = 6.0;
  run.method = method;
  return run;
}

TEST(CostEstimate, OfASchemeIsProportionalToStepsAndToNodes) {
  Case coarse = bar(MethodName::fully_discrete), fine = coarse, large = coarse;
  coarse.elements = fine.elements = 20000;
  large.elements = 40000;
  fine.step = 5e-4;
  const double one = estimated_seconds(resolve(coarse));
  // The parts that do not double, the start and the cost of a step without nodes, are below 1 % here.
  EXPECT_NEAR(estimated_seconds(resolve(fine)) / one, 2.0, 0.02);
  EXPECT_NEAR(estimated_seconds(resolve(large)) / one, 2.0, 0.02);
}

TEST(CostEstimate, GrowsWithTheMeshTheTimeTheToleranceAndTheChatter) {
  for (const MethodName method : {MethodName::cvode, MethodName::ida, MethodName::rigid}) {
    const double one = estimated_seconds(resolve(bar(method)));
    const auto changed = [&](const auto& change) {
      Case other = bar(method);
      change(other);
      return estimated_seconds(resolve(other));
    };
    EXPECT_GT(changed([](Case& run) { run.elements = 1080; }), one) << name(method);
    EXPECT_GT(changed([](Case& run) { run.end = 60.0; }), one) << name(method);
    EXPECT_GT(changed([](Case& run) { run.tolerance.relative = 1e-10; }), one) << name(method);
    if (method != MethodName::rigid) {
      EXPECT_GT(changed([](Case& run) { run.epsilon = 1e-8, run.mass = Mass::consistent; }), one) << name(method);
    }
  }
}

}  // namespace
}  // namespace viscobar
