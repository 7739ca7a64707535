#include <algorithm>

#include "cli/commands.hpp"

namespace viscobar::cli {

namespace {

constexpr DecadeRange tolerances{"--tolerance", "a number from 1e-14 to 0.1", "1e-3:1e-10", 1e-14, 0.1};

struct PrecisionOptions : StudyOptions {
  using StudyOptions::StudyOptions;
  PrecisionStudy study;
  std::string tolerance = "1e-3:1e-10";
  std::vector<std::string> methods;
};

template <class Value>
const Value* repeated(const std::vector<Value>& values) {
  for (auto value = values.begin(); value != values.end(); ++value)
    if (std::find(values.begin(), value, *value) != value) return &*value;
  return nullptr;
}

void check_lists(const PrecisionStudy& study) {
  if (const auto* mesh = repeated(study.elements)) refuse("--elements: {} is given twice", *mesh);
  if (const auto* method = repeated(study.methods)) refuse("--methods: {} is asked for twice", name(*method));
  if (study.repeat % 2 == 0 && study.repeat > 0) refuse("--repeat: the median needs an odd number of runs, 3 or more");
}

int study_precision(const PrecisionOptions& asked) {
  PrecisionStudy study = asked.study;
  study.methods = methods_named(asked.methods);
  study.tolerances = tolerances(asked.tolerance);
  check_lists(study);
  const SceneFile scene = asked.scene.read(finest_mesh(study.elements));
  study.scene = scene.run;
  const Study files(asked, scene, ResultKind::precision);
  StatusLine status;
  if (!asked.scene.json && !asked.output.quiet && on_terminal())
    study.progress = [&](const std::string& what) { status.show(what); };
  const PrecisionResult result = precision_of(study);
  status.clear();
  files.finish(precision_report(scene, study, result));
  const bool something = std::ranges::any_of(result.rows, [](const PrecisionRow& run) { return run.failure.empty(); });
  if (!something) complain(fmt::format("every run failed; the first: {}", result.rows.front().failure));
  return something ? success : run_failed;
}

}  // namespace

Action precision_command(CLI::App& command) {
  const auto asked = std::make_shared<PrecisionOptions>(command);
  PrecisionStudy& study = asked->study;
  add_list(command, "--methods", "NAME,NAME...", asked->methods, "The methods (default: all that fit the scene)");
  add(command, "--tolerance", "FIRST:LAST", asked->tolerance, "Relative tolerances of adaptive methods, a decade apart")
      ->capture_default_str();
  within(add(command, "--halvings", "N", study.halvings, "How often the schemes' step is halved, from h / c on"), 0, 30)
      ->capture_default_str();
  add_list(command, "--elements", "N,N...", study.elements, "Meshes, in place of the scene's")
      ->check(number_of_elements);
  within(add(command, "--repeat", "N", study.repeat,
             "Timed runs of each row, an odd number, whose median counts (default: up to 11)"),
         3, 9999);
  add(command, "--seconds", "SECONDS", study.seconds, "Runs that take longer are left out")
      ->check(positive_number)
      ->capture_default_str();
  add_threads(command, study.threads, "References at a time; timed runs run alone (default: one a core)");
  return [asked] { return study_precision(*asked); };
}

}  // namespace viscobar::cli
