#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "cli/commands.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "cli/progress.hpp"
#include "io/csv.hpp"
#include "viscobar/io/record_run.hpp"

namespace viscobar::cli {

namespace {

namespace fs = std::filesystem;

std::string table(const Case& run, const Outcome& outcome, const fs::path& directory) {
  std::string text = fmt::format("{}\n", run.scene.title.empty() ? "Run" : run.scene.title);
  text += row("method", name(run.method));
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
      text += row("energy",
                  fmt::format("{:.6g} to {:.6g}, dissipated {:.6g}, work {:.6g}, balance error {:.2g}", energy->initial,
                              energy->final, energy->dissipated, energy->work, energy->balance_error()));
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

}  // namespace

RunCommand::RunCommand(CLI::App& app)
    : command_(*app.add_subcommand("run", "Run a scene and write its results and a report with pictures")),
      scene_(command_),
      output_(command_) {}

int RunCommand::operator()() const {
  RecordOptions options;
  options.figures = output_.figures;
  const SceneFile scene = scene_.read();
  const fs::path directory = output_.directory(scene_);

  catch_interrupts();
  std::optional<Progress> progress;
  if (!output_.quiet && !scene_.json && on_terminal()) progress.emplace(scene.run.end);
  options.progress = [&](double time, std::size_t steps) {
    if (interrupt_asked()) throw Interrupted();
    if (progress) (*progress)(time, steps);
  };
  options.event = [](const Event& event) {
    detail(fmt::format("t = {:.9g}: {} {}, velocity {:.6g}", event.time, place(event),
                       event.change == Change::closing ? "closes" : "opens", event.velocity));
  };
  const RunRecord record = record_run(scene, directory, options);
  progress.reset();

  const Outcome& outcome = record.outcome;
  if (outcome.ending != Ending::completed)
    complain(fmt::format("stopped at t = {}: {}", outcome.reached_time, outcome.error));
  if (scene_.json)
    print(record.summary);
  else if (!output_.quiet)
    print(table(scene.run, outcome, directory));
  return exit_code(outcome.ending);
}

}  // namespace viscobar::cli
