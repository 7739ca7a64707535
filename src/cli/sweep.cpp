#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/commands.hpp"
#include "results/file_set.hpp"
#include "results/result_directory.hpp"
#include "studies/parallel.hpp"
#include "sweep/ranks.hpp"
#include "sweep/sweep_page.hpp"
#include "sweep/sweep_results.hpp"
#include "sweep/sweep_workers.hpp"

namespace viscobar::cli {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// How far the sweep is, on the terminal, by the costs that were estimated.
class SweepProgress {
 public:
  SweepProgress(std::span<const double> costs, const SweepQueue& queue, std::size_t kept)
      : costs_(costs), done_(kept), total_(queue.seconds()) {}

  void count(const SweepRow& row) {
    ++done_;
    if (!row.completed) ++failed_;
    finished_ += costs_[row.index];
  }

  void show() {
    if (!progress_.due()) return;
    const std::string failed = failed_ > 0 ? fmt::format(", {} failed", failed_) : "";
    progress_.show(fmt::format("{} of {} cases{}", done_, costs_.size(), failed), finished_ / total_);
  }

 private:
  std::span<const double> costs_;
  std::size_t done_, failed_ = 0;
  double total_, finished_ = 0.0;
  Progress progress_;
};

struct SweepOptions {
  std::string file, error;
  std::vector<std::string> overrides;
  bool json = false;
  OutputOptions output;
  std::size_t threads = 0;

  explicit SweepOptions(CLI::App& command) : output(command) {}
};

nlohmann::ordered_json description(const SweepFile& sweep, const SweepResults& results, std::size_t kept,
                                   std::size_t workers, double integration, double seconds) {
  auto keys = nlohmann::ordered_json::array(), failed = keys;
  for (const VariedKey& key : sweep.plan.keys) keys.push_back(key.key);
  for (const SweepRow* row : results.rows())
    if (!row->completed) failed.push_back({{"index", row->index}, {"error", row->error}});
  return {{"title", sweep.title},
          {"scene", sweep.scene_source},
          {"keys", keys},
          {"combine", sweep.plan.combine == Combine::zip ? "zip" : "grid"},
          {"cases", sweep.plan.size()},
          {"done", results.size()},
          {"kept", kept},
          {"run", results.size() - kept},
          {"failed", failed},
          {"workers", workers},
          {"integration_seconds", integration},
          {"wall_seconds", seconds}};
}

std::string table(const SweepFile& sweep, const SweepResults& results, std::size_t kept, const fs::path& directory,
                  double seconds) {
  std::string text = heading(sweep.title, "Sweep") + "\n";
  text += row("cases", "{} of {}{}", results.size(), sweep.plan.size(),
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
  text += row("page", (directory / "sweep.html").string());
  return text + row("rows", "{}, {}", (directory / "sweep.h5").string(), (directory / "sweep.csv").string());
}

int run_sweep(const SweepOptions& asked) {
  const auto started = Clock::now();
  std::optional<Ranks> ranks;
  if (started_by_mpi()) ranks.emplace(interrupt_asked);
  const bool several = ranks && ranks->size() > 1;
  if (several && !ranks->is_manager()) {
    catch_interrupts();  // a worker hears of the end from the manager
    return ranks->serve(), success;
  }
  if (several && asked.threads > 0)
    refuse("--threads: under mpirun every rank but the first runs one case at a time; give -n");

  std::vector<std::string> overrides = asked.overrides;
  if (!asked.error.empty()) overrides.push_back("accuracy.error=" + asked.error);
  const SweepFile sweep = read_sweep(asked.file, overrides);
  std::vector<double> costs;
  if (several) costs = ranks->plan(sweep);
  // This one also says why, where no case can run.
  if (std::all_of(costs.begin(), costs.end(), [](double cost) { return cost == 0.0; }))
    costs = plan_cases(sweep, asked.threads);
  const fs::path directory = asked.output.directory(asked.file);
  catch_interrupts();
  SweepResults results(directory, sweep, warn);
  const std::size_t kept = results.size();
  SweepQueue queue(sweep, costs, results.rows());
  const std::size_t missing = queue.size();
  // It has the checksums of tables that are about to change.
  if (missing > 0) fs::remove(directory / "sweep.json");

  double integration = 0.0;
  std::optional<SweepProgress> progress;
  if (!asked.json && !asked.output.quiet && on_terminal()) progress.emplace(costs, queue, kept);
  const SweepWork work{sweep.scene_text, queue,
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
  const std::size_t threads = asked.threads > 0 ? asked.threads : cores();
  const std::size_t workers = several ? static_cast<std::size_t>(ranks->size()) - 1 : threads;
  const bool finished = missing == 0 || (several ? ranks->run(work) : run_on_threads(work, std::min(threads, missing)));
  progress.reset();
  FileSet files(directory, "sweep");
  results.close(files.folder());
  const std::string page = sweep_page(sweep, results.rows());
  files.write("sweep.html", page);
  FileChecksums checksums = results.checksums();
  checksums["sweep.html"] = Checksum::of(page);
  const std::string json =
      sealed_summary(description(sweep, results, kept, workers, integration, seconds_since(started)), checksums);
  files.write("sweep.json", json);
  files.take_places();
  if (asked.json)
    print(json);
  else if (!asked.output.quiet)
    print(table(sweep, results, kept, directory, seconds_since(started)));
  for (const SweepRow* row : results.rows())
    if (!row->completed) complain(fmt::format("case {}: {}", row->index, row->error));
  if (!finished) {
    complain(fmt::format("interrupted with {} of {} cases done; the same command goes on", results.size(),
                         sweep.plan.size()));
    return stopped;
  }
  return results.failed() == 0 ? success : run_failed;
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
  add_threads(command, asked->threads,
              "Number of simultaneous cases (default: one a core); under mpirun each rank runs one");
  return [asked] { return run_sweep(*asked); };
}

}  // namespace viscobar::cli
