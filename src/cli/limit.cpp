#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>

#include "cli/commands.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "cli/progress.hpp"
#include "results/result_directory.hpp"
#include "viscobar/report/reports.hpp"

namespace viscobar::cli {

namespace {

constexpr DecadeRange epsilons{"--epsilon", "a positive number", "1e-2:1e-8", std::numeric_limits<double>::min(),
                               std::numeric_limits<double>::max()};

}  // namespace

LimitCommand::LimitCommand(CLI::App& app)
    : Command(app, "limit",
              "Study how the penalised bar tends to the fully discrete scheme as epsilon "
              "goes to 0: penetration, differences, orders, verdict"),
      scene_(command_),
      output_(command_) {
  const auto list = [&](const char* option, auto& values, const char* what, const char* type,
                        const CLI::Validator& check) {
    command_.add_option(option, values, what)->type_name(type)->delimiter(',')->check(check)->allow_extra_args(false);
  };
  command_
      .add_option("--epsilon", epsilon_,
                  "The penalties, from the first down to the last (default: 1e-2 to 1e-8 times L/E, under a span "
                  "obstacle alone L^2/E)")
      ->type_name("FIRST:LAST");
  command_.add_option("--per-decade", per_decade_, "Penalties a decade")
      ->type_name("N")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command_.add_option("--mass", mass_, "The mass matrix, in place of the scene's")->type_name("NAME");
  list("--elements", elements_, "Meshes, in place of the scene's; three or more give epsilon(h)", "N,N...",
       number_of_elements());
  list("--steps", steps_,
       "Time steps of the scheme to start with, one for each mesh (default: the scene's, or h / (100 c))", "DT,DT...",
       positive_number());
  command_
      .add_option("--budget", budget_,
                  "Processor seconds for smaller steps of the scheme, taken until the verdict is known")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  scene_.takes_accuracy = true;
  command_
      .add_option("--error", error_,
                  "Choose the elements so that the limit epsilon = 0 keeps this error of the mesh, such as 1e-4 or "
                  "\"0.01 %\"; the same as --set accuracy.error=...")
      ->type_name("ERROR");
  command_.add_flag(
      "--derivatives", derivatives_,
      "Also tell the power of epsilon at each penalty, by the derivative of the traces with respect to it "
      "(cvode, ida and arkode)");
  add_threads(command_, threads_);
}

int LimitCommand::operator()() const {
  LimitStudy study;
  if (command_.count("--epsilon") > 0) study.epsilons = epsilons(epsilon_, per_decade_);
  study.elements = elements_;
  study.steps = steps_;
  study.budget = budget_;
  study.threads = threads_;
  study.derivatives = derivatives_;
  std::vector<std::string> settings;
  if (command_.count("--mass") > 0) settings.push_back("mesh.mass=" + mass_);
  if (!elements_.empty())  // the scene is checked on the finest mesh
    settings.push_back(fmt::format("mesh.elements={}", *std::max_element(elements_.begin(), elements_.end())));
  if (!error_.empty()) settings.push_back("accuracy.error=" + error_);
  // The scene's own epsilon, which it may lack, is not used.
  const SceneFile scene = scene_.read({}, settings, [&](Case& run) {
    if (study.epsilons.empty()) study.epsilons = natural_penalties(run.scene, per_decade_);
    run.epsilon = study.epsilons.front();
    run.method = penalised_method(run);
  });
  study.scene = scene.run;
  const Scene& bar = scene.run.scene;
  if (!is_obstacle(bar.left) && !is_obstacle(bar.right) && !bar.span)
    throw std::invalid_argument(scene_.file + ": the scene has no obstacle, so there is nothing to penalise");
  const std::size_t meshes = std::max<std::size_t>(1, elements_.size());
  if (!steps_.empty() && steps_.size() != meshes)
    throw std::invalid_argument(fmt::format("--steps: {} given for {} mesh{}, one for each is needed", steps_.size(),
                                            meshes, meshes == 1 ? "" : "es"));
  const bool chooses = scene.accuracy && elements_.empty();
  if (!error_.empty() && !chooses)
    throw std::invalid_argument("--elements: --error chooses the mesh; give one of the two");
  const std::filesystem::path directory = output_.directory(scene_);
  const ResultDirectory results(directory, ResultKind::limit);
  if (!output_.quiet) warn_of_other_scenes(directory, scene, "limit.json");

  end_on_interrupt();
  StatusLine status;
  if (!output_.quiet && on_terminal())
    study.progress = [&](std::size_t done, std::size_t of) { status.show(fmt::format("{} of {} runs", done, of)); };
  std::optional<ErrorEstimate> missed;
  if (chooses) {
    if (study.progress) status.show("a mesh that keeps the error");
    const AccuracyResult solved = limit_to_accuracy(study, *scene.accuracy);
    study.elements = {solved.run.elements};
    if (!solved.estimate.kept) missed = solved.estimate;
  }
  const LimitResult result = limit_of(study);
  status.clear();
  const CouplingResult coupling = balance_errors(study, result);
  finish_study("limit", directory, scene_, output_, scene, limit_json(scene, study, result, coupling),
               limit_page(study, result, coupling), limit_text(study, result, coupling));
  for (const FailedRun& run : result.failed)
    complain(fmt::format("epsilon = {} on {} elements: {}", run.epsilon, run.elements, run.what));
  if (missed) complain(fmt::format("the error that was asked for is not kept at epsilon = 0: {}", missed->doubt));
  return result.failed.empty() && !missed ? success : run_failed;
}

}  // namespace viscobar::cli
