// The commands run --checkpoint and resume, killed and interrupted: the files end as if nothing had happened.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <random>

#include "checkpoint/process.hpp"
#include "results/field/field_reader.hpp"
#include "support/scene_text.hpp"
#include "support/scratch.hpp"

namespace viscobar::testing_resume {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing_checkpoint::Process;

// A bar of forty nodes thrown between two obstacles, for about a tenth of a second of computing.
const std::string thrown = falling_bar_with({{"title", R"("A bar \"thrown\" between two obstacles")"},
                                             {"bar.viscosity", "0.02"},
                                             {"right.kind", "\"obstacle\""},
                                             {"right.gap", "0.1"},
                                             {"initial.displacement", "\"x*(1-x)\""},
                                             {"initial.velocity", "\"-0.8-x/3\""},
                                             {"load.profile", "\"cos(2*x)\""},
                                             {"load.history", "\"sin(t*sqrt(2))\""},
                                             {"time.end", "40.0"},
                                             {"mesh.elements", "40"},
                                             {"contact.epsilon", "1e-4"},
                                             {"method.name", "\"cvode\""},
                                             {"method.step", "2e-4"},
                                             {"output.every", "0.02"}});

class Resume : public testing::Test {
 protected:
  Resume() { std::ofstream(scratch / "thrown.toml") << thrown; }

  /// Without the estimate of an error, which a resumed run does not make.
  int run(std::vector<std::string> arguments) {
    if (arguments.front() == "run") arguments.push_back("--no-estimate");
    return Process(scratch.path(), arguments).wait();
  }
  std::string err() const { return read_text(scratch / "err.txt"); }
  Json summary(const std::string& directory) const {
    return Json::parse(read_text(scratch / directory / "summary.json"));
  }

  static std::vector<double> field(const fs::path& file) {
    const FieldReader reader(file);
    std::vector<double> all(2 * reader.rows() * reader.nodes());
    const std::span<double> values(all);
    reader.read(FieldReader::Quantity::displacement, 0, values.first(all.size() / 2));
    reader.read(FieldReader::Quantity::velocity, 0, values.last(all.size() / 2));
    all.insert(all.end(), reader.times().begin(), reader.times().end());
    all.insert(all.end(), reader.x().begin(), reader.x().end());
    return all;
  }

  static std::string without_seconds(const std::string& page) {
    std::string text = page;
    for (std::size_t at = 0; (at = text.find(" s</dd>", at)) != text.npos;) {
      const std::size_t begin = text.rfind('>', at);
      text.erase(begin, at - begin);
      at = begin + 1;
    }
    return text;
  }

  void expect_same_results(const std::string& one, const std::string& other) const {
    for (const char* file : {"ends.csv", "events.csv", "energy.csv", "field.xdmf"})
      EXPECT_EQ(read_text(scratch / one / file) == read_text(scratch / other / file), true) << file;
    const auto text = [&](const std::string& of) {
      const fs::path file = scratch / of / "sensitivity.csv";
      return fs::exists(file) ? read_text(file) : "";
    };
    EXPECT_EQ(text(one) == text(other), true) << "sensitivity.csv";
    EXPECT_EQ(field(scratch / one / "field.h5"), field(scratch / other / "field.h5"));
    EXPECT_EQ(without_seconds(read_text(scratch / one / "report.html")) ==
                  without_seconds(read_text(scratch / other / "report.html")),
              true);
    Json a = summary(one), b = summary(other);
    // The times on the clock, and the checksums of what holds some.
    for (Json* json : {&a, &b}) {
      for (const char* clock : {"wall_seconds", "integration_seconds", "crc64"}) json->erase(clock);
      for (const char* file : {"report.html", "field.h5"}) EXPECT_EQ((*json)["files"].erase(file), 1u);
    }
    EXPECT_EQ(a, b);
    EXPECT_EQ(a["completed"], true);
    for (const std::string& directory : {one, other})
      for (const auto& entry : fs::directory_iterator(scratch / directory))
        EXPECT_FALSE(entry.path().filename().string().starts_with("checkpoint")) << entry;
  }

