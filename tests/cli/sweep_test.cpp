#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <chrono>
#include <cstdlib>
#include <map>
#include <optional>
#include <random>
#include <thread>

#include "cli/command.hpp"
#include "cli/terminal.hpp"
#include "sweep/sweep_results.hpp"

namespace viscobar::testing_cli {
namespace {

using Json = nlohmann::json;

/// A hundred cases, the longest of which take a hundred times as long as the shortest.
class Sweep : public Command {
 protected:
  Sweep() {
    write("sweep.toml",
          "scene = \"" VISCOBAR_SOURCE_DIR
          "/examples/scenes/chatter.toml\"\n[set]\ntime.end = 3.0\n[vary]\nbar.viscosity = [1.0, 0.01, 0.001]\n"
          "contact.epsilon = { from = 1e-2, to = 1e-6, per_decade = 2 }\n"
          "method.name = [\"cvode\", \"ida\", \"fully_discrete\", \"finite_difference\"]\n");
  }

  void write(const std::string& name, const std::string& text) const { std::ofstream(directory_ / name) << text; }

  std::string table(const std::string& where) const { return read_text(directory_ / where / "sweep.csv"); }

  /// The rows that are safe now, and how long each took: another number is another run.
  std::map<std::size_t, double> kept(const std::string& where) const {
    const SweepFile sweep = read_sweep(directory_ / "sweep.toml");
    std::map<std::size_t, double> seconds;
    const SweepResults results(directory_ / where, sweep);
    for (const SweepRow* row : results.rows()) seconds[row->index] = row->seconds;
    return seconds;
  }

  /// Starts so many processes at once, with the variables by which mpirun tells each its rank; the number that failed.
  int in_a_job(int ranks, const std::string& arguments) const {
    return std::system(
               fmt::format("cd '{}' || exit 99; for rank in $(seq 0 {}); do OMPI_COMM_WORLD_SIZE={} "
                           "OMPI_COMM_WORLD_RANK=$rank '" VISCOBAR_COMMAND "' {} & all=\"$all $!\"; done; "
                           "failed=0; for one in $all; do wait $one || failed=$((failed+1)); done; exit $failed",
                           directory_.string(), ranks - 1, ranks, arguments)
                   .c_str()) >>
           8;
  }

