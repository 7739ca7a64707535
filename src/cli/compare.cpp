#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>

#include "case/memory.hpp"
#include "cli/commands.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "results/result_directory.hpp"
#include "viscobar/report/reports.hpp"

namespace viscobar::cli {

namespace {

/// Fields of every method are kept, displacement and velocity at each node and output time.
void check_memory(const Case& run, std::size_t methods) {
  const double bytes = 2.0 * sizeof(double) * static_cast<double>(methods) * static_cast<double>(run.mesh().nodes()) *
                       (run.end / run.output_every + 1.0);
  if (bytes > memory_limit())
    throw std::invalid_argument(
        fmt::format("output.every: comparing keeps the fields of all methods, here {:.0f} GB; take a larger one, or "
                    "fewer methods",
                    bytes / 1e9));
}

}  // namespace

CompareCommand::CompareCommand(CLI::App& app)
    : Command(app, "compare", "Run a scene by several methods and report their differences"),
      scene_(command_),
      output_(command_) {
  command_
      .add_option("--methods", methods_,
                  "The methods, the first one the reference (default: all that fit the scene, characteristics or else "
                  "exponential the reference where it does)")
      ->type_name("NAME,NAME...")
      ->delimiter(',')
      ->allow_extra_args(false);
  add_threads(command_, threads_);
}

int CompareCommand::operator()() const {
  const std::vector<MethodName> methods = methods_named(methods_);
  const SceneFile scene = scene_.read({}, {}, [](Case& run) {
    if (is_penalised(run.method)) run.method = penalised_method(run);
  });
  const MethodChoice choice =
      command_.count("--methods") ? chosen_methods(scene.run, methods) : fitting_methods(scene.run);
  if (choice.cases.size() < 2) {
    std::string reasons;
    for (const auto& [method, reason] : choice.skipped) reasons += fmt::format("\n  {}: {}", name(method), reason);
    throw std::invalid_argument("fewer than two methods, nothing to compare" + reasons);
  }
  check_memory(scene.run, choice.cases.size());
  const std::filesystem::path directory = output_.directory(scene_);
  const ResultDirectory results(directory, ResultKind::compare);
  if (!output_.quiet) warn_of_other_scenes(directory, scene, "compare.json");

  end_on_interrupt();
  const Comparison check = compare(choice.cases, threads_);
  finish_study("compare", directory, scene_, output_, scene, compare_json(scene, choice, check),
               compare_page(scene.run.scene, choice, check), compare_text(choice, check));
  for (const MethodRun& run : check.runs)
    if (!run.recording) complain(fmt::format("{}: {}", name(run.run.method), run.error));
  return check.completed() ? success : run_failed;
}

}  // namespace viscobar::cli
