#include <utility>

#include "cli/commands.hpp"
#include "report/fit/fit_request.hpp"

namespace viscobar::cli {

namespace {

struct FitOptions : StudyOptions {
  using StudyOptions::StudyOptions;
  FitRequest request;
};

int fit_scene(const FitOptions& asked) {
  bool first = true;
  const auto [scene, problem] = prepared_fit(asked.request, [&](const std::vector<Setting>& settings) {
    return std::exchange(first, false) ? asked.scene.read(settings) : asked.scene.parse(settings);
  });
  const Study study(asked, scene, ResultKind::fit);
  const FitResult result = fit(problem);
  study.finish(fit_report(scene, problem, result));
  if (!result.converged) complain(fmt::format("fit: {}", result.reason));
  return result.converged ? success : run_failed;
}

}  // namespace

Action fit_command(CLI::App& command) {
  const auto asked = std::make_shared<FitOptions>(command);
  FitRequest& request = asked->request;
  add(command, "--data", "FILE", request.data, "Measured traces: t and columns of ends.csv (CSV)");
  add(command, "--events", "FILE", request.events, "Measured contact times, of the form of events.csv");
  add_list(command, "--parameters", "KEY,KEY...", request.parameters,
           "The keys to look for, such as bar.viscosity,left.gap")
      ->required();
  add_repeatable(command, "--bounds", "KEY=LOW:HIGH", request.bounds,
                 "Keep a parameter between two values, such as left.gap=0.05:0.2 (repeatable)");
  add_repeatable(
      command, "--deviation", "COLUMN=NUMBER", request.deviations,
      "Standard deviation of a column's noise, or of contact times, such as u_left=1e-3 or events=1e-4, in the "
      "unit of the file (repeatable; default: 1 % of the column's largest value, of the last contact time)");
  within(add(command, "--starts", "N", request.starts, "Begin so many times, spread over the bounds"), 1, 10000)
      ->capture_default_str();
  within(add(command, "--runs", "N", request.most_runs, "Runs of the model at most, for each start"), 1, 1000000)
      ->capture_default_str();
  return [asked] { return fit_scene(*asked); };
}

}  // namespace viscobar::cli
