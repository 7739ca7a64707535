// Refusals of the machine at every place where it can refuse: memory, room on the disk, renaming, syncing. A run that
// fails for it says so with exit code 1, and goes on later as if nothing had happened.
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "checkpoint/process.hpp"
#include "support/scene_text.hpp"
#include "support/scratch.hpp"

namespace viscobar::testing_faults {
namespace {

namespace fs = std::filesystem;
using testing_checkpoint::Process;

const std::string bouncing = falling_bar_with({{"initial.velocity", "\"-1-x/10\""},
                                               {"load.density", "\"-sin(t)*x\""},
                                               {"time.end", "2.0"},
                                               {"method.name", "\"cvode\""},
                                               {"method.step", "1e-3"},
                                               {"output.every", "0.01"}});

#ifdef __SANITIZE_ADDRESS__
constexpr bool sanitized = true;  // has an allocator of its own, in front of every other
#else
constexpr bool sanitized = false;
#endif

/// True if this process runs under memcheck, whose allocator takes the place of every other.
bool under_valgrind() {
  const char* preloaded = std::getenv("LD_PRELOAD");
  return preloaded && std::string_view(preloaded).find("vgpreload") != std::string_view::npos;
}

class Faults : public testing::Test {
 protected:
  void SetUp() override {
    if (sanitized) GTEST_SKIP() << "the sanitizer does not let itself be preloaded upon";
    std::ofstream(scratch / "bouncing.toml") << bouncing;
  }

  /// Exit code of the command under a fault; -SIGKILL where it had to be ended.
  int run(const std::vector<std::string>& arguments, const std::string& fault) {
    Process process(scratch.path(), arguments,
                    {"LD_PRELOAD=" VISCOBAR_FAULTS, "VISCOBAR_FAULT=" + fault, "VISCOBAR_FAULT_COUNT=count.txt"});
    for (int i = 0; i < 60'000 && !process.ended(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (!process.ended()) process.signal(SIGKILL);
    return process.wait();
  }
  std::size_t counted() const { return std::stoul(read_text(scratch / "count.txt")); }
  std::string err() const { return read_text(scratch / "err.txt"); }

  /// Files of the result, by their names in its directory.
  std::map<std::string, std::string> files() const {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(scratch / "out"))
      if (entry.is_regular_file() && entry.path().filename() != ".viscobar.lock")
        all[entry.path().lexically_relative(scratch / "out").string()] = read_text(entry.path());
    return all;
  }

  static std::vector<std::string> command(const std::string& method, const std::string& directory) {
    return {"run", "--no-estimate", "bouncing.toml", "--quiet", "--set", "method.name=" + method, "--checkpoint", "0.2",
            "-o",  directory};
  }

  /// Numbers up to `last`: all of the first ones, and `count` more, spread evenly.
  static std::vector<std::size_t> spread(std::size_t first, std::size_t last, std::size_t count) {
    std::vector<std::size_t> all;
    const char* every = std::getenv("VISCOBAR_FAULTS_EVERY");  // every so-manieth call: 1 for all of them
    std::size_t stride = std::max<std::size_t>(1, last / (every ? 10 : count));
    if (every) stride = std::min<std::size_t>(stride, std::strtoul(every, nullptr, 10));
    for (std::size_t n = 1; n <= last; n += n <= first && !every ? 1 : stride) all.push_back(n);
    return all;
  }

