// A run that fails, as its user meets it: exit 1, the reason with what to change, and files that are whole.
#include <cmath>
#include <sstream>

#include "cli/command.hpp"

namespace viscobar::testing_cli {
namespace {

class FailedRun : public Command, public testing::WithParamInterface<std::string> {
 protected:
  void expect_kept(const std::string& load, const std::string& reason, double time) const {
    const Ended ended = viscobar("run " + scene("chatter") +
                                 " --json -o out --set contact.epsilon=1e-3 --set time.end=1 --set output.every=0.01"
                                 " --set method.absolute_tolerance=1e-9 --set method.name=" +
                                 GetParam() + " --set 'load.density=\"" + load + "\"'");
    EXPECT_EQ(ended.code, 1) << load << ended.error;
    EXPECT_NE(ended.error.find(reason), std::string::npos) << ended.error;
    const nlohmann::json summary = ended.json();
    EXPECT_EQ(summary, nlohmann::json::parse(read_text(directory_ / "out/summary.json")));
    EXPECT_EQ(summary["completed"], false);
    EXPECT_EQ(summary["ending"], "failed");
    EXPECT_NE(summary["error"].get<std::string>().find(reason), std::string::npos) << summary["error"];
    const double reached = summary["reached_time"];
    EXPECT_NEAR(reached, time, 0.03) << load;
    EXPECT_FALSE(summary["rhs_evaluations"].is_null());

    // A row for each output time reached and one for the state reached, and whole lines only.
    std::istringstream ends(read_text(directory_ / "out/ends.csv"));
    std::size_t rows = 0;
    double last = -1.0;
    for (std::string line; std::getline(ends, line); ++rows) {
      EXPECT_EQ(std::count(line.begin(), line.end(), ','), 6) << line;
      if (rows > 0) last = std::stod(line);
    }
    EXPECT_EQ(last, reached);
    EXPECT_NEAR(static_cast<double>(rows), 2.0 + reached / 0.01, 1.0) << "with the header and t = 0";
    EXPECT_EQ(read_text(directory_ / "out/ends.csv").back(), '\n');
    EXPECT_EQ(read_text(directory_ / "out/events.csv").back(), '\n');
    const Ended info = viscobar("info out");
    EXPECT_EQ(info.code, 0) << info.error;
    ASSERT_EQ(viscobar("export out --format csv -o table").code, 0) << "the field is readable";
    EXPECT_NE(read_text(directory_ / "out/report.html").find("did not complete"), std::string::npos);
  }
};

TEST_P(FailedRun, OfALoadThatIsNoNumberKeepsWhatItReached) {
  expect_kept("sqrt(0.5-t)", "the history of the load at t = 0.5", 0.5);
  expect_kept("1/(t<0.5)", "is infinite", 0.5);
}

TEST_P(FailedRun, AtAPoleThatNoStepCanFollowKeepsWhatItReached) {
  expect_kept("1/(0.5-t)^2", "check the load for jumps", 0.5);
}

TEST_P(FailedRun, OfTheFirstStepKeepsTheStart) { expect_kept("1e308*t", "method.relative_tolerance", 0.0); }

INSTANTIATE_TEST_SUITE_P(EveryAdaptiveMethod, FailedRun, testing::Values("cvode", "ida", "arkode", "odeint"),
                         [](const auto& method) { return method.param; });

class LostInertia : public Command {};

// Beside 10^100 the other numbers of a scene have no digit left.
TEST_F(LostInertia, NamesTheKeyThatIsTooLarge) {
  const std::string run = "run " + scene("chatter") + " --quiet -o out --set mesh.mass=lumped --set output.every=1e98";
  for (const std::string method : {"cvode", "ida", "arkode"})
    for (const std::string key : {"bar.viscosity", "time.end"}) {
      const Ended ended = viscobar(run + " --set method.name=" + method + " --set " + key + "=1e100");
      EXPECT_EQ(ended.code, 1) << method << key;
      EXPECT_NE(ended.error.find("leaves no digit of the inertia"), std::string::npos) << method << ended.error;
      EXPECT_NE(ended.error.find(key), std::string::npos) << method << ended.error;
    }
  const Ended scheme = viscobar(
      run + " --set method.name=fully_discrete --set method.step=1e30 --set time.end=1e31 --set output.every=1e30");
  EXPECT_EQ(scheme.code, 1);
  EXPECT_NE(scheme.error.find("take a shorter method.step"), std::string::npos) << scheme.error;
}

class Storm : public Command {};

TEST_F(Storm, IsWarnedOfOnceOnStandardErrorInTheSummaryAndInTheReport) {
  const Ended ended = viscobar("run " + scene("chatter") + " --json -o out");
  EXPECT_EQ(ended.code, 0) << ended.error;
  EXPECT_TRUE(ended.error.starts_with("warning: chatter")) << ended.error;
  EXPECT_EQ(std::count(ended.error.begin(), ended.error.end(), '\n'), 1) << ended.error;
  const nlohmann::json warnings = ended.json()["warnings"];
  ASSERT_EQ(warnings.size(), 1u);
  for (const char* remedy : {"mesh.mass", "contact.restitution = 0", "contact.epsilon"})
    EXPECT_NE(warnings[0].get<std::string>().find(remedy), std::string::npos) << warnings[0];
  EXPECT_NE(read_text(directory_ / "out/report.html").find("rebounds by itself"), std::string::npos);
  const std::string events = read_text(directory_ / "out/events.csv");
  EXPECT_EQ(std::count(events.begin(), events.end(), '\n'), 1 + ended.json()["events"].get<long>());
  EXPECT_EQ(viscobar("run " + scene("chatter") + " --quiet -o out").error, "");
}

TEST_F(Storm, IsNotWarnedOfWhereARemedyWasTaken) {
  const Ended ended = viscobar("run " + scene("chatter") + " --json -o out --set mesh.mass=redistributed");
  EXPECT_EQ(ended.error, "");
  EXPECT_TRUE(ended.json()["warnings"].empty());
}

}  // namespace
}  // namespace viscobar::testing_cli
