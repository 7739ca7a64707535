#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/commands.hpp"
#include "results/file_set.hpp"
#include "results/result_directory.hpp"
#include "run/stopwatch.hpp"
#include "studies/parallel.hpp"
#include "sweep/sweep_page.hpp"
#include "sweep/sweep_part.hpp"
#include "sweep/sweep_results.hpp"
#include "sweep/sweep_workers.hpp"

namespace viscobar::cli {

namespace {

namespace fs = std::filesystem;

/// How far the sweep is, on the terminal, by the costs that were estimated.
class SweepProgress {
 public:
  SweepProgress(std::span<const double> costs, const SweepQueue& queue, std::size_t cases)
      : costs_(costs), cases_(cases), done_(cases - queue.size()), total_(queue.seconds()) {}

  void count(const SweepRow& row) {
    ++done_;
    if (!row.completed) ++failed_;
    finished_ += costs_[row.index];
  }

  void show() {
    if (!progress_.due()) return;
    const std::string failed = failed_ > 0 ? fmt::format(", {} failed", failed_) : "";
    progress_.show(fmt::format("{} of {} cases{}", done_, cases_, failed), finished_ / total_);
  }

 private:
  std::span<const double> costs_;
  std::size_t cases_, done_, failed_ = 0;
  double total_, finished_ = 0.0;
  Progress progress_;
};

struct SweepOptions {
  std::string file, error, part;
  std::vector<std::string> overrides;
  bool json = false;
  OutputOptions output;
  std::size_t threads = 0;

  explicit SweepOptions(CLI::App& command) : output(command) {}
};

/// A process' share of a sweep, and where its rows are.
struct SweepJob {
  SweepPart part;
  fs::path whole;            // the directory of the whole sweep
  bool by_launcher = false;  // one of several processes that mpirun or a like started

