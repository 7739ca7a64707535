// Other files and other processes in a directory of results: nothing that was whole is lost, nothing that is not ours
// touched.
#include "results/result_directory.hpp"

#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <map>
#include <nlohmann/json.hpp>

#include "results/checkpoint_file.hpp"
#include "support/file_size_limit.hpp"
#include "support/scratch.hpp"
#include "viscobar/record/record_run.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {
namespace {

namespace fs = std::filesystem;

constexpr const char* files_of_a_run[] = {"summary.json", "ends.csv",   "events.csv", "energy.csv",
                                          "field.h5",     "field.xdmf", "report.html"};

/// Every file below a directory, with its content; a link with where it points.
std::map<std::string, std::string> all_of(const fs::path& directory) {
  std::map<std::string, std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    const std::string name = fs::relative(entry.path(), directory).string();
    if (entry.is_symlink())
      all[name] = fs::read_symlink(entry.path()).string();
    else if (entry.is_regular_file())
      all[name] = read_text(entry.path());
    else
      all[name] = "";
  }
  return all;
}

SceneFile shorter() {
  SceneFile scene = bouncing_bar();
  scene.run.end = 0.5;
  return scene;
}

std::size_t rows(const fs::path& directory) { return read_lines(directory / "ends.csv").size() - 1; }

bool completed(const fs::path& directory) {
  return nlohmann::json::parse(read_text(directory / "summary.json"))["completed"];
}

RecordOptions stopped_after(std::size_t steps) {
  RecordOptions options;
  options.stop = [steps, count = std::size_t{0}]() mutable { return ++count > steps; };
  return options;
}

