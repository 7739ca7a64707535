// Derivatives in the rows of a sweep.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "input/described_scene.hpp"
#include "support/bar_above_an_obstacle.hpp"
#include "support/scratch.hpp"
#include "sweep/sweep_results.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar {
namespace {

const std::string without_sensitivities = std::string(bar_above_an_obstacle) + "[initial]\nvelocity = -1.0\n";
const std::string scene_text = without_sensitivities + "[sensitivity]\nof = [\"left.gap\", \"bar.viscosity\"]\n";

// The third bar ends before it comes to the obstacle.
constexpr const char* sweep_text = R"(
scene = "scene.toml"
combine = "zip"
[vary]
left.gap = [0.1, 0.2, 0.3]
time.end = [3.0, 2.5, 0.25]
)";

TEST(SensitivitiesInSweeps, AreThoseOfEachRunAndSurviveTheFile) {
  const Scratch scratch;
  std::ofstream(scratch / "scene.toml") << scene_text;
  const SweepFile sweep = parse_sweep(sweep_text, scratch / "sweep.toml");
  ASSERT_EQ(sweep.plan.sensitivities, (std::vector<std::string>{"left.gap", "bar.viscosity"}));
  ASSERT_EQ(sweep.plan.columns().size(), quantities + 10);
  std::vector<SweepRow> rows;
  for (std::size_t i = 0; i < sweep.plan.size(); ++i) {
    rows.push_back(run_case(sweep.scene_text, case_of(sweep, i)).value());
    ASSERT_TRUE(rows[i].completed) << rows[i].error;
    const Recording run = record(parse_scene_with(scene_text, "scene", case_of(sweep, i).settings).run);
    const SensitivityAccount& told = *run.statistics.sensitivity;
    ASSERT_EQ(rows[i].values.size(), quantities + 10);
    for (const std::size_t k : {0, 1}) {
      const double* derivatives = rows[i].values.data() + quantities + 5 * k;
      EXPECT_EQ(derivatives[0], told.impulse_left[k]);
      EXPECT_TRUE(std::isnan(derivatives[1]) && std::isnan(told.impulse_right[k])) << "without an obstacle there";
      EXPECT_EQ(derivatives[2], told.energy[k]);
      for (const std::size_t change : {0, 1}) {
        if (run.events.empty())
          EXPECT_TRUE(std::isnan(derivatives[3 + change]));
        else
          EXPECT_EQ(derivatives[3 + change], run.events.at(change).sensitivities[k].time);
      }
    }
  }
  EXPECT_NEAR(rows[0].column(quantities + 3), 1.0, 1e-9) << "it flies at speed 1";
  EXPECT_TRUE(std::isnan(rows[2].column(quantities + 3)));

  std::filesystem::create_directory(scratch / "out");
  {
    SweepResults results(scratch / "out", sweep);
    for (const SweepRow& row : rows) results.add(row);
    results.close(scratch / "out");
  }
  SweepResults again(scratch / "out", sweep);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ASSERT_TRUE(again.has(i));
    const SweepRow& row = *again.rows()[i];
    for (std::size_t k = 0; k < quantities + 10; ++k)
      EXPECT_TRUE(row.column(k) == rows[i].column(k) || (std::isnan(row.column(k)) && std::isnan(rows[i].column(k))))
          << k;
  }
  std::istringstream csv(read_text(scratch / "out/sweep.csv"));
  std::string line;
  std::getline(csv, line);
  EXPECT_TRUE(line.ends_with("energy_final/bar.viscosity,first_closing/bar.viscosity,first_opening/bar.viscosity"))
      << line;
}

TEST(SensitivitiesInSweeps, CostNothingWhereTheSceneAsksForNone) {
  const Scratch scratch;
  std::ofstream(scratch / "scene.toml") << without_sensitivities;
  const SweepFile sweep = parse_sweep(sweep_text, scratch / "sweep.toml");
  EXPECT_EQ(sweep.plan.columns().size(), quantities);
  EXPECT_EQ(run_case(sweep.scene_text, case_of(sweep, 0))->values.size(), quantities);
}

}  // namespace
}  // namespace viscobar
