#include <nlohmann/json.hpp>
#include <utility>

#include "input/described_scene.hpp"
#include "studies/accuracy/plan.hpp"
#include "studies/accuracy/quick_estimate.hpp"
#include "viscobar/record/record_run.hpp"

namespace viscobar {

namespace {

RunRecord not_begun(const std::filesystem::path& directory) {
  RunRecord record;
  record.outcome.ending = Ending::interrupted;
  record.outcome.error = "interrupted before the solution was begun; nothing was written";
  record.directory = directory;
  record.summary =
      nlohmann::ordered_json{
          {"completed", false}, {"ending", "interrupted"}, {"error", record.outcome.error}, {"reached_time", 0.0}}
          .dump(2) +
      "\n";
  return record;
}

/// Has a probe hear what the observers of a run hear.
void observe(RecordOptions& own, const RecordOptions& options, accuracy::Probe& probe) {
  own.snapshot = [&](const Snapshot& snapshot) {
    probe.add(snapshot);
    if (options.snapshot) options.snapshot(snapshot);
  };
  own.event = [&](const Event& event) {
    probe.add(event);
    if (options.event) options.event(event);
  };
}

ErrorEstimate no_estimate(const AccuracyRequest& request, const std::string& why) {
  ErrorEstimate estimate;
  estimate.of = request.of;
  if (!request.relative) estimate.requested = request.error;
  estimate.doubt = "there is no estimate: " + why;
  return estimate;
}

}  // namespace

RunRecord record_with_estimate(const SceneFile& scene, const std::filesystem::path& directory,
                               const RecordOptions& options) {
  accuracy::Probe probe(scene.run);
  RecordOptions own = options;
  observe(own, options, probe);
  own.estimate = [&](Outcome& outcome) {
    constexpr double patience = 2.0;  // of the time that the run took
    try {
      const accuracy::Sample sample = probe.take(*outcome.statistics);
      outcome.error_estimate =
          accuracy::quick_estimate(scene.run, sample, patience * outcome.statistics->integration_seconds, options.stop);
    } catch (const std::exception&) {  // nobody asked for it: the run is whole without
    }
  };
  return record_run(scene, directory, own);
}

RunRecord record_to_accuracy(const SceneFile& scene, const std::filesystem::path& directory,
                             const RecordOptions& options) {
  if (!scene.accuracy) return record_run(scene, directory, options);
  AccuracyStudy study;
  study.scene = scene.run;
  study.request = *scene.accuracy;
  study.message = options.message;
  study.stop = options.stop;
  accuracy::Plan plan(study);
  while (true) {
    Case run = scene.run;
    std::string failure;
    try {
      run = plan.next();
    } catch (const accuracy::Stopped&) {
      return not_begun(directory);
    } catch (const IntegrationError& error) {
      failure = error.what();
    }
    accuracy::Probe probe(run);
    RecordOptions own = options;
    observe(own, options, probe);
    own.estimate = [&](Outcome& outcome) {
      try {
        outcome.error_estimate =
            failure.empty() ? plan.judge(probe.take(*outcome.statistics)) : no_estimate(study.request, failure);
      } catch (const accuracy::Stopped&) {
        outcome.error_estimate = no_estimate(study.request, "it was interrupted");
      } catch (const std::exception& error) {
        outcome.error_estimate = no_estimate(study.request, error.what());
      }
      if (const std::string& doubt = outcome.error_estimate->doubt; !doubt.empty() && !plan.again())
        outcome.warnings.push_back("error: " + doubt);
    };
    RunRecord record = record_run(with_settings(scene, run), directory, own);
    record.run = run;
    if (record.outcome.ending != Ending::completed || !failure.empty() || !plan.again()) return record;
  }
}

}  // namespace viscobar