  Scratch scratch;
};

TEST_F(Faults, NoMemoryIsAFailureAndNeverACrash) {
  if (under_valgrind()) GTEST_SKIP() << "its allocator cannot be made to fail";
  // Not arkode: where one of the first allocations of ARKODE's own fails, the library clones a vector that is not there
  // (arkAllocVec in arkStep_Init), about one allocation of a run in two hundred.
  for (const std::string method : {"cvode", "ida", "odeint", "exponential", "fully_discrete"}) {
    SCOPED_TRACE(method);
    ASSERT_EQ(run(command(method, "whole"), "malloc:0"), 0) << err();
    const std::size_t allocations = counted();
    EXPECT_GT(allocations, 1000u);
    for (const std::size_t n : spread(0, allocations, 25)) {
      const int code = run(command(method, "out"), "malloc:" + std::to_string(n));
      // 2: a stream without memory reads no number, and the formula "cannot be understood".
      EXPECT_TRUE(code == 0 || ((code == 1 || code == 2) && !err().empty())) << n << ": " << code << " " << err();
    }
  }
}

TEST_F(Faults, AFullDiskFailsTheRunAndLosesNothing) {
  ASSERT_EQ(run(command("cvode", "whole"), "write:1000000"), 0) << err();
  const std::size_t writes = counted();
  EXPECT_GT(writes, 50u);
  const std::vector<std::size_t> places = spread(10, writes, 30);
  std::size_t failed = 0;
  for (const std::size_t n : places) {
    fs::remove_all(scratch / "out");
    const int code = run(command("cvode", "out"), "write:" + std::to_string(n));
    if (counted() < n) continue;  // how often field.xdmf is renewed depends on the clock
    ++failed;
    EXPECT_EQ(code, 1) << n;
    EXPECT_NE(err().find("No space left on device"), std::string::npos) << n << err();
    EXPECT_NE(err().find("out/"), std::string::npos) << n << err();
    const bool kept = fs::exists(scratch / "out/checkpoint.bin") || fs::exists(scratch / "out/checkpoint.previous.bin");
    ASSERT_EQ(run(kept ? std::vector<std::string>{"resume", "out", "--quiet"} : command("cvode", "out"), ""), 0)
        << n << err();
    for (const char* file : {"ends.csv", "events.csv", "field.xdmf"})
      EXPECT_EQ(read_text(scratch / "whole" / file) == read_text(scratch / "out" / file), true) << n << file;
  }
  EXPECT_GT(failed, places.size() / 2);
}

TEST_F(Faults, ShortWritesLoseNothing) {
  ASSERT_EQ(run(command("cvode", "whole"), ""), 0) << err();
  ASSERT_EQ(run(command("cvode", "out"), "short:0"), 0) << err();
  for (const char* file : {"ends.csv", "events.csv", "field.xdmf", "field.h5"})
    EXPECT_EQ(read_text(scratch / "whole" / file).size(), read_text(scratch / "out" / file).size()) << file;
  EXPECT_EQ(read_text(scratch / "whole/ends.csv"), read_text(scratch / "out/ends.csv"));
}

TEST_F(Faults, WhatCannotBeRenamedOrSyncedFailsTheRunAndLosesNothing) {
  for (const std::string what : {"rename:", "fsync:"}) {
    ASSERT_EQ(run(command("cvode", "whole"), what + "1000000"), 0) << err();
    const std::size_t calls = counted();
    EXPECT_GT(calls, 10u);
    const std::vector<std::size_t> places = spread(0, calls, 10);
    std::size_t failed = 0;
    for (const std::size_t n : places) {
      SCOPED_TRACE(what + std::to_string(n));
      fs::remove_all(scratch / "out");
      const int code = run(command("cvode", "out"), what + std::to_string(n));
      if (counted() < n) continue;  // how often field.xdmf is renewed depends on the clock
      ++failed;
      EXPECT_EQ(code, 1);
      EXPECT_NE(err().find(": Input/output error"), std::string::npos) << err();
      EXPECT_NE(err().find(" out"), std::string::npos) << err();
      const bool kept =
          fs::exists(scratch / "out/checkpoint.bin") || fs::exists(scratch / "out/checkpoint.previous.bin");
      ASSERT_EQ(run(kept ? std::vector<std::string>{"resume", "out", "--quiet"} : command("cvode", "out"), ""), 0)
          << err();
      EXPECT_EQ(read_text(scratch / "whole/ends.csv") == read_text(scratch / "out/ends.csv"), true);
    }
    EXPECT_GT(failed, places.size() / 2) << what;
  }
}

// A run that replaces a whole result, and cannot: the place that the message names is there.
TEST_F(Faults, ARunThatCannotReplaceAResultNamesWhereItIs) {
  const std::string words = "what this run reached is in ";
  std::size_t named = 0;
  for (int n = 1; n <= 16; ++n) {
    fs::remove_all(scratch / "out");
    ASSERT_EQ(run(command("cvode", "out"), ""), 0) << err();
    if (run(command("cvode", "out"), "rename:" + std::to_string(n)) == 0) continue;
    const std::string said = read_text(scratch / "out.txt") + err();
    const std::size_t at = said.find(words);
    named += at != said.npos;
    EXPECT_TRUE(at == said.npos || fs::exists(scratch / "out/unfinished")) << n << ' ' << said;
    EXPECT_EQ(run({"info", "out"}, ""), 0) << n << ' ' << said << err();
  }
  EXPECT_GT(named, 0u);
}

// A study, or an export, replaces a whole result by a whole one, or leaves it, whatever fails once or for good.
TEST_F(Faults, StudiesAndExportsReplaceAllOfTheirFilesOrNone) {
  std::ofstream(scratch / "data.csv") << "t,u_left\n0.5,0.1\n1,0.2\n1.5,0.1\n";
  std::ofstream(scratch / "short.toml") << falling_bar_with(
      {{"time.end", "0.5"}, {"method.name", "\"cvode\""}, {"output.every", "0.1"}});
  const std::vector<std::vector<std::string>> commands = {
      {"compare", "short.toml", "--methods", "cvode,ida", "-o", "out"},
      {"limit", "short.toml", "--epsilon", "1e-2:1e-3", "--budget", "0", "-o", "out"},
      {"precision", "short.toml", "--methods", "cvode", "--tolerance", "1e-3", "--repeat", "3", "-o", "out"},
      {"fit", "short.toml", "--data", "data.csv", "--parameters", "bar.viscosity", "--runs", "3", "-o", "out"},
      {"export", "run", "-o", "out"},
      {"export", "run", "--format", "xdmf", "-o", "out"}};
  ASSERT_EQ(run({"run", "short.toml", "--quiet", "-o", "run"}, ""), 0) << err();
  for (const auto& command : commands)
    for (const std::string what : {"one-write:", "write:", "rename:", "fsync:", "close:"}) {
      fs::remove_all(scratch / "out");
      const bool exported = command[0] == "export";
      const int whole = run(command, what + "1000000");
      ASSERT_LE(whole, 1) << err();  // a fit of three runs has not converged
      const std::size_t calls = counted();
      EXPECT_GT(calls, 1u) << command[0] << what;
      for (const std::size_t n : spread(0, calls, 4)) {
        SCOPED_TRACE(command[0] + " " + what + std::to_string(n));
        const auto before = files();
        const int code = run(command, what + std::to_string(n));
        EXPECT_TRUE(code == 0 || code == 1) << code << err();
        EXPECT_TRUE(code == 0 || !err().empty());
        if (exported) {
          ASSERT_EQ(run(command, ""), 0) << err();  // ends what a failing move has left
          EXPECT_EQ(files() == before, true);
        } else {
          EXPECT_EQ(run({"info", "--verify", "out"}, ""), 0) << err() << read_text(scratch / "out.txt");
        }
      }
    }
}

// The walk: each command meets a fault of each kind at one place, another for each of them, or, with
// VISCOBAR_FAULTS_EVERY, at every so-manieth. It says so, or ends as if nothing had been; what it leaves is sound, and
// what it would have done can be done afterwards. Allocations of HDF5 for itself do not fail here.
TEST_F(Faults, EveryCommandSurvivesAFaultOfEachKindAnywhere) {
  std::ofstream(scratch / "short.toml") << falling_bar_with({{"time.end", "0.5"},
                                                             {"bar.section", "\"2-x\""},
                                                             {"method.name", "\"cvode\""},
                                                             {"output.every", "0.1"},
                                                             {"output.gauges", "[0.0, 0.25]"}});
  std::ofstream(scratch / "sweep.toml") << "scene = \"short.toml\"\n[vary]\nbar.viscosity = [0.1, 0.2]\n";
  ASSERT_EQ(run({"run", "short.toml", "--quiet", "-o", "whole"}, ""), 0) << err();
  ASSERT_EQ(run({"run", "short.toml", "--quiet", "--set", "method.name=ida", "-o", "other"}, ""), 0) << err();
  ASSERT_EQ(run({"run", "short.toml", "--quiet", "--checkpoint", "0.1", "-o", "stopped", "--wall-time", "1e-9s"}, ""),
            130)
      << err();
  const std::vector<std::vector<std::string>> commands = {
      {"run", "short.toml", "--checkpoint", "0.2", "-q", "-o", "out"},
      {"run", "short.toml", "--figures", "--sensitivity", "left.gap", "-q", "-o", "out"},
      {"resume", "out", "-q"},
      {"check", "short.toml"},
      {"compare", "short.toml", "--methods", "cvode,ida", "-q", "-o", "out"},
      {"compare", "short.toml", "--with", "whole/ends.csv", "-q", "-o", "out"},
      {"compare", "whole", "other", "-q", "-o", "out"},
      {"limit", "short.toml", "--epsilon", "1e-2:1e-3", "--budget", "0", "-q", "-o", "out"},
      {"precision", "short.toml", "--methods", "cvode", "--tolerance", "1e-3", "--repeat", "3", "-q", "-o", "out"},
      {"fit", "short.toml", "--data", "whole/gauges.csv", "--parameters", "bar.viscosity", "--runs", "3", "-q", "-o",
       "out"},
      {"sweep", "sweep.toml", "--threads", "1", "-q", "-o", "out"},
      {"export", "whole", "-q", "-o", "out"},
      {"export", "whole", "--format", "xdmf", "-q", "-o", "out"},
      {"info", "--verify", "whole"},
      {"new", "new.toml"}};
  const bool thorough = std::getenv("VISCOBAR_FAULTS_EVERY") != nullptr;
  std::vector<std::string> kinds = {"malloc:", "one-write:", "rename:", "close:"};
  if (thorough) kinds.insert(kinds.end(), {"write:", "fsync:"});
  if (under_valgrind()) kinds.erase(kinds.begin());
  std::size_t place = 0, failed = 0;
  for (const auto& command : commands) {
    const auto begin = [&] {
      fs::remove_all(scratch / "out");
      fs::remove(scratch / "new.toml");
      if (command[0] == "resume") fs::copy(scratch / "stopped", scratch / "out");
    };
    for (const std::string& kind : kinds) {
      begin();
      const bool memory = kind == "malloc:";
      const int whole = run(command, kind + (memory ? "0" : "1000000"));
      ASSERT_LE(whole, 1) << command[0] << err();  // a fit of three runs has not converged
      const std::size_t calls = counted();
      if (calls == 0) continue;
      place += 7919;
      for (const std::size_t n : thorough ? spread(0, calls, 0) : std::vector<std::size_t>{1 + place % calls}) {
        SCOPED_TRACE(command[0] + " " + kind + std::to_string(n));
        begin();
        const int code = run(command, kind + std::to_string(n));
        failed += code != 0;
        // 2: see NoMemoryIsAFailureAndNeverACrash.
        EXPECT_TRUE(code == 0 || code == 1 || (code == 2 && memory)) << code << err();
        EXPECT_TRUE(code == 0 || !err().empty());
        if (command[0] == "check" || command[0] == "info" || command[0] == "new") continue;
        EXPECT_NE(run({"info", "--verify", "out"}, ""), 1) << err() << read_text(scratch / "out.txt");
        if (command[0] != "resume") {
          EXPECT_EQ(run(command, ""), whole) << err();
        }
      }
    }
  }
  EXPECT_GT(failed, 10u);
}

// A kill anywhere leaves a sound result, and the same command then leaves its own files and no others: none of what was
// there before, a run with pictures and gauges, a study with pictures, an export with gauges, a stopped run.
TEST_F(Faults, AKillAnywhereLeavesTheOldResultOrTheNew) {
  const auto write_scene = [&](const char* file, std::vector<std::pair<std::string, std::string>> changes) {
    for (const auto& change : {std::pair{"time.end", "0.5"}, {"method.name", "\"cvode\""}, {"output.every", "0.1"}})
      changes.emplace_back(change);
    std::ofstream(scratch / file) << falling_bar_with(changes);
  };
  write_scene("short.toml", {});
  write_scene("gauged.toml", {{"output.gauges", "[0.0, 0.25]"}});
  const auto done = [&](std::vector<std::string> words, const std::string& directory, int code = 0) {
    words.insert(words.end(), {"-q", "-o", directory});
    ASSERT_EQ(run(words, ""), code) << words[0] << err();
  };
  done({"run", "gauged.toml", "--figures"}, "ran");
  done({"run", "short.toml"}, "plain");
  done({"run", "short.toml", "--figures", "--checkpoint", "0.1", "--wall-time", "1e-9s"}, "stopped", 130);
  done({"run", "short.toml", "--figures", "--wall-time", "1e-9s"}, "halted", 130);  // behind its first step
  done({"compare", "gauged.toml", "--methods", "cvode,ida", "--figures"}, "compared");
  done({"export", "ran"}, "exported");
  const struct {
    std::string before;
    std::vector<std::string> command;
  } cases[] = {{"ran", {"run", "short.toml", "-q", "-o", "out"}},
               {"stopped", {"run", "short.toml", "-q", "-o", "out"}},
               {"stopped", {"resume", "out", "-q"}},
               {"halted", {"resume", "out", "-q"}},
               {"compared", {"compare", "short.toml", "--methods", "cvode,ida", "-q", "-o", "out"}},
               {"exported", {"export", "plain", "-q", "-o", "out"}}};
  for (const auto& [before, command] : cases) {
    const auto begin = [&] {
      fs::remove_all(scratch / "out");
      fs::copy(scratch / before, scratch / "out", fs::copy_options::recursive);
    };
    begin();
    ASSERT_EQ(run(command, "kill:1000000"), 0) << err();
    const std::size_t calls = counted();
    const auto whole = files();
    for (const auto& [name, content] : whole)
      EXPECT_FALSE(name.starts_with("figures") || name == "gauges.csv") << command[0] << name;
    for (const std::size_t n : spread(6, calls, 12)) {
      SCOPED_TRACE(command[0] + " kill:" + std::to_string(n));
      begin();
      // Files that are written by the clock are written less often on a machine that has become faster.
      const int killed = run(command, "kill:" + std::to_string(n));
      ASSERT_TRUE(killed == -SIGKILL || (killed == 0 && counted() < n)) << killed << err();
      if (command[0] != "export") {
        EXPECT_NE(run({"info", "--verify", "out"}, ""), 1) << read_text(scratch / "out.txt");
      }
      const int code = run(command, "");
      EXPECT_TRUE(code == 0 || (command[0] == "resume" && code == 2)) << err();  // 2: it was whole
      const auto after = files();
      EXPECT_EQ(after.size(), whole.size());
      for (const auto& [name, content] : whole)
        EXPECT_TRUE(after.contains(name) &&
                    (!name.ends_with(".csv") || name == "compare.csv" || after.at(name) == content))
            << name;
    }
  }
}

// A resumed run that fails before its own first checkpoint leaves the one that it went on from.
TEST_F(Faults, AResumedRunThatCannotBeginCanBeResumed) {
  std::vector<std::string> stop = command("cvode", "stopped");
  stop.insert(stop.end(), {"--wall-time", "1e-9s"});
  ASSERT_EQ(run(stop, ""), 130) << err();
  for (const std::string what : {"fsync:", "rename:", "close:", "one-write:"})
    for (std::size_t n = 1; n <= 12; ++n) {
      SCOPED_TRACE(what + std::to_string(n));
      fs::remove_all(scratch / "out");
      fs::copy(scratch / "stopped", scratch / "out");
      run({"resume", "out", "-q"}, what + std::to_string(n));
      EXPECT_NE(run({"resume", "out", "-q"}, ""), 1) << err();
      EXPECT_EQ(run({"info", "--verify", "out"}, ""), 0) << read_text(scratch / "out.txt");
    }
}

// The first two calls are for the table itself; from the third on rows are brought to the disk before they are marked.
TEST_F(Faults, ASweepMarksNoRowThatIsNotOnTheDisk) {
  std::ofstream(scratch / "sweep.toml") << "scene = \"bouncing.toml\"\n[vary]\nbar.viscosity = [0.1, 0.2, 0.3]\n";
  const std::vector<std::string> sweep = {"sweep", "sweep.toml", "--quiet", "-o", "out"};
  EXPECT_EQ(run(sweep, "fsync:3"), 1);
  EXPECT_NE(err().find("sweep.h5: cannot be brought to the disk: Input/output error"), std::string::npos) << err();
  EXPECT_EQ(run({"info", "out", "--json"}, ""), 0) << err();
  EXPECT_EQ(nlohmann::json::parse(read_text(scratch / "out.txt"))["results"][0]["done"], 0);
  EXPECT_EQ(run(sweep, ""), 0) << err();
}

// Small values of a new file are written as it is closed. The third and the fourth write are the identity and the
// build.
TEST_F(Faults, ASweepWhoseTableCouldNotBeWrittenOnceGoesOnTheNextTime) {
  std::ofstream(scratch / "sweep.toml") << "scene = \"bouncing.toml\"\n[vary]\nbar.viscosity = [0.1, 0.2]\n";
  for (std::size_t n = 1; n <= 8; ++n) {
    const std::vector<std::string> sweep = {"sweep", "sweep.toml", "--quiet", "-o", "out" + std::to_string(n)};
    EXPECT_NE(run(sweep, "one-write:" + std::to_string(n)), 2) << n << ": " << err();
    EXPECT_EQ(run(sweep, ""), 0) << n << ": " << err();
    EXPECT_EQ(err(), "") << n;
  }
}

// A case without memory has no row: the next sweep makes it.
TEST_F(Faults, ASweepWithoutMemoryGoesOnTheNextTime) {
  if (under_valgrind()) GTEST_SKIP() << "its allocator cannot be made to fail";
  std::ofstream(scratch / "sweep.toml") << "scene = \"bouncing.toml\"\n[vary]\nbar.viscosity = [0.1, 0.2]\n";
  const std::vector<std::string> sweep = {"sweep", "sweep.toml", "--threads", "1", "--quiet", "-o", "out"};
  ASSERT_EQ(run(sweep, "malloc:0"), 0) << err();
  for (const std::size_t n : spread(0, counted(), 40)) {
    fs::remove_all(scratch / "out");
    const int code = run(sweep, "malloc:" + std::to_string(n));
    EXPECT_TRUE(code == 0 || ((code == 1 || code == 2) && !err().empty())) << n << ": " << code << " " << err();
    EXPECT_EQ(run(sweep, ""), 0) << n << ": " << err();
  }
}

TEST_F(Faults, APlaceThatTakesNoFilesIsNamed) {
  EXPECT_EQ(run({"run", "bouncing.toml", "--quiet", "-o", "/proc/out"}, ""), 1);
  EXPECT_NE(err().find("/proc/out"), std::string::npos) << err();
}

// A gigabyte of addresses does not hold the matrices of ten million nodes.
TEST_F(Faults, ASceneTooLargeForTheMemoryIsRefusedBeforeItTakesAny) {
  const std::string line = "cd '" + scratch.path().string() +
                           "' && ulimit -v 1000000 && '" VISCOBAR_COMMAND
                           "' run bouncing.toml --quiet -o out --set mesh.elements=10000000 >out.txt 2>err.txt";
  EXPECT_EQ(WEXITSTATUS(std::system(line.c_str())), 2);
  EXPECT_NE(err().find("GB of memory"), std::string::npos) << err();
}

}  // namespace
}  // namespace viscobar::testing_faults
