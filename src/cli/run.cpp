#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <utility>

#include "case/peak_remark.hpp"
#include "cli/commands.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "cli/progress.hpp"
#include "report/run/estimate_text.hpp"
#include "results/csv.hpp"
#include "results/result_directory.hpp"
#include "viscobar/record/record_run.hpp"

namespace viscobar::cli {

namespace {

namespace fs = std::filesystem;

std::string table(const Case& run, const Outcome& outcome, const fs::path& directory) {
  std::string text = heading(run.scene.title, "Run") + "\n";
  text += row("method", method_words(run));
  if (outcome.ending == Ending::completed)
    text += row("simulated time", fmt::format("{:.6g}", outcome.reached_time));
  else
    text += row("simulated time", fmt::format("{:.6g} of {:.6g}: not completed", outcome.reached_time, run.end));
  text += row("steps", fmt::format("{}", outcome.steps));
  if (is_obstacle(run.scene.left) || is_obstacle(run.scene.right) || run.scene.span)
    text += row("contact changes", fmt::format("{}", outcome.events));
  if (const auto& statistics = outcome.statistics) {
    text += row("evaluations", fmt::format("{}", statistics->rhs_evaluations));
    text += row("linear solves",
                fmt::format("{}, {} factorisations", statistics->linear_solves, statistics->matrix_factorisations));
    if (statistics->max_penetration > 0.0)
      text += row("largest penetration", fmt::format("{:.3g}", statistics->max_penetration));
    if (const auto& energy = statistics->energy)
      text += row("energy", fmt::format("{:.6g} to {:.6g}, dissipated {:.6g}, work {:.6g}{}, balance error {:.2g}",
                                        energy->initial, energy->final, energy->dissipated, energy->work,
                                        energy->end_inertia == 0.0
                                            ? ""
                                            : fmt::format(", taken by the mass's end rows {:.3g}", energy->end_inertia),
                                        energy->balance_error()));
    if (const auto& account = statistics->account) {
      const auto contact = [&](const char* where, const EndCondition& kind, const EndAccount& end) {
        if (is_obstacle(kind))
          text += row(where, fmt::format("{} closings, in contact for {:.6g}, impulse {:.6g}, peak reaction {:.6g}",
                                         end.closings, end.contact.total(outcome.reached_time), end.impulse,
                                         end.peak_reaction));
      };
      contact("left obstacle", run.scene.left, account->left);
      contact("right obstacle", run.scene.right, account->right);
      const auto remark = peak_remark(run, make_system(run));
      if (remark && account->left.closings + account->right.closings > 0) text += row("peak reaction", *remark);
    }
    if (outcome.error_estimate)
      for (const auto& [what, value] : estimate_rows(*outcome.error_estimate)) text += row(what, value);
    text += row("integration", fmt::format("{:.3g} s", statistics->integration_seconds));
  }
  text += row("whole run", fmt::format("{:.3g} s", outcome.wall_seconds));
  return text + row("pictures", (directory / "report.html").string());
}

int exit_code(Ending ending) {
  switch (ending) {
    case Ending::completed: return success;
    case Ending::failed: return run_failed;
    case Ending::refused: return wrong_input;
    case Ending::interrupted: return stopped;
  }
  return run_failed;
}

/// Runs it or goes on with it: what `run` and `resume` have in common.
template <class Record>
int shown(const SceneFile& scene, const fs::path& directory, bool json, bool quiet, RecordOptions options,
          Record&& record) {
  catch_interrupts();
  std::optional<Progress> progress;
  if (!quiet && !json && on_terminal()) progress.emplace(scene.run.end);
  options.progress = [&](double time, std::size_t steps) {
    if (progress) (*progress)(time, steps);
  };
  options.stop = interrupt_asked;
  options.event = [](const Event& event) {
    detail(fmt::format("t = {:.9g}: {} {}, velocity {:.6g}", event.time, place(event),
                       event.change == Change::closing ? "closes" : "opens", event.velocity));
  };
  options.message = [](const std::string& what) { detail("accuracy: " + what); };
  options.warning = [&](const std::string& warning) { quiet ? detail("warning: " + warning) : warn(warning); };
  const RunRecord recorded = record(options);
  progress.reset();

  const Outcome& outcome = recorded.outcome;
  if (outcome.ending != Ending::completed)
    complain(fmt::format("stopped at t = {}: {}", outcome.reached_time, outcome.error));
  const auto& estimate = outcome.error_estimate;
  const bool missed = outcome.ending == Ending::completed && estimate && estimate->requested && !estimate->kept;
  if (missed) complain(fmt::format("the error that was asked for is not kept: {}", estimate->doubt));
  if (outcome.ending == Ending::interrupted && outcome.statistics)
    say(fmt::format("viscobar resume {} goes on with it.", directory.string()));
  if (recorded.directory != directory)
    say(fmt::format("The earlier result in {} is as it was; what this run reached is in {}.", directory.string(),
                    recorded.directory.string()));
  if (json)
    print(recorded.summary);
  else if (!quiet)
    print(table(recorded.run ? *recorded.run : scene.run, outcome, recorded.directory));
  return missed ? run_failed : exit_code(outcome.ending);
}

/// Of [sensitivity], for a list of keys with commas.
std::vector<std::string> sensitivity_settings(const std::string& keys) {
  if (keys.empty()) return {};
  std::string list;
  for (std::size_t begin = 0; begin <= keys.size();) {
    const std::size_t end = std::min(keys.find(',', begin), keys.size());
    list += fmt::format("{}'{}'", list.empty() ? "" : ", ", keys.substr(begin, end - begin));
    begin = end + 1;
  }
  return {fmt::format("sensitivity.of=[{}]", list)};
}

/// A plain number is simulated time; with a unit it is time on the clock.
CheckpointEvery checkpoint_every(const std::string& text) {
  constexpr std::pair<std::string_view, double> units[] = {{"s", 1.0}, {"min", 60.0}, {"h", 3600.0}};
  CheckpointEvery every;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), every.interval);
  const std::string_view unit(rest, static_cast<std::size_t>(text.data() + text.size() - rest));
  bool known = unit.empty();
  for (const auto& [name, seconds] : units) {
    if (unit != name) continue;
    known = true;
    every.clock = CheckpointEvery::Clock::wall;
    every.interval *= seconds;
  }
  if (error != std::errc{} || !known || !(every.interval > 0.0) || !std::isfinite(every.interval))
    throw std::invalid_argument(fmt::format(
        "--checkpoint: {} is neither a time of the scene, such as 0.5, nor one on the clock, such as 30s, 5min or 1h",
        text));
  return every;
}

}  // namespace