  fs::path directory() const { return part.of == 1 ? whole : whole / part.name(); }
  std::string words() const { return part.of == 1 ? "" : fmt::format(" of part {}/{}", part.number, part.of); }
};

nlohmann::ordered_json description(const SweepFile& sweep, const SweepJob& job, const SweepResults& results,
                                   std::size_t kept, std::size_t workers, double integration, double seconds) {
  auto keys = nlohmann::ordered_json::array(), failed = keys;
  for (const VariedKey& key : sweep.plan.keys) keys.push_back(key.key);
  for (const SweepRow* row : results.rows())
    if (!row->completed) failed.push_back({{"index", row->index}, {"error", row->error}});
  return {{"title", sweep.title},
          {"scene", sweep.scene_source},
          {"keys", keys},
          {"combine", sweep.plan.combine == Combine::zip ? "zip" : "grid"},
          {"cases", job.part.count(sweep.plan.size())},
          {"part", job.part.of == 1 ? nlohmann::ordered_json()
                                    : nlohmann::ordered_json(fmt::format("{}/{}", job.part.number, job.part.of))},
          {"done", results.size()},
          {"kept", kept},
          {"run", results.size() - kept},
          {"failed", failed},
          {"workers", workers},
          {"integration_seconds", integration},
          {"wall_seconds", seconds}};
}

std::string table(const SweepFile& sweep, const SweepJob& job, const SweepResults& results, std::size_t kept,
                  double seconds) {
  std::string text = heading(sweep.title, "Sweep") + "\n";
  text += row("cases", "{} of {}{}{}", results.size(), job.part.count(sweep.plan.size()), job.words(),
              kept == 0 ? "" : fmt::format(", {} of them from before", kept));
  if (const std::size_t failed = results.failed(); failed > 0) text += row("failed", "{}", failed);
  text += row("whole sweep", "{:.3g} s", seconds);
  constexpr std::size_t most_rows = 30;
  const auto rows = results.rows();
  if (!rows.empty()) {
    text += "\n" + viscobar::text(sweep_text_table(sweep, rows, most_rows, NumberText::For::terminal));
    if (rows.size() > most_rows) text += fmt::format("  and {} more\n", rows.size() - most_rows);
    text += "\n";
  }
  const fs::path directory = job.directory();
  text += row("page", (directory / "sweep.html").string());
  return text + row("rows", "{}, {}", (directory / "sweep.h5").string(), (directory / "sweep.csv").string());
}

int run_job(const SweepOptions& asked, const SweepFile& sweep, const SweepJob& job) {
  const WallClock clock;
  const fs::path directory = job.directory();
  const bool one_of_many = job.by_launcher && job.part.of > 1, silent = asked.output.quiet || one_of_many;
  const std::size_t threads = asked.threads > 0 ? asked.threads : one_of_many ? 1 : cores();
  const std::vector<double> costs = plan_cases(sweep, threads, job.part);
  catch_interrupts();
  // Rows of another sweep are found before anything is made.
  const std::vector<SweepRow> beside = rows_beside(job.whole, sweep, job.part, warn);
  SweepResults results(directory, sweep, warn);
  const std::size_t kept = results.size();
  std::vector<bool> to_run = job.part.own(costs.size());
  double integration = 0.0;
  for (const SweepRow& row : beside) {
    if (results.has(row.index) || !to_run[row.index]) continue;
    results.add(row);
    integration += row.integration_seconds;
  }
  for (const SweepRow* row : results.rows()) to_run[row->index] = false;
  SweepQueue queue(sweep, costs, to_run);
  const std::size_t missing = queue.size(), cases = job.part.count(costs.size());
  // It has the checksums of tables that are about to change.
  if (missing > 0 || results.size() > kept) fs::remove(directory / "sweep.json");

  std::optional<SweepProgress> progress;
  if (!asked.json && !asked.output.quiet && job.part.number == 1 && on_terminal())
    progress.emplace(costs, queue, cases);
  const SweepWork work{sweep, queue,
                       [&](const SweepRow& row) {
                         results.add(row);
                         integration += row.integration_seconds;
                         if (progress) progress->count(row);
                       },
                       [&] {
                         results.refresh_tables();
                         if (progress) progress->show();
                       },
                       interrupt_asked};
  const bool finished = missing == 0 || run_on_threads(work, std::min(threads, missing));
  progress.reset();
  FileSet files(directory, "sweep");
  results.close(files.folder());
  const std::string page = sweep_page(sweep, results.rows());
  files.write("sweep.html", page);
  FileChecksums checksums = results.checksums();
  checksums["sweep.html"] = Checksum::of(page);
  const std::string json =
      sealed_summary(description(sweep, job, results, kept, threads, integration, clock.seconds()), checksums);
  files.write("sweep.json", json);
  files.take_places();
  if (!silent && asked.json)
    print(json);
  else if (!silent)
    print(table(sweep, job, results, kept, clock.seconds()));
  for (const SweepRow* row : results.rows())
    if (!row->completed && !one_of_many) complain(fmt::format("case {}: {}", row->index, row->error));
  if (!finished) {
    complain(fmt::format("interrupted with {} of {} cases{} done; the same command goes on", results.size(), cases,
                         job.words()));
    return stopped;
  }
  return results.failed() == 0 ? success : run_failed;
}

int run_sweep(const SweepOptions& asked) {
  std::vector<std::string> overrides = asked.overrides;
  if (!asked.error.empty()) overrides.push_back("accuracy.error=" + asked.error);
  SweepJob job{.part = {}, .whole = asked.output.directory(asked.file)};
  if (!asked.part.empty()) {
    job.part = part_of(asked.part);
  } else if (const auto part = part_in_job()) {
    job.part = *part;
    job.by_launcher = part->of > 1;
  }
  const SweepFile sweep = read_sweep(asked.file, overrides);
  check_result_directory(job.whole, ResultKind::sweep);
  const int code = run_job(asked, sweep, job);
  if (!job.by_launcher || code == stopped) return code;
  // mpirun would end the other parts with one that fails. The last to end puts the rows together.
  if (!are_whole(job.whole, job.part.of, sweep.plan)) return success;
  job.part = {};
  try {
    return run_job(asked, sweep, job);
  } catch (const DirectoryInUse&) {
    return success;  // by another that has just ended
  }
}

}  // namespace

Action sweep_command(CLI::App& command) {
  const auto asked = std::make_shared<SweepOptions>(command);
  command.get_option("--output")
      ->description(
          "Directory of the rows; finished rows of the same sweep are kept (default: the sweep's name with \".out\", "
          "in the working directory)");
  add(command, "sweep", "SWEEP", asked->file, "The sweep file (TOML): a scene, and what varies in it")->required();
  add_set(command, asked->overrides, "Replace a value of the scene in all cases");
  add_error(command, asked->error, "Choose what the scene leaves open so that each case keeps this error");
  add_json(command, asked->json);
  command
      .add_option(
          "--part", asked->part,
          "Run a part of the cases, 3/16 the third of sixteen, into part-3-of-16 in the directory; without it the "
          "rows of all parts are put together, and what is missing runs")
      ->type_name("K/N");
  add_threads(command, asked->threads,
              "Number of simultaneous cases (default: one a core; one for each of several processes of mpirun)");
  return [asked] { return run_sweep(*asked); };
}

}  // namespace viscobar::cli
