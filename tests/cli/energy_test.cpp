// One run, one energy: its summary, its energy.csv and its row of a sweep tell the same.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "cli/command.hpp"

namespace viscobar::testing_cli {
namespace {

using Json = nlohmann::json;

class OneEnergy : public Command, public testing::WithParamInterface<const char*> {};

TEST_P(OneEnergy, IsToldByTheSummaryTheTableAndTheSweep) {
  const Ended ended = viscobar("run " + scene(GetParam()) + " -o out --json");
  ASSERT_EQ(ended.code, 0) << ended.error;
  const Json summary = ended.json(), energy = summary["energy"];
  std::ofstream(directory_ / "sweep.toml")
      << "scene = " << '"' << VISCOBAR_SOURCE_DIR "/examples/scenes/" << GetParam() << ".toml\"\n[vary]\ntime.end = ["
      << summary["reached_time"].dump() << "]\n";
  ASSERT_EQ(viscobar("sweep sweep.toml -o table").code, 0);
  const auto row = last_row(read_text(directory_ / "out" / "energy.csv"));
  const auto swept = last_row(read_text(directory_ / "table" / "sweep.csv"));
  // The table's last row is made by the same account as the summary, in another order of sums.
  const double initial = energy["initial"], work = energy["work"], dissipated = energy["dissipated"];
  const double rounding = 1e-14 * (initial + std::abs(work) + std::abs(dissipated));
  EXPECT_NEAR(std::stod(row.at("dissipated")), dissipated, rounding);
  EXPECT_NEAR(std::stod(row.at("work")), work, rounding);
  EXPECT_EQ(std::stod(swept.at("energy_dissipated")), dissipated);
  EXPECT_EQ(std::stod(swept.at("energy_work")), work);
  // Its balance is told beside it.
  const double balance = energy["balance_error"];
  EXPECT_NEAR(balance, energy["final"].get<double>() + dissipated - initial - work, rounding);
}

INSTANTIATE_TEST_SUITE_P(Scenes, OneEnergy,
                         testing::Values("chatter", "rebound", "impacting-bar", "driven-bar", "shaken-stop", "period-3",
                                         "rigid-flight", "steel-impact", "unit-both-ends", "unit-left-end-loaded"),
                         [](const auto& one) {
                           std::string name = one.param;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace viscobar::testing_cli
