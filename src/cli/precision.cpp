#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "cli/commands.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "cli/progress.hpp"
#include "results/result_directory.hpp"
#include "viscobar/report/reports.hpp"
#include "viscobar/studies/limit/limit.hpp"

namespace viscobar::cli {

namespace {

constexpr DecadeRange tolerances{"--tolerance", "a number from 1e-14 to 0.1", "1e-3:1e-10", 1e-14, 0.1};

void check_lists(const PrecisionStudy& study) {
  for (auto mesh = study.elements.begin(); mesh != study.elements.end(); ++mesh)
    if (std::find(study.elements.begin(), mesh, *mesh) != mesh)
      throw std::invalid_argument(fmt::format("--elements: {} is given twice", *mesh));
  for (auto method = study.methods.begin(); method != study.methods.end(); ++method)
    if (std::find(study.methods.begin(), method, *method) != method)
      throw std::invalid_argument(fmt::format("--methods: {} is asked for twice", name(*method)));
  if (study.repeat % 2 == 0 && study.repeat > 0)
    throw std::invalid_argument("--repeat: the median needs an odd number of runs, 3 or more");
}

}  // namespace

PrecisionCommand::PrecisionCommand(CLI::App& app)
    : Command(app, "precision",
              "Measure time against error for the methods that fit the scene, and split the error into space, penalty "
              "and time"),
      scene_(command_),
      output_(command_) {
  command_.add_option("--methods", methods_, "The methods (default: all that fit the scene)")
      ->type_name("NAME,NAME...")
      ->delimiter(',')
      ->allow_extra_args(false);
  command_.add_option("--tolerance", tolerance_, "Relative tolerances of adaptive methods, a decade apart")
      ->type_name("FIRST:LAST")
      ->capture_default_str();
  command_.add_option("--halvings", halvings_, "How often the schemes' step is halved, from h / c on")
      ->type_name("N")
      ->check(CLI::Range(0, 30))
      ->capture_default_str();
  command_.add_option("--elements", elements_, "Meshes, in place of the scene's")
      ->type_name("N,N...")
      ->delimiter(',')
      ->check(number_of_elements())
      ->allow_extra_args(false);
  command_.add_option("--repeat", repeat_, "Timed runs of each row, whose median counts (default: 3 to 11)")
      ->type_name("N")
      ->check(CLI::Range(3, 9999));
  command_.add_option("--seconds", seconds_, "Runs that take longer are left out")
      ->type_name("SECONDS")
      ->check(positive_number())
      ->capture_default_str();
  add_threads(command_, threads_, "References at a time; timed runs run alone");
}

int PrecisionCommand::operator()() const {
  PrecisionStudy study;
  study.methods = methods_named(methods_);
  study.tolerances = tolerances(tolerance_);
  study.elements = elements_;
  study.halvings = halvings_;
  study.repeat = repeat_;
  study.seconds = seconds_;
  study.threads = threads_;
  check_lists(study);
  std::vector<std::string> mesh;  // the scene is checked on the finest mesh
  if (!elements_.empty())
    mesh.push_back(fmt::format("mesh.elements={}", *std::max_element(elements_.begin(), elements_.end())));
  const SceneFile scene = scene_.read({}, mesh);
  study.scene = scene.run;
  const std::filesystem::path directory = output_.directory(scene_);
  const ResultDirectory results(directory, ResultKind::precision);
  if (!output_.quiet) warn_of_other_scenes(directory, scene, "precision.json");

  end_on_interrupt();
  StatusLine status;
  if (!scene_.json && !output_.quiet && on_terminal())
    study.progress = [&](const std::string& what) { status.show(what); };
  const PrecisionResult result = precision_of(study);
  status.clear();
  finish_study("precision", directory, scene_, output_, scene, precision_json(scene, study, result),
               precision_page(study, result), precision_text(study, result) + "\n");
  const bool something =
      std::any_of(result.rows.begin(), result.rows.end(), [](const PrecisionRow& run) { return run.failure.empty(); });
  if (!something) complain(fmt::format("every run failed; the first: {}", result.rows.front().failure));
  return something ? success : run_failed;
}

}  // namespace viscobar::cli
