#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "case/regime.hpp"
#include "cli/commands.hpp"
#include "report/number_text.hpp"
#include "report/run/run_page.hpp"
#include "results/csv.hpp"
#include "results/result_directory.hpp"
#include "run/stopwatch.hpp"
#include "text/number.hpp"
#include "viscobar/record/record_run.hpp"

namespace viscobar::cli {

namespace {

namespace fs = std::filesystem;

std::string with_unit(double value, const Scene& scene, Dimension quantity, int digits = 6) {
  return NumberText::terminal(scene)(value, quantity, digits);
}

/// The first contacts of the ends, each from its closing to its opening, with the impulse between.
std::string contact_rows(const Case& run, const std::vector<Event>& events) {
  constexpr std::size_t most = 6;
  std::string text;
  std::size_t shown = 0, more = 0;
  std::map<std::string, Event> closed;
  const auto tell = [&](const Event& from, const Event* to) {
    if (shown == most) return void(++more);
    ++shown;
    std::string words = "t = " + with_unit(from.time, run.scene, Dimension::time);
    words += to ? " to " + with_unit(to->time, run.scene, Dimension::time) : " on";
    if (to && from.impulse && to->impulse)
      words += ", impulse " + with_unit(*to->impulse - *from.impulse, run.scene, Dimension::impulse);
    text += row(fmt::format("contact {}", place(from)), words);
  };
  for (const Event& event : events) {
    if (event.where == Where::span) continue;
    const auto begun = closed.find(place(event));
    if (event.change == Change::closing)
      closed.insert_or_assign(place(event), event);
    else if (begun != closed.end())
      tell(begun->second, &event), closed.erase(begun);
  }
  for (const auto& [where, lasting] : closed) tell(lasting, nullptr);
  if (more > 0) text += row("", "and {} more contact{}", more, more == 1 ? "" : "s");
  return text;
}

/// Largest size of a displacement of the ends.
double largest_displacement(const RunAccount& account) {
  double size = 0.0;
  for (const EndAccount* end : {&account.left, &account.right})
    if (end->lowest <= end->highest) size = std::max({size, std::abs(end->lowest), std::abs(end->highest)});
  return size;
}

std::string table(const Case& run, const Outcome& outcome, const std::vector<Event>& events,
                  const fs::path& directory) {
  std::string text = heading(run.scene.title, "Run") + "\n";
  text += row("method", method_words(run));
  if (outcome.ending == Ending::completed)
    text += row("simulated time", with_unit(outcome.reached_time, run.scene, Dimension::time));
  else
    text += row("simulated time", "{:.6g} of {}: not completed", outcome.reached_time,
                with_unit(run.end, run.scene, Dimension::time));
  text += row("steps", "{}", outcome.steps);
  if (meets_obstacle(run.scene)) text += row("contact changes", "{}", outcome.events);
  if (const auto& statistics = outcome.statistics) {
    text += row("evaluations", "{}", statistics->rhs_evaluations);
    text += row("linear solves", "{}, {} factorisations", statistics->linear_solves, statistics->matrix_factorisations);
    const double size = statistics->account ? largest_displacement(*statistics->account) : 0.0;
    if (const double depth = above_rounding(statistics->max_penetration, size); depth > 0.0)
      text += row("largest penetration", with_unit(depth, run.scene, Dimension::length));
    if (const auto& energy = statistics->energy) {
      const auto with = [&](double value, int digits = 6) {
        return with_unit(value, run.scene, Dimension::energy, digits);
      };
      const std::string end_rows =
          energy->end_inertia == 0.0 ? ""
                                     : fmt::format(" ({} of it by the mass's end rows)", with(energy->end_inertia, 3));
      text += row("energy", "{} to {}, dissipated {}{}, work {}, balance error {}", with(energy->initial),
                  with(energy->final), with(energy->dissipated), end_rows, with(energy->work),
                  with(energy->balance_error(), 2));
    }
    if (const auto& account = statistics->account) {
      for (const ContactPlace& place : contact_places(run.scene)) {
        const ContactAccount of = place.account(*account);
        text += row(place.joint > 0 ? fmt::format("joint {}", place.joint)
                                    : fmt::format("{} obstacle", viscobar::name(place.where)),
                    "{}, in contact for {}, impulse {}, peak reaction {}",
                    counted(of.closings, place.where == Where::span ? "closing of nodes" : "closing"),
                    with_unit(of.contact.total(outcome.reached_time), run.scene, Dimension::time),
                    with_unit(of.impulse, run.scene, Dimension::impulse),
                    with_unit(of.peak_reaction, run.scene, Dimension::force));
      }
      // A resumed run has not heard of those before.
      if (events.size() == outcome.events) text += contact_rows(run, events);
      const auto motion = [&](const char* where, const EndCondition& kind, const EndAccount& end) {
        if (!is_fixed(kind) && end.lowest <= end.highest)
          text +=
              row(where, "u from {} to {}", with_unit(above_rounding(end.lowest, size), run.scene, Dimension::length),
                  with_unit(above_rounding(end.highest, size), run.scene, Dimension::length));
      };
      motion("left end", run.scene.left, account->left);
      motion("right end", run.scene.right, account->right);
      const Setup setup = resolve(run);
      const auto remark = peak_remark(setup, setup.system());
      if (remark && account->left.closings + account->right.closings > 0) text += row("peak reaction", *remark);
    }
    if (outcome.error_estimate)
      for (const auto& [what, value] : estimate_rows(run.scene, *outcome.error_estimate)) text += row(what, value);
    if (!outcome.no_estimate.empty()) text += row("error, estimated", "there is no estimate: " + outcome.no_estimate);
    text += row("integration", "{:.3g} s", statistics->integration_seconds);
  }
  text += row("whole run", "{:.3g} s", outcome.wall_seconds);
  return text + (run.files.report ? row("pictures", (directory / "report.html").string())
                                  : row("results", directory.string()));
}

int exit_code(Ending ending) {
  switch (ending) {
    case Ending::completed: return success;
    case Ending::failed: break;
    case Ending::refused: return wrong_input;
    case Ending::interrupted: return stopped;
  }
  return run_failed;
}

/// Runs it or goes on with it: what `run` and `resume` have in common.
template <class Record>
int shown(const SceneFile& scene, const fs::path& directory, bool json, bool quiet, std::optional<double> wall_time,
          RecordOptions options, Record&& record) {
  if (options.figures && !scene.run.files.report)
    refuse(
        "--figures draws the pictures of the report, which output.write leaves out: name "
        "\"report\" there, too");
  catch_interrupts();
  std::optional<Progress> progress;
  if (!quiet && !json && on_terminal()) progress.emplace();
  options.progress = [&](double time, std::size_t steps) {
    constexpr std::size_t between_looks = 16;
    if (!progress || steps % between_looks != 0 || !progress->due()) return;
    const double share = std::clamp(time / scene.run.end, 0.0, 1.0);
    progress->show(fmt::format("{:5.1f} %  t = {:.6g} of {:.6g}  {} steps", 100.0 * share, time, scene.run.end, steps),
                   share);
  };
  std::atomic<bool> out_of_time = false;  // asked by runs side by side
  options.stop = [&] {
    if (wall_time && WallClock(options.started).seconds() >= *wall_time) out_of_time = true;
    return out_of_time || interrupt_asked();
  };
  std::vector<Event> events;
  constexpr std::size_t most_events = 10'000;
  options.event = [&](const Event& event) {
    if (events.size() < most_events) events.push_back(event);
    detail(fmt::format("t = {:.9g}: {} {}, velocity {:.6g}", event.time, place(event),
                       event.change == Change::closing ? "closes" : "opens", event.velocity));
  };
  options.message = [](const std::string& what) { detail("accuracy: " + what); };
  options.warning = [&](const std::string& warning) { quiet ? detail("warning: " + warning) : warn(warning); };
  const RunRecord recorded = record(options);
  progress.reset();

  const Outcome& outcome = recorded.outcome;
  // Several runs may have been made: only the events of the last one are kept.
  events.erase(events.begin(), events.end() - static_cast<std::ptrdiff_t>(std::min(events.size(), outcome.events)));
  if (outcome.ending != Ending::completed)
    complain(fmt::format(
        "stopped at t = {}: {}", outcome.reached_time,
        out_of_time && outcome.ending == Ending::interrupted ? "the time of --wall-time is over" : outcome.error));
  constexpr double little = 1e-3;
  const double advanced = outcome.reached_time - recorded.began;
  if (out_of_time && outcome.ending == Ending::interrupted && advanced < little * scene.run.end)
    complain(
        fmt::format("in that time the run advanced by {:.2g} of {:.6g}, for its start took the rest: give "
                    "--wall-time more",
                    advanced, scene.run.end));
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
    print(table(recorded.run ? *recorded.run : scene.run, outcome, events, recorded.directory));
  return missed ? run_failed : exit_code(outcome.ending);
}

/// A positive number, with the unit of a clock or without one.
struct Duration {
  double value = 0.0;  ///< in seconds where it has a unit
  bool on_the_clock = false;
};
std::optional<Duration> read_duration(const std::string& text) {
  constexpr std::pair<std::string_view, double> units[] = {
      {"", 1.0}, {"s", 1.0}, {"min", 60.0}, {"m", 60.0}, {"h", 3600.0}};
  double number = 0.0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const auto* unit = std::ranges::find(units, std::string_view(rest), &std::pair<std::string_view, double>::first);
  if (error != std::errc{} || unit == std::end(units)) return std::nullopt;
  const double value = number * unit->second;
  if (!(value > 0.0) || !std::isfinite(value)) return std::nullopt;
  return Duration{value, !unit->first.empty()};
}

/// A plain number is simulated time; with a unit it is time on the clock.
CheckpointEvery checkpoint_every(const std::string& text) {
  const auto every = read_duration(text);
  if (!every)
    refuse(
        "--checkpoint: {} is neither a time of the scene, such as 0.5, nor one on the clock, such as 30s, 5min or 1h",
        text);
  return {every->on_the_clock ? CheckpointEvery::Clock::wall : CheckpointEvery::Clock::simulated, every->value};
}

std::optional<double> wall_time_of(const std::string& text) {
  if (text.empty()) return std::nullopt;
  const auto limit = read_duration(text);
  if (!limit || !limit->on_the_clock)
    refuse("--wall-time: {} is no time on the clock, such as 30s, 10m (or 10min) or 2h", text);
  return limit->value;
}

void add_wall_time(CLI::App& command, std::string& text) {
  add(command, "--wall-time", "TIME", text,
      "Stop after this time on the clock, such as 30s, 10m or 2h, with a checkpoint from which resume goes on; exit code "
      "130 as after an interrupt");
}

struct RunOptions : StudyOptions {
  using StudyOptions::StudyOptions;
  std::string checkpoint, wall_time, error;
  std::vector<std::string> sensitivity;
  bool no_estimate = false;
};

int run_scene(const RunOptions& asked) {
  RecordOptions options;
  if (!asked.checkpoint.empty()) options.checkpoint = checkpoint_every(asked.checkpoint);
  options.figures = asked.figures;
  const auto wall_time = wall_time_of(asked.wall_time);
  std::vector<Setting> settings;
  if (!asked.sensitivity.empty()) settings.emplace_back(std::pair("sensitivity.of", asked.sensitivity));
  if (!asked.error.empty()) settings.push_back("accuracy.error=" + asked.error);
  const SceneFile scene = asked.scene.read(settings);
  // Each checkpoint holds the times of all before it: these write 8 n^2 / 2 bytes for that, 40 GB.
  constexpr double most_checkpoints = 1e5;
  if (options.checkpoint && options.checkpoint->clock == CheckpointEvery::Clock::simulated &&
      scene.run.end / options.checkpoint->interval > most_checkpoints)
    refuse("--checkpoint: {} makes more than {} checkpoints until t = {}; the shortest interval is {:.3g}",
           asked.checkpoint, most_checkpoints, scene.run.end, scene.run.end / most_checkpoints);
  const fs::path directory = asked.output.directory(asked.scene.file);
  detail("results go to " + directory.string());
  if (!asked.output.quiet) warn_of_other_scenes(directory, scene, ResultKind::run);
  return shown(scene, directory, asked.scene.json, asked.output.quiet, wall_time, options,
               [&](const RecordOptions& chosen) {
                 if (scene.accuracy) return record_to_accuracy(scene, directory, chosen);
                 return asked.no_estimate ? record_run(scene, directory, chosen)
                                          : record_with_estimate(scene, directory, chosen);
               });
}

struct ResumeOptions {
  std::string directory, wall_time;
  bool json = false, quiet = false, figures = false;
};

int resume(const ResumeOptions& asked) {
  const fs::path directory = asked.directory;
  RecordOptions options;
  options.figures = asked.figures;
  const auto wall_time = wall_time_of(asked.wall_time);
  if (clear_whole_run(directory)) {
    std::ifstream summary(directory / "summary.json");
    if (asked.json)
      print(std::string(std::istreambuf_iterator<char>(summary), {}));
    else if (!asked.quiet)
      say(directory.string() + ": the run was stopped when it was complete");
    return success;
  }
  const SceneFile scene = scene_of_checkpoint(directory);
  return shown(scene, directory, asked.json, asked.quiet, wall_time, options,
               [&](const RecordOptions& chosen) { return resume_to_accuracy(scene, directory, chosen, warn); });
}

}  // namespace

Action run_command(CLI::App& command) {
  const auto asked = std::make_shared<RunOptions>(command);
  add(command, "--checkpoint", "INTERVAL", asked->checkpoint,
      "Make checkpoints to go on from with resume: in the time of the scene, such as 0.5, or on the clock, such as 30s, "
      "5min or 1h");
  add_wall_time(command, asked->wall_time);
  asked->scene.takes_accuracy = true;
  add_error(command, asked->error, "Choose what the scene leaves open so that this error is kept");
  command.add_flag("--no-estimate", asked->no_estimate,
                   "Make no runs on coarser meshes to estimate the error of a scene that asks for none");
  add_list(command, "--sensitivity", "KEY,KEY...", asked->sensitivity,
           "Tell derivatives of the results with respect to these keys, such as bar.viscosity,left.gap");
  return [asked] { return run_scene(*asked); };
}

Action resume_command(CLI::App& command) {
  const auto asked = std::make_shared<ResumeOptions>();
  add(command, "directory", "DIR", asked->directory, "Where the run put its results")->required();
  add_json(command, asked->json);
  add_quiet(command, asked->quiet);
  add_figures(command, asked->figures);
  add_wall_time(command, asked->wall_time);
  return [asked] { return resume(*asked); };
}

}  // namespace viscobar::cli
