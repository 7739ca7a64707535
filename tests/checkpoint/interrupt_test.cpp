// An interrupt ends each command soon, in a step of a mesh however fine, and in what comes before and after the runs.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <ctime>
#include <filesystem>
#include <fstream>

#include "checkpoint/process.hpp"
#include "support/scene_text.hpp"
#include "support/scratch.hpp"

namespace viscobar::testing_interrupts {
namespace {

using testing_checkpoint::Process;

#ifdef __SANITIZE_ADDRESS__
constexpr double slower = 10.0;
#else
constexpr double slower = 1.0;
#endif

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// Processor time of the processes that have ended.
double of_children() {
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

class Interrupts : public testing::Test {
 protected:
  void SetUp() override {
    const auto write = [&](const char* file, const std::vector<std::pair<std::string, std::string>>& changes) {
      std::ofstream(scratch / file) << falling_bar_with(changes);
    };
    write(
        "fine.toml",
        {{"mesh.elements", "100000"}, {"time.end", "1000"}, {"output.every", "1"}, {"load.density", "\"-sin(3*t)\""}});
    write("elastic.toml",
          {{"bar.viscosity", "0"}, {"mesh.elements", "100000"}, {"time.end", "1e6"}, {"load.density", "-1.0"}});
    write("long.toml", {{"time.end", "1e6"}, {"output.every", "1e3"}, {"load.density", "\"-sin(t)\""}});
    write("stiff.toml", {{"bar.viscosity", "0"},
                         {"mesh.elements", "2"},
                         {"right.kind", "\"free\""},
                         {"right.stiffness", "1e15"},
                         {"method.name", "\"rigid\""}});
    std::ofstream(scratch / "sweep.toml") << "scene = \"fine.toml\"\n[vary]\nbar.viscosity = [0.1, 0.2, 0.3]\n";
    std::ofstream data(scratch / "data.csv");
    data << "t,u_left\n";
    for (int k = 0; k <= 400; ++k) data << 0.1 * k << "," << -0.1 * std::min(k, 1) << "\n";
  }

  /// Sends a signal in the midst of the work of a command, which ends with code 130 and a word.
  void expect_heard(const std::vector<std::string>& arguments, int signal = SIGINT) {
    std::string words;
    for (const std::string& argument : arguments) words += argument + " ";
    SCOPED_TRACE(words);
    const double before = of_children();
    Process process(scratch.path(), arguments);
    constexpr double begun = 0.7;
    while (!process.ended() && process.processor_seconds() < begun)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    ASSERT_FALSE(process.ended()) << read_text(scratch / "err.txt");
    const double at_signal = process.processor_seconds();
    process.signal(signal);
    EXPECT_EQ(process.wait(), 130);
    // Processor time, as other programs may have the machine.
    EXPECT_LT(of_children() - before - at_signal, 2.0 * slower);
    EXPECT_NE(read_text(scratch / "err.txt").find("interrupted"), std::string::npos) << read_text(scratch / "err.txt");
  }

  Scratch scratch;
};

TEST_F(Interrupts, AreHeardByARunOfEachMethodOnAFineMesh) {
  for (const auto& [scene, method] : {std::pair{"fine.toml", "cvode"},
                                      {"fine.toml", "ida"},
                                      {"fine.toml", "arkode"},
                                      {"elastic.toml", "odeint"},
                                      {"fine.toml", "rigid"},
                                      {"long.toml", "exponential"},
                                      {"elastic.toml", "characteristics"},
                                      {"fine.toml", "fully_discrete"},
                                      {"fine.toml", "finite_difference"}})
    expect_heard({"run", scene, "--set", std::string("method.name=") + method, "--no-estimate", "-q", "-o", "out"});
}

// A terminal that closes, kill(1) and batch systems send them. Other signals end the program; what was whole stays so.
TEST_F(Interrupts, AreAlsoSignalsOfTheSystem) {
  ASSERT_EQ(Process(scratch.path(), {"run", "fine.toml", "--set", "mesh.elements=20", "-q", "-o", "out"}).wait(), 0);
  const std::vector<std::string> run = {"run", "fine.toml", "--no-estimate", "-q", "-o", "out"};
  for (const int signal : {SIGTERM, SIGHUP, SIGUSR1, SIGXCPU}) {
    expect_heard(run, signal);
    expect_heard({"compare", "long.toml", "-q", "-o", "study"}, signal);
  }
  const std::string before = read_text(scratch / "out/summary.json");
  for (const int signal : {SIGUSR2, SIGQUIT, SIGKILL}) {
    Process process(scratch.path(), run);
    while (!process.ended() && process.processor_seconds() < 0.5)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    process.signal(signal);
    EXPECT_EQ(process.wait(), -signal);
    EXPECT_EQ(read_text(scratch / "out/summary.json"), before);
  }
}

TEST_F(Interrupts, AreHeardByEachCommand) {
  for (const std::string scene : {"fine.toml", "long.toml"}) {
    expect_heard({"run", scene, "--error", "1e-12", "--set", "contact.epsilon=", "-q", "-o", "out"});
    expect_heard({"compare", scene, "-q", "-o", "study"});
    expect_heard({"limit", scene, "-q", "-o", "study"});
    expect_heard({"precision", scene, "-q", "-o", "study"});
    expect_heard({"fit", scene, "--data", "data.csv", "--parameters", "bar.viscosity,left.gap", "--set",
                  "mesh.elements=100000", "--set", "time.end=40", "-q", "-o", "study"});
  }
  expect_heard({"sweep", "sweep.toml", "-q", "-o", "sweep"});
  std::vector<std::string> run = {"run", "elastic.toml", "--no-estimate", "-q", "-o", "whole"};
  for (const char* setting :
       {"mesh.elements=20000", "time.end=40", "output.every=0.1", "method.name=fully_discrete", "method.step=0.02"})
    run.insert(run.end(), {"--set", setting});
  ASSERT_EQ(Process(scratch.path(), run).wait(), 0) << read_text(scratch / "err.txt");
  expect_heard({"export", "whole", "-q", "-o", "exported"});
  EXPECT_FALSE(std::filesystem::exists(scratch / "exported/.viscobar.export"));
  expect_heard({"check", "stiff.toml"});
}

}  // namespace
}  // namespace viscobar::testing_interrupts
