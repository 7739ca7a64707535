// The scene from standard input, a limit on the time of a run, and help by its own command.
#include "cli/command.hpp"

namespace viscobar {
namespace {

namespace fs = std::filesystem;

class StandardInput : public testing_cli::Command {
 protected:
  StandardInput() { viscobar("new scene.toml"); }
};

TEST_F(StandardInput, IsTheSceneOfWhateverReadsOne) {
  EXPECT_EQ(viscobar("check - <scene.toml").code, 0);
  EXPECT_EQ(viscobar("run - --quiet --set time.end=0.1 <scene.toml").code, 0);
  EXPECT_TRUE(fs::exists(directory_ / "stdin.out/summary.json"));
  EXPECT_EQ(viscobar("run - --quiet --set time.end=0.1 -o named <scene.toml").code, 0);
  EXPECT_TRUE(fs::exists(directory_ / "named/summary.json"));
}

TEST_F(StandardInput, IsNamedInFrontOfItsMistakes) {
  std::ofstream(directory_ / "wrong.toml") << "[bar]\nyoungs = 3\n";
  const auto ended = viscobar("check - <wrong.toml");
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.error.find("standard input:2:1: bar.youngs: unknown key; nearest is \"modulus\""), std::string::npos)
      << ended.error;
}

TEST_F(StandardInput, IsReadOnceForTheManyRunsOfAFit) {
  ASSERT_EQ(viscobar("run scene.toml --quiet --set time.end=0.5 -o out").code, 0);
  const auto fit =
      viscobar("fit - --quiet --set time.end=0.5 --data out/ends.csv --parameters bar.viscosity <scene.toml");
  EXPECT_EQ(fit.code, 0) << fit.error;
}

class WallTime : public StandardInput {};

TEST_F(WallTime, StopsARunFromWhichResumeGoesOn) {
  // A time that is over at the first step.
  const auto stopped = viscobar("run scene.toml -o out --set method.name=cvode --wall-time 1e-9s");
  EXPECT_EQ(stopped.code, 130);
  EXPECT_NE(stopped.error.find("--wall-time"), std::string::npos) << stopped.error;
  ASSERT_TRUE(fs::exists(directory_ / "out/checkpoint.bin"));
  const auto reached = [&] { return viscobar("info out --json").json()["results"][0]["reached_time"].get<double>(); };
  const double before = reached();
  const auto again = viscobar("resume out --wall-time 1e-9s --quiet");
  EXPECT_EQ(again.code, 130);
  EXPECT_NE(again.error.find("its start took the rest"), std::string::npos) << again.error;
  EXPECT_GT(reached(), before);
}

TEST_F(WallTime, IsATimeOnTheClock) {
  const auto ended = viscobar("run scene.toml --wall-time 10");
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.error.find("no time on the clock"), std::string::npos) << ended.error;
}

class Help : public StandardInput {};

TEST_F(Help, IsThatOfTheCommandItself) {
  EXPECT_EQ(viscobar("help run").out, viscobar("run --help").out);
  EXPECT_NE(viscobar("help").out.find("precision"), std::string::npos);
  EXPECT_NE(viscobar("help rnu").error.find("did you mean run?"), std::string::npos);
}

}  // namespace
}  // namespace viscobar