class ResultDirectories : public testing::Test {
 protected:
  void expect_refused(const std::string& words) const {
    const auto before = all_of(scratch.path());
    try {
      record_run(shorter(), out);
      ADD_FAILURE() << "went on in spite of: " << words;
    } catch (const std::exception& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
    EXPECT_TRUE(all_of(scratch.path()) == before) << words;
  }

  const Scratch scratch;
  const fs::path out = scratch / "out";
};

TEST_F(ResultDirectories, AreOfOneRunAtATimeAndTheSecondTouchesNothing) {
  RecordOptions options;
  bool tried = false;
  options.progress = [&](double time, std::size_t) {
    if (time < 0.5 || tried) return;
    tried = true;
    expect_refused("is in use by viscobar, process " + std::to_string(getpid()));
  };
  EXPECT_EQ(record_run(bouncing_bar(), out, options).outcome.ending, Ending::completed);
  EXPECT_TRUE(tried);
  EXPECT_EQ(rows(out), 101u);
  EXPECT_FALSE(fs::exists(out / DirectoryLock::file_name));
}

TEST_F(ResultDirectories, AreFreeAgainAfterAKill) {
  const pid_t child = fork();
  if (child == 0) {
    RecordOptions options;
    options.progress = [](double, std::size_t) { raise(SIGKILL); };
    record_run(bouncing_bar(), out, options);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_TRUE(fs::exists(out / DirectoryLock::file_name));
  EXPECT_EQ(record_run(bouncing_bar(), out).outcome.ending, Ending::completed);
  EXPECT_EQ(all_of(out).size(), std::size(files_of_a_run));
}

// The one who held the lock removed its file just when another had opened it.
TEST_F(ResultDirectories, ALockOnAFileThatIsGoneIsNone) {
  fs::create_directory(out);
  { const DirectoryLock first(out); }
  EXPECT_FALSE(fs::exists(out / DirectoryLock::file_name));
  const DirectoryLock held(out);
  EXPECT_TRUE(held.held());
  EXPECT_THROW(DirectoryLock{out}, DirectoryInUse);
}

TEST_F(ResultDirectories, AWholeResultStaysUntilTheNextOneIsWhole) {
  record_run(bouncing_bar(), out);
  const auto before = all_of(out);
  RecordOptions options;
  options.progress = [&](double time, std::size_t) {
    if (time < 0.25) return;
    for (const char* file : files_of_a_run) ASSERT_TRUE(read_text(out / file) == before.at(file)) << file;
    EXPECT_FALSE(completed(out / "unfinished"));
  };
  const RunRecord record = record_run(shorter(), out, options);
  EXPECT_EQ(record.outcome.ending, Ending::completed);
  EXPECT_EQ(record.directory, out);
  EXPECT_EQ(rows(out), 51u);
  EXPECT_EQ(read_text(out / "summary.json"), record.summary);
  EXPECT_EQ(all_of(out).size(), std::size(files_of_a_run));
}

TEST_F(ResultDirectories, WhatStopsEarlyLeavesTheWholeResultAndResumesToItsPlace) {
  record_run(shorter(), out);
  const auto before = all_of(out);
  const RunRecord stopped = record_run(bouncing_bar(), out, stopped_after(50));
  EXPECT_EQ(stopped.outcome.ending, Ending::interrupted);
  EXPECT_EQ(stopped.directory, out / "unfinished");
  for (const char* file : files_of_a_run) EXPECT_TRUE(read_text(out / file) == before.at(file)) << file;

  // A run that begins anew takes the place of the unfinished one, not of the whole one.
  record_run(bouncing_bar(), out, stopped_after(20));
  for (const char* file : files_of_a_run) EXPECT_TRUE(read_text(out / file) == before.at(file)) << file;

  EXPECT_THROW(resume_run(bouncing_bar(), out / "unfinished"), std::invalid_argument);
  EXPECT_THROW(record_run(bouncing_bar(), out / "unfinished"), std::invalid_argument);
  EXPECT_EQ(resume_run(bouncing_bar(), out).outcome.ending, Ending::completed);
  EXPECT_EQ(rows(out), 101u);
  EXPECT_EQ(all_of(out).size(), std::size(files_of_a_run));
  EXPECT_THROW(resume_run(bouncing_bar(), out), std::invalid_argument);
}

TEST_F(ResultDirectories, AResumedRunRemovesWhatAKilledNewOneHadBegun) {
  record_run(shorter(), out, stopped_after(20));
  for (const char* file : files_of_a_run) std::ofstream(out / (std::string(file) + ".part")) << "begun";
  EXPECT_EQ(resume_run(shorter(), out).outcome.ending, Ending::completed);
  EXPECT_EQ(all_of(out).size(), std::size(files_of_a_run));
}

TEST_F(ResultDirectories, ARunThatFailsForAFullDiskLeavesTheWholeResult) {
  record_run(shorter(), out);
  const auto before = all_of(out);
  for (const rlim_t bytes : {0, 100, 2'000, 10'000, 60'000}) {
    const FileSizeLimit full(bytes);
    try {
      EXPECT_NE(record_run(bouncing_bar(), out).outcome.ending, Ending::completed) << bytes;
    } catch (const IoError&) {
    }
    for (const char* file : files_of_a_run) ASSERT_TRUE(read_text(out / file) == before.at(file)) << bytes << file;
  }
  EXPECT_EQ(record_run(bouncing_bar(), out).outcome.ending, Ending::completed);
  EXPECT_EQ(all_of(out).size(), std::size(files_of_a_run));
}

// Also in the moment between the end of the run and that of the command.
TEST_F(ResultDirectories, AFileThatIsMissingAtTheEndIsNotTakenFromTheResultBefore) {
  record_run(bouncing_bar(), out);
  const auto before = all_of(out);
  for (const char* file : {"ends.csv", "events.csv", "energy.csv", "field.h5", "field.xdmf", "report.html"}) {
    const ResultDirectory directory(out, ResultKind::run);
    record_run(shorter(), scratch / "next");
    fs::rename(scratch / "next", directory.place_of_new_run());
    fs::copy(out / "unfinished/summary.json", out / "unfinished" / ResultDirectory::final_summary);
    fs::remove(out / "unfinished" / file);
    EXPECT_THROW(directory.replace_by_finished(), IoError) << file;
    for (const char* kept : files_of_a_run) EXPECT_TRUE(read_text(out / kept) == before.at(kept)) << kept;
    fs::remove_all(out / "unfinished");
  }
}

// The renames of a finished run, ended by a kill before each of them.
TEST_F(ResultDirectories, AKillWhileTheFilesTakeTheirPlacesIsMadeGoodByTheNext) {
  for (std::size_t moved = 0; moved <= 8; ++moved) {
    SCOPED_TRACE(moved);
    fs::remove_all(out);
    record_run(shorter(), out);
    record_run(bouncing_bar(), scratch / "finished");
    fs::rename(scratch / "finished", out / "finished");
    fs::rename(out / "finished/summary.json", out / "finished" / ResultDirectory::final_summary);
    std::ofstream(out / "finished/summary.json")
        << R"({"versions": {"viscobar": ""}, "method": "", "completed": false})";
    const auto whole = all_of(out / "finished");
    const char* order[] = {"summary.json", "ends.csv",   "events.csv",  "energy.csv",
                           "field.h5",     "field.xdmf", "report.html", ResultDirectory::final_summary};
    for (std::size_t i = 0; i < moved; ++i) {
      fs::rename(out / "finished" / order[i], out / (i == 7 ? "summary.json" : order[i]));
      if (i < 7) {
        EXPECT_FALSE(completed(out));
      }
    }
    settle_result_directory(out);
    EXPECT_TRUE(completed(out));
    EXPECT_EQ(all_of(out).size(), std::size(files_of_a_run));
    for (const char* file : {"ends.csv", "events.csv", "energy.csv", "field.h5", "field.xdmf", "report.html"})
      EXPECT_TRUE(read_text(out / file) == whole.at(file)) << file;
    EXPECT_TRUE(read_text(out / "summary.json") == whole.at(ResultDirectory::final_summary));
  }
}

TEST_F(ResultDirectories, ACheckpointBesideAWholeResultIsNoRunToGoOnWith) {
  record_run(bouncing_bar(), out, stopped_after(20));
  fs::copy(out, scratch / "stopped");
  resume_run(bouncing_bar(), out);
  fs::copy(scratch / "stopped/checkpoint.bin", out);  // killed before it was removed
  const auto before = all_of(out);
  EXPECT_THROW(scene_of_checkpoint(out), std::invalid_argument);
  EXPECT_THROW(resume_run(bouncing_bar(), out), std::invalid_argument);
  EXPECT_TRUE(all_of(out) == before);
  record_run(shorter(), out);
  EXPECT_EQ(all_of(out).size(), std::size(files_of_a_run));
}

TEST_F(ResultDirectories, AreRecognisedByTheirContent) {
  fs::create_directory(out);
  for (const char* summary : {"", "{}", "title = \"a scene\"\n", "{\"name\": \"web\", \"version\": \"1\"}"})
    for (const char* name : {"summary.json", "compare.json", "limit.json", "precision.json", "sweep.h5"}) {
      fs::remove_all(out);
      fs::create_directory(out);
      std::ofstream(out / name) << summary;
      std::ofstream(out / "report.html") << "thesis";
      std::ofstream(out / "checkpoint.bin") << "mine";
      expect_refused("holds files and no result of viscobar");
    }
}

TEST_F(ResultDirectories, OfAnotherCommandMayHoldNoFilesInTheWay) {
  fs::create_directory(out);
  std::ofstream(out / "compare.json") << R"({"version": "0.1.0", "pairs": []})";
  std::ofstream(out / "report.html") << "thesis";
  expect_refused("report.html");
  fs::remove(out / "report.html");
  record_run(shorter(), out);
  EXPECT_EQ(all_of(out).size(), 1 + std::size(files_of_a_run));
}

TEST_F(ResultDirectories, WhatIsNoFileInTheWayIsRefused) {
  record_run(bouncing_bar(), out);
  std::ofstream(scratch / "elsewhere") << "mine";
  for (const char* name : files_of_a_run) {
    if (std::string(name) == "summary.json") continue;
    SCOPED_TRACE(name);
    fs::rename(out / name, scratch / name);
    fs::create_symlink(scratch / "elsewhere", out / name);
    expect_refused("is a symbolic link");
    fs::remove(out / name);
    ASSERT_EQ(mkfifo((out / name).c_str(), 0666), 0);
    expect_refused("is no regular file");
    fs::remove(out / name);
    fs::create_directory(out / name);
    expect_refused("is no regular file");
    fs::remove(out / name);
    fs::rename(scratch / name, out / name);
  }
  for (const char* name : {"unfinished", "finished"}) {
    fs::create_directory_symlink(scratch.path(), out / name);
    expect_refused("is not of viscobar");
    fs::remove(out / name);
    fs::create_directory(out / name);
    std::ofstream(out / name / "notes") << "mine";
    expect_refused("is not of viscobar");
    fs::remove_all(out / name);
  }
}

TEST_F(ResultDirectories, AReaderThatHoldsALockLosesNothingAndStopsNobody) {
  record_run(bouncing_bar(), out);
  const int reader = open((out / "field.h5").c_str(), O_RDONLY);
  ASSERT_EQ(flock(reader, LOCK_SH), 0);
  const std::string field = read_text(out / "field.h5");
  EXPECT_EQ(record_run(shorter(), out).outcome.ending, Ending::completed);
  EXPECT_EQ(rows(out), 51u);
  std::string kept(field.size(), '\0');
  EXPECT_EQ(pread(reader, kept.data(), kept.size(), 0), static_cast<ssize_t>(kept.size()));
  EXPECT_TRUE(kept == field);
  close(reader);
}

/// Exit code of the action in a process without the rights of root.
template <class Action>
int as_nobody(Action&& action) {
  const pid_t child = fork();
  if (child == 0) {
    if (getuid() == 0 && setuid(65534) != 0) _exit(99);
    _exit(action());
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_F(ResultDirectories, AFileThatMayNotBeWrittenIsNamedAndNothingChanged) {
  fs::permissions(scratch.path(), fs::perms::all);
  const auto run = [&] {
    try {
      record_run(shorter(), out);
      return 0;
    } catch (const IoError& error) {
      return error.file == out / "events.csv" ? 1 : 2;
    }
  };
  ASSERT_EQ(as_nobody(run), 0);
  fs::permissions(out / "events.csv", fs::perms::owner_read);
  const auto before = all_of(out);
  EXPECT_EQ(as_nobody(run), 1);
  EXPECT_TRUE(all_of(out) == before);
}

TEST_F(ResultDirectories, ThatTakeNoFilesAreNamed) {
  fs::permissions(scratch.path(), fs::perms::all);
  ASSERT_EQ(as_nobody([&] { return record_run(shorter(), out), 0; }), 0);
  fs::permissions(out, fs::perms::owner_read | fs::perms::owner_exec);
  const auto before = all_of(out);
  EXPECT_EQ(as_nobody([&] {
              try {
                record_run(shorter(), out);
                return 0;
              } catch (const IoError& error) {
                return error.file == out ? 1 : 2;
              }
            }),
            1);
  EXPECT_TRUE(all_of(out) == before);
  fs::permissions(out, fs::perms::owner_all);
}

}  // namespace
}  // namespace viscobar