RunCommand::RunCommand(CLI::App& app)
    : Command(app, "run", "Run a scene and write its results and a report with pictures"),
      scene_(command_),
      output_(command_) {
  command_
      .add_option("--checkpoint", checkpoint_,
                  "Make checkpoints to go on from with resume: in the time of the scene, such as 0.5, or on the clock, "
                  "such as 30s, 5min or 1h")
      ->type_name("INTERVAL");
  scene_.takes_accuracy = true;
  command_
      .add_option(
          "--error", error_,
          "Choose what the scene leaves open so that this error is kept, such as 1e-4 or \"0.01 %\"; the same as "
          "--set accuracy.error=...")
      ->type_name("ERROR");
  command_.add_flag("--no-estimate", no_estimate_,
                    "Make no runs on coarser meshes to estimate the error of a scene that asks for none");
  command_
      .add_option("--sensitivity", sensitivity_,
                  "Tell derivatives of the results with respect to these keys, such as bar.viscosity,left.gap")
      ->type_name("KEYS");
}

int RunCommand::operator()() const {
  RecordOptions options;
  if (!checkpoint_.empty()) options.checkpoint = checkpoint_every(checkpoint_);
  options.figures = output_.figures;
  std::vector<std::string> settings = sensitivity_settings(sensitivity_);
  if (!error_.empty()) settings.push_back("accuracy.error=" + error_);
  const SceneFile scene = scene_.read({}, settings);
  // Each checkpoint holds the times of all before it: these write 8 n^2 / 2 bytes for that, 40 GB.
  constexpr double most_checkpoints = 1e5;
  if (options.checkpoint && options.checkpoint->clock == CheckpointEvery::Clock::simulated &&
      scene.run.end / options.checkpoint->interval > most_checkpoints)
    throw std::invalid_argument(
        fmt::format("--checkpoint: {} makes more than {} checkpoints until t = {}; the shortest interval is {:.3g}",
                    checkpoint_, most_checkpoints, scene.run.end, scene.run.end / most_checkpoints));
  const fs::path directory = output_.directory(scene_);
  return shown(scene, directory, scene_.json, output_.quiet, options, [&](const RecordOptions& chosen) {
    if (scene.accuracy) return record_to_accuracy(scene, directory, chosen);
    return no_estimate_ ? record_run(scene, directory, chosen) : record_with_estimate(scene, directory, chosen);
  });
}

ResumeCommand::ResumeCommand(CLI::App& app)
    : Command(app, "resume", "Continue a run that was stopped, from its last checkpoint") {
  command_.add_option("directory", directory_, "Where the run put its results")->required()->type_name("DIR");
  command_.add_flag("--json", json_, "Print one JSON document on standard output, and nothing else there");
  command_.add_flag("--quiet", quiet_, "Print nothing but errors");
  add_figures(command_, figures_);
}

int ResumeCommand::operator()() const {
  const fs::path directory = directory_;
  RecordOptions options;
  options.figures = figures_;
  if (clear_whole_run(directory)) {
    std::ifstream summary(directory / "summary.json");
    if (json_)
      print(std::string(std::istreambuf_iterator<char>(summary), {}));
    else if (!quiet_)
      say(directory.string() + ": the run was stopped when it was complete");
    return success;
  }
  const SceneFile scene = scene_of_checkpoint(directory);
  return shown(scene, directory, json_, quiet_, options,
               [&](const RecordOptions& chosen) { return resume_run(scene, directory, chosen, warn); });
}

}  // namespace viscobar::cli
