// Files of a result that are no longer what was written: verification names them, and nothing goes on from them.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>

#include "checkpoint/process.hpp"
#include "results/result_directory.hpp"
#include "results/result_info.hpp"
#include "results/summary.hpp"
#include "support/scene_text.hpp"
#include "support/scratch.hpp"
#include "sweep/sweep_results.hpp"
#include "viscobar/record/record_run.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar::testing_damage {
namespace {

namespace fs = std::filesystem;

const std::string bouncing = falling_bar_with({{"title", "\"bouncing\""},
                                               {"bar.viscosity", "0.02"},
                                               {"time.end", "3.0"},
                                               {"mesh.elements", "12"},
                                               {"method.name", "\"fully_discrete\""},
                                               {"method.step", "1e-3"},
                                               {"output.every", "0.01"}});

/// Random damage, the same in every run of the tests.
class Vandal {
 public:
  /// Bytes other than those given: one flipped bit, four other bytes, a stretch of zeros, noise, a cut, something more.
  std::string damaged(const std::string& sound) {
    std::string bytes = sound;
    const std::size_t at = below(bytes.size()), length = 1 + below(std::min<std::size_t>(64, bytes.size() - at));
    const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(at),
               last = first + static_cast<std::ptrdiff_t>(length);
    switch (below(7)) {
      case 0:
      case 1: *first ^= static_cast<char>(1 << below(8)); break;
      case 2:
        for (std::size_t i = at; i < std::min(at + 4, bytes.size()); ++i) bytes[i] ^= static_cast<char>(1 + below(255));
        break;
      case 3: std::fill(first, last, '\0'); break;
      case 4: std::generate(first, last, [&] { return static_cast<char>(below(256)); }); break;
      case 5: bytes.resize(at); break;
      default: bytes.insert(first, '\1'); break;
    }
    return bytes == sound ? damaged(sound) : bytes;
  }
  /// The same of one length.
  std::string damaged_in_place(const std::string& sound) {
    for (;;)
      if (std::string bytes = damaged(sound); bytes.size() == sound.size()) return bytes;
  }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random_() % n); }

 private:
  std::mt19937_64 random_{20};
};

void write(const fs::path& file, const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; }

FileState state_of(const std::string& name, const fs::path& directory) {
  for (const VerifiedFile& file : verify_result(directory))
    if (file.name == name) return file.state;
  return FileState::foreign;
}

std::vector<std::string> names_in(const fs::path& directory) {
  std::vector<std::string> names;
  for (const VerifiedFile& file : verify_result(directory)) names.push_back(file.name);
  return names;
}

class Damage : public testing::Test {
 protected:
  Damage() : scene(parse_scene(bouncing, "scene")) { write(scratch / "scene.toml", bouncing); }

  // Every kind of damage to each file is noticed, and laid to that file alone.
  void expect_noticed_in_every_file(const fs::path& directory, std::size_t times) {
    ASSERT_EQ(verdict(verify_result(directory)), FileState::sound);
    for (const std::string& name : names_in(directory)) {
      const std::string sound = read_text(directory / name);
      for (std::size_t i = 0; i < times; ++i) {
        write(directory / name, vandal.damaged(sound));
        const auto files = verify_result(directory);
        ASSERT_EQ(verdict(files), FileState::damaged) << name << ' ' << i;
        for (const VerifiedFile& file : files)
          ASSERT_EQ(file.name == name, file.state == FileState::damaged) << name << ' ' << file.name << file.reason;
      }
      fs::remove(directory / name);
      if (name != "summary.json" && name != "sweep.h5" && name != "sweep.json") {
        EXPECT_EQ(state_of(name, directory), FileState::missing);
      }
      write(directory / name, sound);
    }
    EXPECT_EQ(verdict(verify_result(directory)), FileState::sound);
  }

  /// A run that was stopped in the middle, with checkpoints each 0.5, two of which are there.
  void stop_in_the_middle(const fs::path& directory) const { stop_in_the_middle(scene, directory); }
  static void stop_in_the_middle(const SceneFile& scene, const fs::path& directory) {
    RecordOptions options;
    options.checkpoint = CheckpointEvery{CheckpointEvery::Clock::simulated, 0.5};
    double reached = 0.0;
    options.progress = [&](double time, std::size_t) { reached = time; };
    options.stop = [&] { return reached > 2.2; };
    ASSERT_EQ(record_run(scene, directory, options).outcome.ending, Ending::interrupted);
  }

