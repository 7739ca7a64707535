// Sweeps whose cases are bars of an ensemble: [ensemble] in the sweep file.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <numeric>

#include "input/described_scene.hpp"
#include "support/scratch.hpp"
#include "sweep/sweep_workers.hpp"
#include "viscobar/studies/ensemble/ensemble.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar {
namespace {

const std::string viscosities_and_gaps =
    "[vary]\nbar.viscosity = { from = 0.05, to = 0.5, count = 7 }\nleft.gap = { from = 0.05, to = 0.2, count = 5 }\n";

SweepFile sweep_of(const std::string& rest, const std::vector<std::string>& overrides = {}) {
  const Scratch scratch;
  std::ofstream(scratch / "scene.toml")
      << "bar.length = 1.0\nbar.viscosity = 0.1\nleft.kind = \"obstacle\"\nleft.gap = 0.1\ninitial.velocity = -1\n"
         "time.end = 3\nmesh.elements = 12\n";
  return parse_sweep("scene = \"scene.toml\"\n" + rest, scratch / "sweep.toml", overrides);
}

std::vector<SweepRow> rows_of(const SweepFile& sweep, std::size_t threads) {
  const std::vector<double> costs = plan_cases(sweep, 1);
  SweepQueue queue(sweep, costs);
  std::vector<SweepRow> rows;
  const SweepWork work{sweep, queue, [&](const SweepRow& row) { rows.push_back(row); }, [] {}, [] { return false; }};
  run_on_threads(work, threads);
  std::ranges::sort(rows, {}, &SweepRow::index);
  return rows;
}

// NaN is equal to itself.
std::vector<std::uint64_t> bits(const std::vector<double>& values) {
  std::vector<std::uint64_t> all;
  for (const double value : values) all.push_back(std::bit_cast<std::uint64_t>(value));
  return all;
}

TEST(SweepOfBars, HasTheNumbersOfTheEnsembleToTheBit) {
  const SweepFile sweep =
      sweep_of(viscosities_and_gaps + "[ensemble]\noutputs = [\"impulse_left\", \"u_right@1.5\"]\nerror = 1e-2\n");
  const std::vector<SweepRow> rows = rows_of(sweep, 1);
  ASSERT_EQ(rows.size(), 35u);
  std::vector<double> viscosity, gap;
  for (int i = 0; i < 7; ++i)
    for (int j = 0; j < 5; ++j) {
      viscosity.push_back(std::get<std::vector<double>>(sweep.plan.keys[0].values)[i]);
      gap.push_back(std::get<std::vector<double>>(sweep.plan.keys[1].values)[j]);
    }
  EnsembleStudy study;
  study.keys = {"bar.viscosity", "left.gap"};
  study.values = {viscosity, gap};
  study.outputs = {"impulse_left", "u_right@1.5"};
  study.error = 1e-2;
  study.model = [&](std::span<const double> at) {
    const std::vector<Setting> settings = {std::pair(study.keys[0], SceneValue(at[0])),
                                           std::pair(study.keys[1], SceneValue(at[1]))};
    return parse_scene_with(sweep.scene_text, "", settings).run;
  };
  const EnsembleResult bars = ensemble(study);
  std::vector<std::string> names;
  for (const QuantityColumn& column : sweep.plan.columns()) names.push_back(column.name);
  EXPECT_EQ(names, (std::vector<std::string>{"impulse_left", "u_right(0)", "u_right(1.5)", "u_right(3)", "steps",
                                             "side_by_side", "estimate"}));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_TRUE(rows[i].completed) << rows[i].error;
    EXPECT_EQ(rows[i].column(5), 1.0);
    EXPECT_EQ(bits(rows[i].values),
              bits({bars.values[0][i], bars.values[1][3 * i], bars.values[1][3 * i + 1], bars.values[1][3 * i + 2],
                    static_cast<double>(bars.steps[i]), 1.0, bars.error[i]}))
        << i;
  }
}

