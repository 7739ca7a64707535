#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "cli/commands.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "report/fit/fit_request.hpp"
#include "results/result_directory.hpp"
#include "viscobar/report/reports.hpp"

namespace viscobar::cli {

FitCommand::FitCommand(CLI::App& app)
    : Command(app, "fit", "Fit values of a scene to measured traces and contact times, by least squares"),
      scene_(command_),
      output_(command_) {
  command_.add_option("--data", data_, "Measured traces: t and columns of ends.csv (CSV)")->type_name("FILE");
  command_.add_option("--events", events_, "Measured contact times, of the form of events.csv")->type_name("FILE");
  command_.add_option("--parameters", parameters_, "The keys to look for, such as bar.viscosity,left.gap")
      ->type_name("KEY,KEY...")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->required();
  command_
      .add_option("--bounds", bounds_, "Keep a parameter between two values, such as left.gap=0.05:0.2 (repeatable)")
      ->type_name("KEY=LOW:HIGH")
      ->allow_extra_args(false);
  command_
      .add_option("--deviation", deviations_,
                  "Standard deviation of a column's noise, or of contact times, such as u_left=1e-3 or events=1e-4 "
                  "(repeatable; default: 1 % of the column's largest value, of the last contact time)")
      ->type_name("COLUMN=NUMBER")
      ->allow_extra_args(false);
  command_.add_option("--starts", starts_, "Begin so many times, spread over the bounds")
      ->type_name("N")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command_.add_option("--runs", runs_, "Runs of the model at most, for each start")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
}

int FitCommand::operator()() const {
  const FitRequest request{data_, events_, parameters_, bounds_, deviations_, starts_, runs_};
  bool first = true;
  const auto [scene, study] = prepared_fit(request, [&](const std::vector<std::string>& settings) {
    if (std::exchange(first, false)) return scene_.read({}, settings);
    std::vector<std::string> all = scene_.overrides;
    all.insert(all.end(), settings.begin(), settings.end());
    return read_scene(scene_.file, all);
  });
  const std::filesystem::path directory = output_.directory(scene_);
  const ResultDirectory results(directory, ResultKind::fit);
  if (!output_.quiet) warn_of_other_scenes(directory, scene, "fit.json");
  end_on_interrupt();
  const FitResult result = fit(study);
  finish_study("fit", directory, scene_, output_, scene, fit_json(scene, study, result), fit_page(scene, study, result),
               fit_text(study, result) + "\n");
  if (!result.converged) complain(fmt::format("fit: {}", result.reason));
  return result.converged ? success : run_failed;
}

}  // namespace viscobar::cli