  int run(const std::vector<std::string>& arguments) const {
    return testing_checkpoint::Process(scratch.path(), arguments).wait();
  }
  std::string err() const { return read_text(scratch / "err.txt"); }

  Scratch scratch;
  SceneFile scene;
  Vandal vandal;
};

TEST_F(Damage, OfAnyFileOfARunIsNoticed) {
  RecordOptions options;
  options.figures = true;
  record_run(scene, scratch / "out", options);
  EXPECT_GE(names_in(scratch / "out").size(), 10u);
  expect_noticed_in_every_file(scratch / "out", 60);
}

TEST_F(Damage, OfAnyFileOfAStudyIsNoticed) {
  ASSERT_EQ(run({"compare", "scene.toml", "--methods", "fully_discrete,cvode", "--quiet", "--figures", "-o", "out"}), 0)
      << err();
  EXPECT_GE(names_in(scratch / "out").size(), 3u);
  ASSERT_EQ(verdict(verify_result(scratch / "out")), FileState::sound);
  for (const std::string& name : names_in(scratch / "out")) {
    const std::string sound = read_text(scratch / "out" / name);
    write(scratch / "out" / name, vandal.damaged(sound));
    EXPECT_EQ(state_of(name, scratch / "out"), FileState::damaged) << name;
    write(scratch / "out" / name, sound);
  }
}

// One digit in a result is another one: nothing goes on from it, whoever reads. Outside of the result it is the user's.
TEST_F(Damage, OfPagesAndSummaryIsMendedByAResume) {
  for (const char* name : {"report.html", "field.xdmf", "summary.json"}) {
    fs::remove_all(scratch / "out");
    ASSERT_EQ(run({"run", "scene.toml", "-q", "--checkpoint", "0.1", "--wall-time", "1e-9s", "-o", "out"}), 130)
        << err();
    std::string bytes = read_text(scratch / "out" / name);
    bytes[bytes.size() / 2] ^= 1;
    write(scratch / "out" / name, bytes);
    EXPECT_EQ(run({"info", "--verify", "out"}), 1) << name;
    EXPECT_EQ(run({"resume", "out", "-q"}), 0) << name << err();
    EXPECT_EQ(run({"info", "--verify", "out"}), 0) << name;
  }
}