TEST(SweepOfBars, HasTheSameRowsWhicheverRunTogether) {
  // The first case alone says that ends side by side have no mass, and not the first of a batch.
  const std::string ends =
      "[set]\nmesh.mass = \"redistributed\"\n[vary]\nleft.mass = [0.0, 0.5, 0.3, 0.0, 0.4]\nleft.gap = [0.1, 0.15, 0.2]\n";
  SweepFile sweep = sweep_of(ends + "[ensemble]\noutputs = [\"final\", \"peak_left\"]\nerror = 1e-2\n");
  const std::vector<SweepRow> at_once = rows_of(sweep, 1), of_threads = rows_of(sweep, 3);
  sweep.ensemble.batch = 2;
  const std::vector<SweepRow> by_two = rows_of(sweep, 1);
  ASSERT_EQ(at_once.size(), 15u);
  for (const auto* other : {&of_threads, &by_two}) {
    ASSERT_EQ(other->size(), 15u);
    for (std::size_t i = 0; i < 15; ++i) EXPECT_EQ(bits((*other)[i].values), bits(at_once[i].values)) << i;
  }
}

TEST(SweepOfBars, WithoutAnErrorAgreesWithTheRunsOfItsMethod) {
  const std::string method = "[set]\nmethod.name = \"fully_discrete\"\nmethod.step = 0.01\n";
  const SweepFile plain = sweep_of(method + viscosities_and_gaps),
                  bars = sweep_of(method + viscosities_and_gaps +
                                  "[ensemble]\noutputs = "
                                  "[\"impulse_left\", \"u_left@3\"]\n");
  const std::vector<SweepRow> one = rows_of(plain, 1), other = rows_of(bars, 1);
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(other[i].column(4), 1.0) << "side by side";
    // As Ensemble.LanesAreTheSchemeToRounding has it.
    EXPECT_NEAR(other[i].column(0), one[i][Quantity::impulse_left], 1e-10 * std::abs(one[i][Quantity::impulse_left]));
    EXPECT_NEAR(other[i].column(2), one[i][Quantity::u_left_final], 1e-10);
  }
}

TEST(SweepOfBars, ACaseThatCannotRunHasARowThatSaysWhy) {
  const SweepFile sweep = sweep_of(
      "[set]\ninitial.displacement = -0.08\n[vary]\nbar.viscosity = [0.1, 0.2]\nleft.gap = [0.1, 0.05]\n[ensemble]\noutputs = "
      "[\"impulse_left\"]\nerror = 1e-2\n");
  const std::vector<SweepRow> rows = rows_of(sweep, 2);
  ASSERT_EQ(rows.size(), 4u);
  for (const SweepRow& row : rows) {
    EXPECT_EQ(row.completed, row.index % 2 == 0) << row.error;
    EXPECT_EQ(row.error.find("penetrates the obstacle") != std::string::npos, row.index % 2 == 1) << row.error;
    EXPECT_EQ(std::isnan(row.column(0)), row.index % 2 == 1);
  }
}

TEST(SweepOfBars, AnInterruptLeavesWholeRows) {
  const SweepFile sweep = sweep_of(viscosities_and_gaps + "[ensemble]\noutputs = [\"impulse_left\"]\nerror = 1e-2\n");
  std::vector<std::size_t> all(35);
  std::iota(all.begin(), all.end(), std::size_t{0});
  EXPECT_TRUE(run_cases(sweep, all, [] { return true; }).empty());
  EXPECT_EQ(run_cases(sweep, all, [] { return false; }).size(), 35u);
}

TEST(SweepOfBars, AnotherErrorOrOutputIsAnotherSweep) {
  const auto identity = [](const std::string& rest) { return sweep_of(viscosities_and_gaps + rest).identity(); };
  const std::string all[] = {"", "[ensemble]\noutputs = [\"final\"]\n", "[ensemble]\noutputs = [\"events:2\"]\n",
                             "[ensemble]\noutputs = [\"final\"]\nerror = 1e-3\n",
                             "[ensemble]\noutputs = [\"final\"]\nerror = 1e-4\n"};
  for (const std::string& one : all)
    for (const std::string& other : all) EXPECT_EQ(identity(one) == identity(other), one == other) << one << other;
}

}  // namespace
}  // namespace viscobar
