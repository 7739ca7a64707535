#include <filesystem>
#include <memory>
#include <string>

#include "case/run_cost.hpp"
#include "cli/commands.hpp"
#include "report/compare/finished_runs.hpp"
#include "report/judge/judge_request.hpp"

namespace viscobar::cli {

namespace {

struct CompareOptions : StudyOptions {
  using StudyOptions::StudyOptions;
  std::vector<std::string> methods, with, results;
  std::size_t threads = 0;
};

/// Fields of every method are kept, displacement and velocity at each node and output time.
void check_memory(const Case& run, std::size_t methods) {
  const double bytes = 2.0 * sizeof(double) * static_cast<double>(methods) * static_cast<double>(run.mesh().nodes()) *
                       (run.end / run.output_every + 1.0);
  if (bytes > memory_limit())
    refuse(
        "output.every: comparing keeps the fields of all methods, here {:.0f} GB; take a larger one, or "
        "fewer methods",
        bytes / 1e9);
}

int judge_solutions(const CompareOptions& asked) {
  if (!asked.methods.empty())
    refuse("--methods: solutions of others (--with) are held against the bar itself, by no method of choice");
  SceneOptions scene = asked.scene;
  scene.takes_accuracy = true;
  std::vector<std::vector<std::string>> schemes;
  for (const std::string& files : asked.with) schemes.push_back(CLI::detail::split(files, ','));
  PreparedJudgement prepared = prepared_judgement(schemes, scene.read(of_the_bar_itself()));
  prepared.study.threads = asked.threads;
  const Study study(asked, prepared.scene, ResultKind::judge);
  const JudgeResult judgement = judge(prepared.study);
  study.finish(judge_report(prepared, judgement));
  return success;
}

int compare_results(CompareOptions asked) {
  if (!asked.methods.empty() || !asked.with.empty() || !asked.scene.overrides.empty())
    refuse("results are compared as they are: --methods, --with and --set belong to a scene");
  std::vector<std::string> directories = asked.results;
  directories.insert(directories.begin(), asked.scene.file);
  if (directories.size() < 2) refuse("{} is a result: name another one to compare it with", asked.scene.file);
  FinishedRuns finished = finished_runs(directories);
  if (asked.output.where.empty()) asked.output.where = "compare.out";
  MethodChoice choice;
  choice.remarks = std::move(finished.remarks);
  const Comparison check = compare(std::move(finished.runs));
  Study(asked, finished.scene, ResultKind::compare).finish(compare_report(finished.scene, choice, check));
  return success;
}

int compare_methods(const CompareOptions& asked) {
  if (!asked.results.empty())
    refuse("{}: results are compared with results, and {} is a scene", asked.results.front(), asked.scene.file);
  const std::vector<MethodName> methods = methods_named(asked.methods);
  const SceneFile scene = asked.scene.read({}, [](Case& run) {
    if (is_penalised(run.method)) run.method = penalised_method(run);
  });
  const MethodChoice choice = methods.empty() ? fitting_methods(scene.run) : chosen_methods(scene.run, methods);
  if (choice.cases.size() < 2) {
    std::string reasons;
    for (const auto& [method, reason] : choice.skipped) reasons += fmt::format("\n  {}: {}", name(method), reason);
    refuse("fewer than two methods, nothing to compare{}", reasons);
  }
  check_memory(scene.run, choice.cases.size());
  const Study study(asked, scene, ResultKind::compare);
  const Comparison check = compare(choice.cases, asked.threads);
  study.finish(compare_report(scene, choice, check));
  for (const MethodRun& run : check.runs)
    if (!run.recording) complain(fmt::format("{}: {}", name(run.setup.run.method), run.error));
  return check.completed() ? success : run_failed;
}

}  // namespace

Action compare_command(CLI::App& command) {
  const auto asked = std::make_shared<CompareOptions>(command);
  add(command, "results", "DIR", asked->results,
      "With a directory of results instead of the scene: those to compare it with, as they are");
  add_list(command, "--methods", "NAME,NAME...", asked->methods,
           "The methods, the first one the reference (default: all that fit the scene, characteristics or else "
           "exponential the reference where it does)");
  add_repeatable(
      command, "--with", "FILE[=STEP],...", asked->with,
      "Solutions by another's scheme, CSV files with columns of ends.csv, gauges.csv or events.csv, beside the bar's own "
      "motion; with the steps of the scheme its order is told (repeatable, for each scheme)");
  add_threads(command, asked->threads);
  return [asked] {
    std::error_code unknown;
    if (std::filesystem::is_directory(asked->scene.file, unknown)) return compare_results(*asked);
    return asked->with.empty() ? compare_methods(*asked) : judge_solutions(*asked);
  };
}

}  // namespace viscobar::cli