  Scratch scratch;
};

// VISCOBAR_KILLS=200 makes as many as a release asks for.
std::size_t wanted_kills() {
  const char* text = std::getenv("VISCOBAR_KILLS");
  return text ? std::strtoul(text, nullptr, 10) : 16;
}

TEST_F(Resume, AfterKillsAtRandomMomentsEverythingEndsAsWithoutThem) {
  std::mt19937 random(11);
  const std::vector<std::string> methods = {"cvode", "fully_discrete", "ida", "arkode"};
  for (std::size_t m = 0; m < methods.size(); ++m) {
    SCOPED_TRACE(methods[m]);
    // Estimates end with the patience for them, on a busy machine without a word of the error.
    const std::vector<std::string> begin = {"run",     "thrown.toml",   "--set",        "method.name=" + methods[m],
                                            "--quiet", "--no-estimate", "--checkpoint", "1.5"};
    auto whole = begin, killed = begin;
    whole.insert(whole.end(), {"-o", "whole"});
    killed.insert(killed.end(), {"-o", "killed"});
    const auto started = std::chrono::steady_clock::now();
    ASSERT_EQ(run(whole), 0) << err();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
    fs::remove_all(scratch / "killed");
    std::size_t kills = 0;
    while (kills < (wanted_kills() + methods.size() - 1) / methods.size()) {
      const bool there =
          fs::exists(scratch / "killed/checkpoint.bin") || fs::exists(scratch / "killed/checkpoint.previous.bin");
      Process process(scratch.path(), there ? std::vector<std::string>{"resume", "killed", "--quiet"} : killed);
      // Long enough to see a checkpoint or two more, so that the run comes to its end between many kills.
      std::this_thread::sleep_for(
          std::chrono::duration<double>(std::uniform_real_distribution(0.0, 0.6)(random) * seconds));
      process.signal(SIGKILL);
      const int code = process.wait();
      if (code == -SIGKILL)
        ++kills;
      else
        ASSERT_EQ(code, 0) << err();
      if (code == 0) {
        expect_same_results("whole", "killed");
        fs::remove_all(scratch / "killed");
      }
    }
    if (!fs::exists(scratch / "killed/checkpoint.bin") && !fs::exists(scratch / "killed/checkpoint.previous.bin"))
      ASSERT_EQ(run(killed), 0) << err();
    else
      ASSERT_EQ(run({"resume", "killed", "--quiet"}), 0) << err();
    expect_same_results("whole", "killed");
  }
}

TEST_F(Resume, AnInterruptLeavesTheLastScheduledCheckpointAndTheSameEnd) {
  for (const int signal : {SIGINT, SIGTERM}) {
    std::vector<std::string> begin = {"run", "thrown.toml", "--quiet", "--no-estimate", "--checkpoint", "1.5"};
    // Then with sensitivities, whose file is one more.
    if (signal == SIGTERM) begin.insert(begin.end(), {"--sensitivity", "left.gap,bar.modulus"});
    auto whole = begin, stopped = begin;
    whole.insert(whole.end(), {"-o", "whole"});
    stopped.insert(stopped.end(), {"-o", "stopped"});
    ASSERT_EQ(run(whole), 0) << err();
    EXPECT_EQ(fs::exists(scratch / "whole/sensitivity.csv"), signal == SIGTERM);
    fs::remove_all(scratch / "stopped");
    Process process(scratch.path(), stopped);
    while (!fs::exists(scratch / "stopped/checkpoint.previous.bin") && !process.ended())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    process.signal(signal);
    ASSERT_EQ(process.wait(), 130) << err();
    EXPECT_NE(err().find("viscobar resume stopped"), std::string::npos) << err();
    EXPECT_EQ(summary("stopped")["error"], "interrupted");
    ASSERT_EQ(run({"resume", "stopped", "--json"}), 0) << err();
    EXPECT_EQ(Json::parse(read_text(scratch / "out.txt")), summary("stopped"));
    expect_same_results("whole", "stopped");
  }
}

// Where a checkpoint is made is part of what determines the steps: the motion is the same to the tolerance. What errors
// in this scene grow to is measured by a run with a hundredth of the tolerance.
TEST_F(Resume, AnInterruptWithoutAScheduleLeavesACheckpointWhereItIs) {
  const std::vector<std::string> scene = {"run",         "thrown.toml", "--quiet",           "--set",
                                          "time.end=10", "--set",       "output.every=0.005"};
  auto whole = scene, stopped = scene;
  whole.insert(whole.end(), {"-o", "whole"});
  stopped.insert(stopped.end(), {"-o", "stopped"});
  ASSERT_EQ(run(whole), 0) << err();
  Process process(scratch.path(), stopped);
  while (!fs::exists(scratch / "stopped/field.xdmf") && !process.ended())
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  process.signal(SIGINT);
  ASSERT_EQ(process.wait(), 130) << err();
  const double reached = summary("stopped")["reached_time"];
  EXPECT_EQ(summary("stopped")["checkpoints"], Json::array({reached}));
  ASSERT_EQ(run({"resume", "stopped", "--quiet"}), 0) << err();
  EXPECT_EQ(summary("stopped")["checkpoints"], Json::array({reached}));
  EXPECT_EQ(read_lines(scratch / "stopped/ends.csv").size(), read_lines(scratch / "whole/ends.csv").size());
  const auto a = field(scratch / "whole/field.h5"), b = field(scratch / "stopped/field.h5");
  ASSERT_EQ(a.size(), b.size());
  double largest = 0.0, difference = 0.0;
  for (std::size_t i = 0; i < 2001 * 41; ++i) {
    largest = std::max(largest, std::abs(a[i]));
    difference = std::max(difference, std::abs(a[i] - b[i]));
  }
  EXPECT_LE(difference, 2 * 100 * 1e-6 * largest);  // each of the two keeps 100 times its tolerance
}

TEST_F(Resume, AQuietStudyThatIsInterruptedSaysSoAndKeepsWhatItFound) {
  Process process(scratch.path(), {"limit", "thrown.toml", "--quiet", "--set", "mesh.elements=400", "-o", "study"});
  while (!fs::exists(scratch / "study/.viscobar.lock") && !process.ended())
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  process.signal(SIGINT);
  ASSERT_EQ(process.wait(), 130) << err();
  EXPECT_NE(err().find("interrupted"), std::string::npos) << err();
}

TEST_F(Resume, OnTheClockCheckpointsAreMadeAndRecorded) {
  ASSERT_EQ(run({"run", "thrown.toml", "--quiet", "--no-estimate", "--checkpoint", "0.01s", "-o", "out"}), 0) << err();
  EXPECT_GE(summary("out")["checkpoints"].size(), 1u);
  EXPECT_FALSE(fs::exists(scratch / "out/checkpoint.bin"));
}

TEST_F(Resume, TakesTheCheckpointBeforeADamagedOneAndSaysSo) {
  const std::vector<std::string> begin = {"run",          "thrown.toml", "--quiet", "--no-estimate",
                                          "--checkpoint", "1.5",         "-o"};
  auto whole = begin, stopped = begin;
  whole.push_back("whole");
  stopped.push_back("stopped");
  ASSERT_EQ(run(whole), 0) << err();
  {
    Process process(scratch.path(), stopped);
    while (!fs::exists(scratch / "stopped/checkpoint.previous.bin") && !process.ended())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    process.signal(SIGINT);
    ASSERT_EQ(process.wait(), 130) << err();
  }
  fs::copy(scratch / "stopped", scratch / "ruined");
  fs::resize_file(scratch / "stopped/checkpoint.bin", 777);
  ASSERT_EQ(run({"resume", "stopped", "--quiet"}), 0) << err();
  EXPECT_NE(err().find("stopped/checkpoint.bin: is truncated"), std::string::npos) << err();
  expect_same_results("whole", "stopped");

  for (const char* name : {"checkpoint.bin", "checkpoint.previous.bin"})
    fs::resize_file(scratch / "ruined" / name, 777);
  const std::string ends = read_text(scratch / "ruined/ends.csv");
  EXPECT_EQ(run({"resume", "ruined", "--quiet"}), 1);
  EXPECT_NE(err().find("no sound checkpoint; nothing was changed"), std::string::npos) << err();
  EXPECT_EQ(read_text(scratch / "ruined/ends.csv"), ends);
}

TEST_F(Resume, RefusesFilesThatWereChangedSince) {
  Process process(scratch.path(),
                  {"run", "thrown.toml", "--quiet", "--no-estimate", "--checkpoint", "1.5", "-o", "stopped"});
  while (!fs::exists(scratch / "stopped/checkpoint.previous.bin") && !process.ended())
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  process.signal(SIGINT);
  ASSERT_EQ(process.wait(), 130) << err();
  for (const char* name : {"ends.csv", "events.csv", "field.h5"}) {
    fs::copy(scratch / "stopped", scratch / "changed");
    fs::resize_file(scratch / "changed" / name, 30);
    const auto report = read_text(scratch / "changed/report.html");
    EXPECT_EQ(run({"resume", "changed"}), 1);
    EXPECT_NE(err().find(std::string(name) + ": is shorter"), std::string::npos) << err();
    EXPECT_EQ(read_text(scratch / "changed/report.html") == report, true) << "nothing was changed";
    fs::remove_all(scratch / "changed");
  }
}

TEST_F(Resume, WithoutACheckpointIsTheUsersError) {
  fs::create_directory(scratch / "empty");
  for (const char* directory : {"empty", "nowhere"}) {
    EXPECT_EQ(run({"resume", directory}), 2);
    EXPECT_NE(err().find("holds no checkpoint"), std::string::npos) << err();
  }
  ASSERT_EQ(run({"run", "thrown.toml", "--quiet", "--no-estimate", "--set", "time.end=1", "-o", "complete"}), 0)
      << err();
  EXPECT_EQ(run({"resume", "complete"}), 2);
  for (const char* interval : {"0", "-1", "1e-300", "5 s", "3d", "often", "inf", "nan", "1e999s"}) {
    EXPECT_EQ(run({"run", "thrown.toml", "--checkpoint", interval, "-o", "none"}), 2) << interval;
    EXPECT_NE(err().find("--checkpoint"), std::string::npos) << err();
    EXPECT_FALSE(fs::exists(scratch / "none"));
  }
}

}  // namespace
}  // namespace viscobar::testing_resume