TEST_F(Damage, OfAResultIsRefusedByEachCommandThatReadsIt) {
  const std::string measured =
      bouncing +
      "right.kind = \"free\"\nright.force = { file = \"out/ends.csv\", column = \"reaction_left\", interpolation = \"linear\" }\n";
  write(scratch / "measured.toml", measured);
  const std::vector<std::string> fit = {"fit", "scene.toml", "--parameters", "left.gap", "-q", "-o", "new"};
  const auto with = [](std::vector<std::string> words, std::initializer_list<const char*> more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  const struct {
    std::string damaged;
    std::vector<std::string> command;
    int code;
  } readers[] = {{"ends.csv", {"export", "out", "-o", "new"}, 1},
                 {"ends.csv", {"compare", "out", "other", "-q", "-o", "new"}, 2},
                 {"events.csv", {"compare", "other", "out", "-q", "-o", "new"}, 2},
                 {"ends.csv", {"compare", "scene.toml", "--with", "out/ends.csv", "-q", "-o", "new"}, 2},
                 {"summary.json", {"compare", "scene.toml", "--with", "out/ends.csv", "-q", "-o", "new"}, 2},
                 {"ends.csv", with(fit, {"--data", "out/ends.csv"}), 2},
                 {"events.csv", with(fit, {"--events", "out/events.csv"}), 2},
                 {"ends.csv", {"run", "measured.toml", "-q", "-o", "new"}, 2},
                 {"summary.json", {"run", "out/summary.json", "-q", "-o", "new"}, 2}};
  record_run(scene, scratch / "out");
  record_run(scene, scratch / "other");
  for (const auto& [name, command, code] : readers) {
    SCOPED_TRACE(command.front() + " " + name);
    EXPECT_EQ(run(command), 0) << err();
    fs::remove_all(scratch / "new");
    const std::string sound = read_text(scratch / "out" / name);
    std::string bytes = sound;
    char& digit = bytes[bytes.find_last_of("123456", bytes.size() / 2)];
    ++digit;
    write(scratch / "out" / name, bytes);
    EXPECT_EQ(run(command), code);
    EXPECT_NE(err().find("is damaged: its checksum is not the one that was written"), std::string::npos) << err();
    EXPECT_NE(err().find(name), std::string::npos) << err();
    EXPECT_FALSE(fs::exists(scratch / "new"));
    if (name == "ends.csv") {
      write(scratch / "ours.csv", bytes);
      EXPECT_EQ(run({"compare", "scene.toml", "--with", "ours.csv", "-q", "-o", "ours"}), 0) << err();
    } else if (name == "summary.json") {
      EXPECT_EQ(run({"info", "out"}), 0);
      EXPECT_NE(read_text(scratch / "out.txt").find("its checksum is not the one"), std::string::npos);
    }
    write(scratch / "out" / name, sound);
  }
}

TEST_F(Damage, OfASummaryIsToldByItsPlace) {
  record_run(scene, scratch / "out");
  const std::string sound = read_text(scratch / "out/summary.json");
  std::string bytes = sound;
  bytes[sound.find("\"method\"") - 4] = ';';  // the comma at the end of line 2
  write(scratch / "out/summary.json", bytes);
  EXPECT_EQ(run({"info", "out"}), 1);
  EXPECT_EQ(err(), "viscobar: out/summary.json:2:22: is no JSON: ; cannot stand here\n");
  write(scratch / "out/summary.json", sound.substr(0, sound.find("\"method\"")));
  EXPECT_EQ(run({"info", "out"}), 1);
  EXPECT_EQ(err(), "viscobar: out/summary.json:3:3: is no JSON: it ends before its last bracket closes\n");
}

TEST_F(Damage, OfAnUnfinishedRunIsNoticedUpToItsCheckpoint) {
  stop_in_the_middle(scratch / "out");
  ASSERT_EQ(verdict(verify_result(scratch / "out")), FileState::sound);
  // As a kill leaves it: the summary of the beginning, without checksums of what grows.
  const auto summary = nlohmann::ordered_json::parse(read_text(scratch / "out/summary.json"));
  write(scratch / "out/summary.json", sealed_summary(summary, {}));
  EXPECT_EQ(state_of("ends.csv", scratch / "out"), FileState::sound);
  EXPECT_EQ(state_of("report.html", scratch / "out"), FileState::unchecked);
  for (const std::string name : {"ends.csv", "checkpoint.bin", "checkpoint.previous.bin"}) {
    const std::string sound = read_text(scratch / "out" / name);
    std::string bytes = sound;
    bytes[bytes.size() / 3] ^= 4;
    write(scratch / "out" / name, bytes);
    EXPECT_EQ(state_of(name, scratch / "out"), FileState::damaged) << name;
    write(scratch / "out" / name, sound);
  }
  fs::remove(scratch / "out/events.csv");
  EXPECT_EQ(state_of("events.csv", scratch / "out"), FileState::missing);
}

TEST_F(Damage, NeverGetsIntoARunThatGoesOn) {
  stop_in_the_middle(scratch / "stopped");
  RecordOptions options;
  options.checkpoint = CheckpointEvery{CheckpointEvery::Clock::simulated, 0.5};
  record_run(scene, scratch / "whole", options);

  std::size_t refused = 0, mended = 0;
  for (std::size_t i = 0; i < 60; ++i) {
    fs::copy(scratch / "stopped", scratch / "out", fs::copy_options::overwrite_existing | fs::copy_options::recursive);
    const std::string name = std::array{"ends.csv", "events.csv", "field.h5"}[i % 3];
    const std::string bytes = vandal.damaged_in_place(read_text(scratch / "out" / name));
    write(scratch / "out" / name, bytes);
    std::string complaint;
    try {
      const RunRecord record = resume_run(scene_of_checkpoint(scratch / "out"), scratch / "out", {},
                                          [&](const std::string& what) { complaint = what; });
      ASSERT_EQ(record.outcome.ending, Ending::completed);
      for (const char* file : {"ends.csv", "events.csv", "field.xdmf"})
        ASSERT_EQ(read_text(scratch / "out" / file) == read_text(scratch / "whole" / file), true) << name << file << i;
      ASSERT_EQ(verdict(verify_result(scratch / "out")), FileState::sound);
      ++mended;
    } catch (const IoError& error) {
      ++refused;
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
      EXPECT_EQ(read_text(scratch / "out" / name) == bytes, true) << "nothing was changed";
    }
  }
  EXPECT_GT(refused, 15u);
  EXPECT_GT(mended, 3u) << "behind the checkpoint, or the one before";
}

TEST_F(Damage, AsFilesOfAnotherRunOrZerosIsRefusedByResume) {
  stop_in_the_middle(scratch / "out");
  SceneFile faster = scene;
  faster.run.scene.velocity = [](double) { return -1.1; };
  stop_in_the_middle(faster, scratch / "other");
  for (const std::string name : {"ends.csv", "events.csv", "field.h5"}) {
    const std::string sound = read_text(scratch / "out" / name);
    std::string other = read_text(scratch / "other" / name);
    other.resize(std::max(other.size(), sound.size()), '\n');
    for (const std::string& bytes : {other, std::string(sound.size(), '\0')}) {
      write(scratch / "out" / name, bytes);
      EXPECT_THROW(resume_run(scene, scratch / "out"), IoError) << name;
      EXPECT_EQ(read_text(scratch / "out" / name) == bytes, true) << "nothing was changed";
    }
    write(scratch / "out" / name, sound);
  }
  EXPECT_EQ(resume_run(scene, scratch / "out").outcome.ending, Ending::completed);
}

TEST_F(Damage, OfARunBesideAWholeResultIsToldFromThatOfTheResult) {
  record_run(scene, scratch / "out");
  const std::string whole = read_text(scratch / "out/summary.json");
  stop_in_the_middle(scratch / "out");
  EXPECT_EQ(verdict(verify_result(scratch / "out")), FileState::sound);
  for (const std::string name : {"ends.csv", "unfinished/ends.csv"}) {
    const std::string sound = read_text(scratch / "out" / name);
    std::string bytes = sound;
    bytes[100] ^= 1;
    write(scratch / "out" / name, bytes);
    for (const VerifiedFile& file : verify_result(scratch / "out"))
      EXPECT_EQ(file.state, file.name == name ? FileState::damaged : FileState::sound) << file.name;
    if (name.starts_with("unfinished")) {
      EXPECT_THROW(resume_run(scene, scratch / "out"), IoError);
      EXPECT_EQ(read_text(scratch / "out" / name) == bytes, true) << "nothing was changed";
      EXPECT_EQ(read_text(scratch / "out/summary.json") == whole, true);
    }
    write(scratch / "out" / name, sound);
  }
  // Once its files have taken their places, their checksums are those of the result.
  EXPECT_EQ(resume_run(scene, scratch / "out").outcome.ending, Ending::completed);
  const auto names = names_in(scratch / "out");
  EXPECT_TRUE(std::ranges::none_of(names, [](const std::string& name) { return name.starts_with("unfinished"); }));
  for (const VerifiedFile& file : verify_result(scratch / "out")) EXPECT_EQ(file.state, FileState::sound) << file.name;
}

// Else the checkpoints of a stopped run would go as those of a whole one.
TEST_F(Damage, OfASummaryThatIsAnotherRunsLosesNoCheckpoint) {
  stop_in_the_middle(scratch / "out");
  record_run(scene, scratch / "other");
  fs::copy_file(scratch / "other/summary.json", scratch / "out/summary.json", fs::copy_options::overwrite_existing);
  EXPECT_THROW(clear_whole_run(scratch / "out"), IoError);
  EXPECT_EQ(state_of("checkpoint.bin", scratch / "out"), FileState::sound);
}

// The tests are a program of their own, with the same library.
TEST_F(Damage, IsNotRiskedByResumingWithAnotherBuild) {
  stop_in_the_middle(scratch / "out");
  EXPECT_EQ(run({"resume", "out"}), 1);
  EXPECT_NE(err().find("was made by another build of version"), std::string::npos) << err();
  EXPECT_NE(err().find("nothing was changed"), std::string::npos) << err();
  EXPECT_EQ(resume_run(scene, scratch / "out").outcome.ending, Ending::completed);
}

// The sound part of three days of computing must not make place for a new beginning.
TEST_F(Damage, NeverLetsAResumedRunBeginAnew) {
  RecordOptions options;
  options.checkpoint = CheckpointEvery{CheckpointEvery::Clock::simulated, 1.0};
  double reached = 0.0;
  options.progress = [&](double time, std::size_t) { reached = time; };
  options.stop = [&] { return reached > 1.5; };  // of the checkpoints before, one is that of the beginning
  record_run(scene, scratch / "out", options);
  std::string bytes = read_text(scratch / "out/ends.csv");
  bytes[100] ^= 1;
  write(scratch / "out/ends.csv", bytes);
  EXPECT_THROW(resume_run(scene, scratch / "out"), IoError);
  EXPECT_EQ(read_text(scratch / "out/ends.csv"), bytes);
}

class DamagedSweep : public Damage {
 protected:
  DamagedSweep() {
    write(scratch / "sweep.toml",
          "scene = \"scene.toml\"\n[set]\ntime.end = 0.3\n[vary]\nbar.viscosity = [0.1, 0.2, 0.3, 0.4]\n"
          "mesh.mass = [\"lumped\", \"redistributed\"]\n");
    EXPECT_EQ(run({"sweep", "sweep.toml", "--quiet", "-o", "out"}), 0) << err();
  }
  /// How often each kind of damage is done.
  static constexpr std::size_t times = 40;
};

TEST_F(DamagedSweep, IsNoticedInEveryFile) { expect_noticed_in_every_file(scratch / "out", 5 * times); }

TEST_F(DamagedSweep, IsNoticedWhereItsRowsAreGone) {
  std::filesystem::remove(scratch / "out/sweep.h5");
  EXPECT_EQ(run({"info", "--verify", "out"}), 1);
}

TEST_F(DamagedSweep, IsComputedAgainOrRefusedNeverKept) {
  const std::string sound = read_text(scratch / "out/sweep.h5"), rows = read_text(scratch / "out/sweep.csv");
  const SweepFile sweep = read_sweep(scratch / "sweep.toml");
  std::size_t again = 0;
  for (std::size_t i = 0; i < times; ++i) {
    write(scratch / "out/sweep.h5", vandal.damaged_in_place(sound));
    const int code = run({"sweep", "sweep.toml", "--quiet", "-o", "out"});
    if (code == 0) {
      ++again;
      EXPECT_EQ(read_text(scratch / "out/sweep.csv") == rows, true) << i;
      EXPECT_EQ(verdict(verify_result(scratch / "out")), FileState::sound);
    } else {
      EXPECT_EQ(code, 1) << err();
      EXPECT_NE(err().find("sweep.h5"), std::string::npos) << err();
    }
  }
  EXPECT_GT(again, times / 4);
}

// These tests are another build than the program that made the table.
TEST_F(DamagedSweep, IsToldFromOneThatAnotherBuildBegan) {
  std::string complaint;
  const SweepResults results(scratch / "out", read_sweep(scratch / "sweep.toml"),
                             [&](const std::string& what) { complaint = what; });
  EXPECT_EQ(results.size(), 8u);
  EXPECT_NE(complaint.find("sweep.h5: begun by another build of viscobar"), std::string::npos) << complaint;
}

TEST_F(DamagedSweep, SaysWhichCasesRunAgain) {
  std::string bytes = read_text(scratch / "out/sweep.h5");
  const std::size_t row = bytes.find("redistributed", bytes.find("redistributed", 2048) + 1);  // of case 3
  ASSERT_NE(row, bytes.npos);
  bytes[row] = 'R';
  write(scratch / "out/sweep.h5", bytes);
  EXPECT_EQ(run({"sweep", "sweep.toml", "--json", "-o", "out"}), 0);
  EXPECT_NE(err().find("1 of the rows are damaged, and their cases are run again: 3"), std::string::npos) << err();
  EXPECT_EQ(nlohmann::json::parse(read_text(scratch / "out.txt"))["run"], 1);
}

}  // namespace
}  // namespace viscobar::testing_damage
