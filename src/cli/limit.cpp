#include <algorithm>
#include <limits>
#include <optional>

#include "cli/commands.hpp"

namespace viscobar::cli {

namespace {

constexpr DecadeRange epsilons{"--epsilon", "a positive number", "1e-2:1e-8", std::numeric_limits<double>::min(),
                               std::numeric_limits<double>::max()};

struct LimitOptions : StudyOptions {
  using StudyOptions::StudyOptions;
  LimitStudy study;
  std::string epsilon, mass, elements, error;
  CLI::Option* budget = nullptr;
  std::size_t per_decade = 1;
};

/// "27,54,108", or "27:108", doubled from mesh to mesh.
std::vector<std::size_t> meshes_named(const std::string& text) {
  std::vector<std::size_t> meshes;
  if (text.empty()) return meshes;
  const auto range = text.find(':');
  for (std::string word : CLI::detail::split(text, range == std::string::npos ? ',' : ':')) {
    if (const std::string problem = number_of_elements(word); !problem.empty()) refuse("--elements: {}", problem);
    meshes.push_back(std::stoul(word));
  }
  if (range == std::string::npos) return meshes;
  if (meshes.size() != 2 || meshes[0] > meshes[1]) refuse("--elements: \"{}\" is no range; it is FIRST:LAST", text);
  const std::size_t last = meshes[1];
  meshes.pop_back();
  while (2 * meshes.back() <= last) meshes.push_back(2 * meshes.back());
  return meshes;
}

int study_limit(const LimitOptions& asked) {
  LimitStudy study = asked.study;
  study.elements = meshes_named(asked.elements);
  std::optional<double> relative, absolute;
  if (const auto before = limit_asked(asked.scene.text())) {
    const auto open = [&](const char* key) {
      return std::ranges::none_of(asked.scene.overrides, [&](const auto& set) { return set.starts_with(key); });
    };
    const bool same_meshes = study.elements.empty() && asked.error.empty() && open("mesh.elements");
    study.epsilons = before->epsilons;
    if (same_meshes) study.elements = before->elements;
    if (same_meshes && study.steps.empty() && open("method.step")) study.steps = before->steps;
    if (asked.budget->empty()) study.budget = before->budget;
    if (open("method.relative_tolerance")) relative = before->scene.tolerance.relative;
    if (open("method.absolute_tolerance")) absolute = before->scene.tolerance.absolute;
  }
  if (!asked.epsilon.empty()) study.epsilons = epsilons(asked.epsilon, asked.per_decade);
  std::vector<Setting> settings = finest_mesh(study.elements);
  if (!asked.mass.empty()) settings.emplace_back(std::pair("mesh.mass", asked.mass));
  if (!asked.error.empty()) settings.push_back("accuracy.error=" + asked.error);
  // The scene's own epsilon, which it may lack, is not used.
  SceneFile scene = asked.scene.read(settings, [&](Case& run) {
    if (study.epsilons.empty()) study.epsilons = natural_penalties(run.scene, asked.per_decade);
    run.epsilon = study.epsilons.front();
    if (relative) run.tolerance.relative = *relative;
    if (absolute) run.tolerance.absolute = absolute;
    run.method = penalised_method(run);
  });
  study.scene = scene.run;
  if (const auto fault = limit_fault(study.scene.scene))
    refuse("{}: {}", fault->key.empty() ? asked.scene.file : fault->key, fault->problem);
  const std::size_t meshes = std::max<std::size_t>(1, study.elements.size());
  if (!study.steps.empty() && study.steps.size() != meshes)
    refuse("--steps: {} given for {} mesh{}, one for each is needed", study.steps.size(), meshes,
           meshes == 1 ? "" : "es");
  const bool chooses = scene.accuracy && study.elements.empty();
  if (!asked.error.empty() && !chooses) refuse("--elements: --error chooses the mesh; give one of the two");

  const Study files(asked, scene, ResultKind::limit);
  StatusLine status;
  if (!asked.output.quiet && !asked.scene.json)
    study.row = [&](const LimitRow& row) {
      status.clear();
      say(limit_row_text(row));
    };
  if (!asked.output.quiet && on_terminal())
    study.progress = [&](std::size_t done, std::size_t of) { status.show(fmt::format("{} of {} runs", done, of)); };
  if (chooses) {
    if (study.progress) status.show("a mesh that keeps the error");
    const AccuracyResult solved = limit_to_accuracy(study, *scene.accuracy);
    study.elements = {solved.run.elements};
    study.estimate = solved.estimate;
  }
  catch_interrupts();
  study.interrupted = interrupt_asked;
  const std::optional<ErrorEstimate> missed = study.estimate && !study.estimate->kept ? study.estimate : std::nullopt;
  const LimitResult result = limit_of(study);
  status.clear();
  if (interrupt_asked() && files.replaces_whole()) {
    complain(fmt::format("interrupted; nothing was changed: {} holds a complete study", files.path().string()));
    return stopped;
  }
  files.finish(limit_report(scene, study, result, balance_errors(study, result)));
  for (const FailedRun& run : result.failed)
    complain(fmt::format("epsilon = {} on {} elements: {}", run.epsilon, run.elements, run.what));
  if (missed) complain(fmt::format("the error that was asked for is not kept at epsilon = 0: {}", missed->doubt));
  if (interrupt_asked()) {
    complain("interrupted; what the study came to is written");
    return stopped;
  }
  return result.failed.empty() && !missed ? success : run_failed;
}

}  // namespace

Action limit_command(CLI::App& command) {
  const auto asked = std::make_shared<LimitOptions>(command);
  LimitStudy& study = asked->study;
  add(command, "--epsilon", "FIRST:LAST", asked->epsilon,
      "The penalties, from the first down to the last (default: 1e-2 to 1e-8 times L/E, under a span obstacle alone "
      "L^2/E)");
  within(add(command, "--per-decade", "N", asked->per_decade, "Penalties a decade"), 1, 100)->capture_default_str();
  add(command, "--mass", "NAME", asked->mass, "The mass matrix, in place of the scene's");
  add(command, "--elements", "N,N...", asked->elements,
      "Meshes, in place of the scene's, or FIRST:LAST, doubled; three or more: also the bar's own motion, and epsilon(h)");
  add_list(command, "--steps", "DT,DT...", study.steps,
           "Time steps of the scheme to start with, one for each mesh (default: the scene's)")
      ->check(positive_number);
  asked->budget = within(add(command, "--budget", "SECONDS", study.budget,
                             "Processor seconds of all runs; the study goes on by itself until the verdict is known"),
                         0.0, 1e6)
                      ->capture_default_str();
  asked->scene.takes_accuracy = true;
  add_error(command, asked->error, "Choose the elements so that the limit epsilon = 0 keeps this error of the mesh");
  add_threads(command, study.threads);
  return [asked] { return study_limit(*asked); };
}

}  // namespace viscobar::cli