  /// Starts a sweep, sends it the signal as soon as `wait` returns; its exit code, or minus the signal that ended it.
  template <class Wait>
  int stopped_by(int signal, const std::string& arguments, Wait wait) const {
    const pid_t child = fork();
    if (child == 0) {
      if (chdir(directory_.c_str()) != 0) _exit(99);
      if (!freopen("/dev/null", "w", stdout) || !freopen("/dev/null", "w", stderr)) _exit(99);
      execl("/bin/sh", "sh", "-c", ("exec '" VISCOBAR_COMMAND "' " + arguments).c_str(), nullptr);
      _exit(99);
    }
    wait();
    kill(child, signal);
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
};

TEST_F(Sweep, ATerminalSeesHowManyCasesAreDoneAndHowLongTheOthersTake) {
  const auto shown = [&](const std::string& option) {
    return shown_on_terminal("cd '" + directory_.string() + "' && '" VISCOBAR_COMMAND "' sweep sweep.toml" + option +
                             " >out.txt");
  };
  // The line appears after a second; all cases to time 3 at once take 0.3.
  const std::string text = shown(" --set time.end=30 --threads 1 -o seen");
  EXPECT_NE(text.find(" of 108 cases  "), std::string::npos) << text;
  EXPECT_NE(text.find(" s left"), std::string::npos) << text;
  EXPECT_TRUE(text.ends_with("\r\033[K")) << text;  // nothing stays
  EXPECT_EQ(shown(" -o unseen --quiet"), "");
}

/// Processor time of the processes that this one has waited for.
double seconds_of_children() {
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

// Both are processor times of one and the same run: a busy machine slows both alike. The best of a few runs, where it
// did not. The start of a process is no part of it: with MPI, which SUNDIALS loads on Debian 13, it takes a tenth of a
// second.
TEST_F(Sweep, OfSmallCasesTakesAtMostThreeTenthsMoreThanItsIntegration) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "of the program as it is used";
#endif
  double best = 10.0;
  for (int k = 0; k < 8 && best > 1.3; ++k) {
    const double begin = seconds_of_children();
    ASSERT_EQ(viscobar("--version").code, 0);
    const double before = seconds_of_children(), start = before - begin;
    const Ended ended = viscobar(fmt::format(
        "sweep '" VISCOBAR_SOURCE_DIR "/examples/sweeps/small-cases.toml' --threads 1 --json -o small{}", k));
    ASSERT_EQ(ended.code, 0) << ended.error;
    const double all = seconds_of_children() - before - start;
    best = std::min(best, all / ended.json()["integration_seconds"].get<double>());
  }
  double load = 0.0;
  if (best > 1.3 && getloadavg(&load, 1) == 1 && load > 2.0 * std::thread::hardware_concurrency())
    GTEST_SKIP() << best << " beside so much other work that caches are not its own";
  EXPECT_LE(best, 1.3);
}

TEST_F(Sweep, RowsDoNotDependOnTheNumberOfThreads) {
  ASSERT_EQ(viscobar("sweep sweep.toml --threads 1 -o one").code, 0);
  ASSERT_EQ(viscobar("sweep sweep.toml --threads 2 -o two").code, 0);
  ASSERT_EQ(viscobar("sweep sweep.toml --threads 5 -o five").code, 0);
  EXPECT_EQ(table("one"), table("two"));
  EXPECT_EQ(table("one"), table("five"));
  EXPECT_EQ(kept("one").size(), 108u);
}

TEST_F(Sweep, RowsDoNotDependOnTheNumberOfRanks) {
  ASSERT_EQ(viscobar("sweep sweep.toml --threads 1 -o one").code, 0);
  for (const int ranks : {1, 2, 3}) {
    const std::string place = fmt::format("ranks{}", ranks);
    ASSERT_EQ(in_a_job(ranks, "sweep sweep.toml --json -o " + place + " >>said.txt"), 0);
    EXPECT_EQ(table("one"), table(place));
    // One of them puts the rows together, and speaks.
    const std::string said = read_text(directory_ / "said.txt");
    const Json summary = Json::parse(said);
    EXPECT_EQ(summary["done"], 108);
    EXPECT_EQ(summary["run"], 108);
    EXPECT_TRUE(summary["part"].is_null());
    fs::remove(directory_ / "said.txt");
  }
  // Begun by three, it goes on with two, which run nothing again.
  fs::remove_all(directory_ / "ranks3/part-2-of-3");
  for (const char* file : {"sweep.h5", "sweep.json", "sweep.csv", "timings.csv", "sweep.html"})
    fs::remove(directory_ / "ranks3" / file);
  const auto before = kept("ranks3/part-1-of-3");
  ASSERT_EQ(in_a_job(2, "sweep sweep.toml --quiet -o ranks3"), 0);
  EXPECT_EQ(table("one"), table("ranks3"));
  const auto after = kept("ranks3");
  for (const auto& [index, seconds] : before) EXPECT_EQ(after.at(index), seconds) << index;
}

TEST_F(Sweep, PartsArePutTogetherAndTheMissingOnesRun) {
  ASSERT_EQ(viscobar("sweep sweep.toml --quiet -o one").code, 0);
  std::size_t cases = 0;
  for (const char* part : {"1/4", "2/4", "4/4"}) {
    const Ended ended = viscobar(fmt::format("sweep sweep.toml --json -o parts --part {}", part));
    ASSERT_EQ(ended.code, 0) << ended.error;
    EXPECT_EQ(ended.json()["part"], part);
    EXPECT_EQ(ended.json()["cases"], ended.json()["done"]);
    cases += ended.json()["cases"].get<std::size_t>();
  }
  EXPECT_EQ(cases, 81u);
  const auto second = kept("parts/part-2-of-4");
  const Ended again = viscobar("sweep sweep.toml --json -o parts --part 2/4");
  EXPECT_EQ(again.json()["run"], 0);
  const Ended whole = viscobar("sweep sweep.toml --json -o parts");
  ASSERT_EQ(whole.code, 0) << whole.error;
  EXPECT_EQ(whole.json()["done"], 108);
  EXPECT_EQ(table("parts"), table("one"));
  const auto all = kept("parts");
  for (const auto& [index, seconds] : second) EXPECT_EQ(all.at(index), seconds) << index;
  EXPECT_EQ(viscobar("info --verify parts").code, 0);
  EXPECT_EQ(viscobar("info --verify parts/part-4-of-4").code, 0);

  // A part without a case, or with such as cannot run, ends as others do.
  write("one.toml",
        "scene = \"" VISCOBAR_SOURCE_DIR "/examples/scenes/chatter.toml\"\n[vary]\nbar.viscosity = [1.0]\n");
  for (const char* part : {"1/2", "2/2"})
    EXPECT_EQ(viscobar(std::string("sweep one.toml --quiet -o few --part ") + part).code, 0) << part;
  EXPECT_EQ(viscobar("sweep one.toml --quiet -o few").code, 0);
  write("some.toml", "scene = \"" VISCOBAR_SOURCE_DIR
                     "/examples/scenes/chatter.toml\"\n[vary]\nmethod.name = [\"cvode\", "
                     "\"characteristics\"]\n");
  for (const char* part : {"1/2", "2/2"})
    EXPECT_LE(viscobar(std::string("sweep some.toml -o some --part ") + part).code, 1);
  EXPECT_EQ(viscobar("sweep some.toml --json -o some").json()["done"], 2);

  // The wrong command makes nothing that would be in the way of the right one.
  ASSERT_EQ(viscobar("sweep sweep.toml --quiet --set time.end=2 -o ended --part 1/2").code, 0);
  EXPECT_EQ(viscobar("sweep sweep.toml --quiet -o ended").code, 2);
  EXPECT_EQ(viscobar("sweep sweep.toml --quiet --set time.end=2 -o ended").code, 0);
  fs::create_directories(directory_ / "notes");
  write("notes/notes.txt", "years");
  EXPECT_EQ(viscobar("sweep sweep.toml --quiet -o notes --part 1/2").code, 2);
  EXPECT_FALSE(fs::exists(directory_ / "notes/part-1-of-2"));

  const Ended other = viscobar("sweep sweep.toml --set time.end=2 -o parts --part 3/4");
  EXPECT_EQ(other.code, 2);
  EXPECT_NE(other.error.find("another sweep"), std::string::npos) << other.error;
  for (const char* wrong : {"0/4", "5/4", "4", "a/b", "1/0", "-1/4"}) {
    const Ended ended = viscobar(fmt::format("sweep sweep.toml -o wrong --part={}", wrong));
    EXPECT_EQ(ended.code, 2) << wrong;
    EXPECT_NE(ended.error.find("is no part of a sweep"), std::string::npos) << wrong << ended.error;
  }
  EXPECT_FALSE(fs::exists(directory_ / "wrong"));
}

TEST_F(Sweep, KilledAtAnyMomentItGoesOnAndRepeatsNothing) {
  ASSERT_EQ(viscobar("sweep sweep.toml -o whole").code, 0);
  std::mt19937 random(std::random_device{}());
  std::uniform_int_distribution<int> pause(1, 120);
  std::map<std::size_t, double> before;
  int kills = 0;
  for (; kills < 200; ++kills) {
    const std::chrono::milliseconds after(pause(random));
    const int end =
        stopped_by(SIGKILL, "sweep sweep.toml --quiet -o killed", [&] { std::this_thread::sleep_for(after); });
    if (end == 0) break;
    ASSERT_EQ(end, -SIGKILL);
    if (!fs::exists(directory_ / "killed/sweep.h5")) continue;
    const auto now = kept("killed");
    for (const auto& [index, seconds] : before) {
      ASSERT_TRUE(now.contains(index)) << "case " << index << " was lost by kill " << kills;
      EXPECT_EQ(now.at(index), seconds) << "case " << index << " was run again";
    }
    before = now;
  }
  const Ended last = viscobar("sweep sweep.toml --json -o killed");
  ASSERT_EQ(last.code, 0) << last.error;
  EXPECT_EQ(last.json()["done"], 108);
  EXPECT_GT(kills, 1) << "the sweep was over before it could be killed";
  EXPECT_EQ(table("killed"), table("whole"));
  const auto at_the_end = kept("killed");
  for (const auto& [index, seconds] : before) EXPECT_EQ(at_the_end.at(index), seconds);
}

TEST_F(Sweep, KilledWhileItMadeItsTableItBeginsAnew) {
  fs::create_directories(directory_ / "sweep.out");
  write("sweep.out/sweep.h5.part", "half a table");
  EXPECT_EQ(viscobar("sweep sweep.toml --quiet").code, 0);
}

TEST_F(Sweep, AFinishedSweepRunsNothingAgain) {
  ASSERT_EQ(viscobar("sweep sweep.toml").code, 0);
  const auto before = kept("sweep.out");
  const Ended again = viscobar("sweep sweep.toml --json");
  ASSERT_EQ(again.code, 0) << again.error;
  EXPECT_EQ(again.json()["run"], 0);
  EXPECT_EQ(again.json()["kept"], 108);
  EXPECT_EQ(kept("sweep.out"), before);
}

TEST_F(Sweep, InterruptedItKeepsItsRowsAndSays130) {
  write("long.toml", "scene = \"" VISCOBAR_SOURCE_DIR
                     "/examples/scenes/chatter.toml\"\n[set]\nmethod.name = \"fully_discrete\"\ntime.end = "
                     "1e6\noutput.every = 1e5\n[vary]\n"
                     "bar.viscosity = [1.0, 0.1, 0.01]\nmethod.step = [1e2, 1e-6]\n");
  std::string rows;
  std::chrono::steady_clock::time_point interrupted;
  const auto the_short_cases = [&] {  // for ten minutes at most: valgrind
    for (int i = 0; i < 6000 && std::count(rows.begin(), rows.end(), '\n') < 4; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      rows = read_text(directory_ / "long.out/sweep.csv");
    }
    interrupted = std::chrono::steady_clock::now();
  };
  EXPECT_EQ(stopped_by(SIGINT, "sweep long.toml --threads 4", the_short_cases), 130);
  EXPECT_LT(std::chrono::steady_clock::now() - interrupted, std::chrono::seconds(20));
  rows = read_text(directory_ / "long.out/sweep.csv");
  // The three short cases, and the heading.
  EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 4) << rows;
}

TEST_F(Sweep, AFailedCaseIsARowAndTheOthersGoOn) {
  write("some.toml", "scene = \"" VISCOBAR_SOURCE_DIR
                     "/examples/scenes/chatter.toml\"\n[set]\nload.density = \"t > 1 ? 1/(t-t) : 0\"\n[vary]\n"
                     "time.end = [0.5, 2.0]\nmesh.mass = [\"lumped\", \"redistributed\"]\n"
                     "method.name = [\"cvode\", \"finite_difference\"]\n");
  const Ended ended = viscobar("sweep some.toml --json");
  EXPECT_EQ(ended.code, 1);
  const Json summary = ended.json();
  EXPECT_EQ(summary["done"], 8);
  // At t > 1 the load is infinite; finite_difference does not take the redistributed mass.
  std::vector<std::size_t> failed;
  for (const Json& one : summary["failed"]) {
    failed.push_back(one["index"]);
    EXPECT_NE(one["error"], "");
  }
  EXPECT_EQ(failed, (std::vector<std::size_t>{3, 4, 5, 6, 7}));
  const std::string rows = read_text(directory_ / "some.out/sweep.csv");
  EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 9);
  EXPECT_NE(rows.find("does not fit finite_difference"), std::string::npos);
  EXPECT_EQ(viscobar("sweep some.toml --quiet").code, 1) << "they are still failed, and not tried again";
}

TEST_F(Sweep, WrongInputIsSaidAndNothingWritten) {
  write("wrong.toml", "scene = \"none.toml\"\n[vary]\nbar.viscosty = [1]\n");
  const Ended ended = viscobar("sweep wrong.toml");
  EXPECT_EQ(ended.code, 2);
  EXPECT_EQ(ended.out, "");
  EXPECT_NE(ended.error.find("wrong.toml:1:9: scene: "), std::string::npos) << ended.error;
  EXPECT_NE(ended.error.find("nearest is \"viscosity\""), std::string::npos) << ended.error;
  EXPECT_FALSE(fs::exists(directory_ / "wrong.out"));
  EXPECT_EQ(viscobar("sweep sweep.toml --set bar.viscosity=1").code, 2);
  EXPECT_EQ(viscobar("sweep sweep.toml --threads 0").code, 2);
  EXPECT_EQ(viscobar("sweep").code, 2);
}

TEST_F(Sweep, NeverWritesIntoADirectoryOfOthersNorOfAnotherSweep) {
  fs::create_directories(directory_ / "precious");
  write("precious/thesis.tex", "years");
  EXPECT_EQ(viscobar("sweep sweep.toml -o precious").code, 2);
  EXPECT_FALSE(fs::exists(directory_ / "precious/sweep.h5"));
  ASSERT_EQ(viscobar("sweep sweep.toml --quiet").code, 0);
  const std::string before = table("sweep.out");
  const Ended other = viscobar("sweep sweep.toml --set time.end=2");
  EXPECT_EQ(other.code, 2);
  EXPECT_NE(other.error.find("another sweep"), std::string::npos) << other.error;
  EXPECT_EQ(table("sweep.out"), before);
}

}  // namespace
}  // namespace viscobar::testing_cli
