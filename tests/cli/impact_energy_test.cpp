// Energy that the impacts of a scheme give where nothing works, as a run tells it.
#include <gtest/gtest.h>

#include <string>

#include "cli/command.hpp"

namespace viscobar::testing_cli {
namespace {

using Json = nlohmann::json;

struct Rebound {
  const char *restitution, *step;
};

class ImpactEnergy : public Command, public testing::WithParamInterface<Rebound> {
 protected:
  Json of(const std::string& more) const {
    const Ended ended = viscobar(
        "run " + scene("chatter") + " --json --set method.name=fully_discrete --set bar.viscosity=0 --set time.end=20" +
        " --set 'initial.velocity=-x*(1-x)-0.5' --set contact.restitution=" + GetParam().restitution +
        " --set method.step=" + GetParam().step + more);
    EXPECT_EQ(ended.code, 0) << ended.error;
    return ended.code == 0 ? ended.json() : Json::object();
  }

  static std::string energy_warning(const Json& summary) {
    for (const std::string warning : summary["warnings"])
      if (warning.starts_with("energy: ")) return warning;
    return "";
  }
};

TEST_P(ImpactEnergy, IsWarnedOfWithItsSizeItsTimeAndWhatHelps) {
  const Json summary = of("");
  const Json& energy = summary["energy"];
  ASSERT_GT(energy["final"].get<double>(), 1.01 * energy["initial"].get<double>()) << "the scene shows nothing";
  const std::string warning = energy_warning(summary);
  for (const char* part : {"gave the bar", "up to t = ", "method.step", "method.impact = \"moreau\""})
    EXPECT_NE(warning.find(part), std::string::npos) << warning;
  // Told is the most of the whole run, which is no less than what is left at the end, to the three digits told.
  const double told = std::stod(warning.substr(warning.find("gave the bar ") + 13));
  EXPECT_GE(told * 1.005, -energy["dissipated"].get<double>()) << warning;
}

TEST_P(ImpactEnergy, IsNoneByMoreausImpact) {
  const Json summary = of(" --set method.impact=moreau");
  EXPECT_EQ(energy_warning(summary), "");
  const double initial = summary["energy"]["initial"], final = summary["energy"]["final"];
  // 20000 steps at most, 100 roundings each.
  EXPECT_LE(final, initial * (1 + 20000 * 100 * 2.3e-16));
  if (GetParam().restitution == std::string("1")) {
    EXPECT_GE(final, initial * (1 - 20000 * 100 * 2.3e-16));
  }
}

INSTANTIATE_TEST_SUITE_P(Rebounds, ImpactEnergy,
                         testing::Values(Rebound{"1", "0.1"}, Rebound{"0.5", "0.1"}, Rebound{"1", "1e-3"}),
                         [](const auto& rebound) { return "case_" + std::to_string(rebound.index); });

}  // namespace
}  // namespace viscobar::testing_cli
