// Cases that begin where a neighbour ended: who is whose neighbour, and that rows do not depend on who runs them.
#include "sweep/neighbours.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "support/scratch.hpp"
#include "sweep/sweep_results.hpp"
#include "sweep/sweep_workers.hpp"

namespace viscobar {
namespace {

SweepPlan plan(std::vector<VariedKey> keys) { return {std::move(keys), Combine::grid, {}, true}; }

std::vector<double> numbers(std::size_t count) {
  std::vector<double> list;
  for (std::size_t k = 0; k < count; ++k) list.push_back(0.01 * static_cast<double>(k + 1));
  return list;
}

std::size_t searching_alone(const SweepPlan& sweep) {
  return static_cast<std::size_t>(
      std::ranges::count_if(neighbours(sweep), [](const auto& of) { return !of.has_value(); }));
}

TEST(Neighbours, AreTheMiddleOnesOfEightCases) {
  const auto of = neighbours(plan({{"left.gap", numbers(130)}}));
  ASSERT_EQ(of.size(), 130u);
  for (std::size_t i = 0; i < 128; ++i) EXPECT_EQ(of[i], i % 8 == 4 ? std::nullopt : std::optional(i / 8 * 8 + 4)) << i;
  EXPECT_EQ(of[128], 129u);
  EXPECT_FALSE(of[129]);
}

TEST(Neighbours, OfASmallSweepAreFewerSoThatSixteenCasesAtLeastSearchByThemselves) {
  for (const std::size_t cases : {1u, 16u, 31u, 32u, 63u, 64u, 100u}) {
    const std::size_t alone = searching_alone(plan({{"left.gap", numbers(cases)}}));
    EXPECT_GE(alone, std::min<std::size_t>(cases, 16)) << cases;
    EXPECT_EQ(alone < cases, cases >= 32) << cases;
  }
}

TEST(Neighbours, HaveTheSameTextsAndAskForTheSameError) {
  const SweepPlan sweep = plan({{"left.gap", numbers(32)},
                                {"method.name", std::vector<std::string>{"rigid", "fully_discrete"}},
                                {"accuracy.error", std::vector<double>{1e-3, 1e-6}}});
  const auto of = neighbours(sweep);
  std::size_t found = 0;
  for (std::size_t i = 0; i < of.size(); ++i)
    if (of[i]) {
      ++found;
      const std::vector<std::size_t> one = sweep.choice(i), other = sweep.choice(*of[i]);
      EXPECT_EQ(one[1], other[1]);
      EXPECT_EQ(one[2], other[2]);
      EXPECT_FALSE(of[*of[i]]) << "nobody waits for more than one";
    }
  EXPECT_EQ(found, 112u);
}

TEST(Neighbours, AreThereOnlyWhereAnErrorIsAskedFor) {
  SweepPlan sweep = plan({{"left.gap", numbers(128)}});
  sweep.accuracy = false;
  EXPECT_EQ(searching_alone(sweep), 128u);
}

constexpr const char* scene_text =
    "[bar]\nlength=1\n[left]\nkind=\"obstacle\"\n[initial]\nvelocity=-1\n[time]\nend=1.5\n[accuracy]\nerror=1e-6\n";

SweepFile sweep_of(const std::vector<double>& viscosities, const std::vector<double>& gaps,
                   std::vector<Setting> settings = {}) {
  SweepFile sweep;
  sweep.scene_text = scene_text;
  sweep.settings = std::move(settings);
  sweep.plan.keys = {{"bar.viscosity", viscosities}, {"left.gap", gaps}};
  heed_scene(sweep);
  return sweep;
}

std::vector<double> gaps() {
  std::vector<double> list = numbers(16);
  for (double& gap : list) gap *= 2.0;
  return list;
}

SweepRow failed(std::size_t index) {
  SweepRow row;
  row.index = index;
  row.error = "it failed";
  row.chosen = {640.0, 1e-9, NAN, NAN, NAN};
  return row;
}

SweepRow kept(std::size_t index) {
  SweepRow row = failed(index);
  row.error.clear();
  row.completed = true;
  return row;
}

TEST(SweepQueue, HandsOutWhoWaitsForNobodyAndThenWhoseNeighbourIsDone) {
  const SweepFile sweep = sweep_of({0.1, 0.2}, gaps());  // two together, the second one alone
  std::vector<double> costs(32, 1.0);
  costs[6] = 3.0;
  SweepQueue queue(sweep, costs);
  for (std::size_t i = 1; i < 32; i += 2) EXPECT_EQ(queue.take()->index, i);
  EXPECT_EQ(queue.size(), 16u);
  EXPECT_FALSE(queue.take());
  queue.finish(kept(3));
  queue.finish(failed(7));
  const std::optional<SweepCase> dear = queue.take(), cheap = queue.take();
  EXPECT_EQ(dear->index, 6u) << "the dearest of the two";
  EXPECT_FALSE(dear->neighbour) << "whose neighbour failed, searches by itself";
  EXPECT_EQ(cheap->index, 2u);
  ASSERT_TRUE(cheap->neighbour);
  EXPECT_EQ(cheap->neighbour->index, 3u);
  EXPECT_EQ(cheap->neighbour->start.elements, 640u);
  EXPECT_EQ(cheap->neighbour->start.tolerance, 1e-9);
  EXPECT_FALSE(cheap->neighbour->start.epsilon);
  EXPECT_FALSE(queue.take());
}

std::vector<SweepRow> all_rows(const SweepFile& sweep, std::size_t threads,
                               std::span<const SweepRow* const> before = {}) {
  std::vector<SweepRow> rows(sweep.plan.size());
  for (const SweepRow* row : before) rows[row->index] = *row;
  const std::vector<double> costs(rows.size(), 1.0);
  SweepQueue queue(sweep, costs, before);
  EXPECT_TRUE(run_on_threads(
      {sweep.scene_text, queue, [&](const SweepRow& row) { rows[row.index] = row; }, [] {}, [] { return false; }},
      threads));
  return rows;
}

// The text of all rows, without the timings: those depend on the machine.
std::string told(const SweepFile& sweep, const std::vector<SweepRow>& rows) {
  std::vector<const SweepRow*> pointers;
  for (const SweepRow& row : rows) pointers.push_back(&row);
  return csv_of(sweep_columns(sweep.plan), pointers);
}

constexpr std::size_t chosen_elements = quantities, neighbour = quantities + 4;

TEST(CasesThatBeginAtANeighbour, HaveTheSameRowsFromAnyNumberOfThreadsAndAfterAnInterruption) {
  const SweepFile sweep = sweep_of({0.3, 0.1, 0.03, 0.01}, gaps());
  const std::vector<SweepRow> rows = all_rows(sweep, 1);
  const std::string whole = told(sweep, rows);
  std::size_t begun = 0;
  for (const SweepRow& row : rows) {
    EXPECT_TRUE(row.completed) << row.error;
    begun += std::isnan(row.column(neighbour)) ? 0 : 1;
  }
  EXPECT_EQ(begun, 48u);
  EXPECT_EQ(told(sweep, all_rows(sweep, 2)), whole);
  EXPECT_EQ(told(sweep, all_rows(sweep, 5)), whole);
  // Some rows were in the file already: of neighbours, of those that wait for them, and of both.
  for (const std::size_t every : {2, 3, 5}) {
    const Scratch scratch;
    {
      SweepResults results(scratch / "out", sweep);
      for (std::size_t i = 0; i < rows.size(); i += every) results.add(rows[i]);
      results.close(scratch / "out");
    }
    const SweepResults results(scratch / "out", sweep);
    EXPECT_EQ(told(sweep, all_rows(sweep, 2, results.rows())), whole) << every;
  }
}

TEST(CasesThatBeginAtANeighbour, TakeAboutTheMeshesThatTheyWouldTakeByThemselves) {
  const SweepFile sweep = sweep_of({1.0, 0.1, 0.01}, gaps());
  for (const SweepRow& row : all_rows(sweep, 2)) {
    const SweepRow alone = run_case(sweep.scene_text, case_of(sweep, row.index)).value();
    EXPECT_LE(row.column(chosen_elements), 1.5 * alone.column(chosen_elements)) << row.index;
    EXPECT_GE(1.5 * row.column(chosen_elements), alone.column(chosen_elements)) << row.index;
  }
}

// Without viscosity there is no mesh, and a neighbour on characteristics has none to tell.
TEST(CasesThatBeginAtANeighbour, AreNoneWhereTheNeighbourHasNoMeshOrDoesNotKeepItsError) {
  const SweepFile waves = sweep_of({0.1, 0.0}, gaps(), {"accuracy.error=1e-4"});
  SweepFile swapped = waves;  // a bar without viscosity is the neighbour of one with
  std::swap(swapped.plan.keys[0], swapped.plan.keys[1]);
  for (const SweepRow& row : all_rows(swapped, 2)) {
    EXPECT_TRUE(row.completed) << row.error;
    EXPECT_TRUE(std::isnan(row.column(neighbour)));
    EXPECT_EQ(std::isnan(row.column(chosen_elements)), row.index % 2 == 1);
  }
  for (const SweepRow& row : all_rows(sweep_of({0.1, 0.2}, gaps(), {"mesh.elements=12"}), 2)) {
    EXPECT_FALSE(row.completed);
    EXPECT_TRUE(std::isnan(row.column(neighbour)));
    EXPECT_EQ(row.column(chosen_elements), 12.0);
  }
}

}  // namespace
}  // namespace viscobar
