#include <utility>
#include <vector>

#include "input/described_scene.hpp"
#include "results/json.hpp"
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
  record.summary = json_text(
      {{"completed", false}, {"ending", "interrupted"}, {"error", record.outcome.error}, {"reached_time", 0.0}});
  return record;
}

void observe(RecordOptions& own, const RecordOptions& options, accuracy::Probe& probe, std::vector<double> times) {
  own.watch_times = std::move(times);
  own.watch = [&](const Snapshot& snapshot) { probe.add(snapshot); };
  own.event = [&](const Event& event) {
    probe.add(event);
    if (options.event) options.event(event);
  };
}

AccuracyStudy study_of(const SceneFile& scene, const RecordOptions& options) {
  AccuracyStudy study;
  study.scene = scene.run;
  study.request = *scene.accuracy;
  study.message = options.message;
  study.stop = options.stop;
  return study;
}

ErrorEstimate no_estimate(const AccuracyRequest& request, const std::string& why) {
  ErrorEstimate estimate;
  estimate.of = request.of;
  if (!request.relative) estimate.requested = request.error;
  estimate.doubt = "there is no estimate: " + why;
  return estimate;
}

/// Judgement of a run, or why there is none.
template <class Judge>
void estimate_into(Outcome& outcome, const AccuracyRequest& request, Judge&& judge) {
  try {
    outcome.error_estimate = judge();
  } catch (const StudyStopped&) {
    outcome.error_estimate = no_estimate(request, "it was interrupted");
  } catch (const std::exception& error) {
    outcome.error_estimate = no_estimate(request, error.what());
  }
}

void warn_of_doubt(Outcome& outcome) {
  if (const std::string& doubt = outcome.error_estimate->doubt; !doubt.empty())
    outcome.warnings.push_back("error: " + doubt);
}

}  // namespace

RunRecord record_with_estimate(const SceneFile& scene, const std::filesystem::path& directory,
                               const RecordOptions& options) {
  std::vector<double> times = accuracy::times_of_errors(scene.run.end);
  accuracy::Probe probe(scene.run, times.size());
  RecordOptions own = options;
  observe(own, options, probe, std::move(times));
  own.estimate = [&](Outcome& outcome) {
    constexpr double patience = 2.0;  // of the time that the run took
    try {
      const accuracy::QuickEstimate found = accuracy::quick_estimate(
          scene.run, probe.take(*outcome.statistics), patience * outcome.statistics->integration_seconds, options.stop);
      outcome.error_estimate = found.estimate;
      outcome.no_estimate = found.why_not;
      if (found.estimate && !found.estimate->doubt.empty()) {
        warn_of_doubt(outcome);
        if (options.warning) options.warning(outcome.warnings.back());
      }
    } catch (const std::exception& error) {  // the run is whole without
      outcome.no_estimate = error.what();
    }
  };
  return record_run(scene, directory, own);
}

RunRecord record_to_accuracy(const SceneFile& scene, const std::filesystem::path& directory,
                             const RecordOptions& options) {
  if (!scene.accuracy) return record_run(scene, directory, options);
  const AccuracyStudy study = study_of(scene, options);
  accuracy::Plan plan(study);
  while (true) {
    Case run = scene.run;
    std::string failure;
    try {
      run = plan.next();
    } catch (const StudyStopped&) {
      return not_begun(directory);
    } catch (const IntegrationError& error) {
      failure = error.what();
    }
    accuracy::Probe probe(run, plan.times().size());
    RecordOptions own = options;
    observe(own, options, probe, plan.times());
    own.estimate = [&](Outcome& outcome) {
      estimate_into(outcome, study.request, [&] {
        return failure.empty() ? plan.judge(probe.take(*outcome.statistics)) : no_estimate(study.request, failure);
      });
      if (!plan.again()) warn_of_doubt(outcome);
    };
    RunRecord record = record_run(with_settings(scene, run), directory, own);
    record.run = run;
    if (record.outcome.ending != Ending::completed || !failure.empty() || !plan.again()) return record;
  }
}

RunRecord resume_to_accuracy(const SceneFile& scene, const std::filesystem::path& directory,
                             const RecordOptions& options, const std::function<void(const std::string&)>& complain) {
  if (!scene.accuracy) return resume_run(scene, directory, options, complain);
  RecordOptions own = options;
  own.estimate = [&](Outcome& outcome) {
    // Earlier parts of the run are in files only.
    estimate_into(outcome, *scene.accuracy, [&] {
      AccuracyStudy study = study_of(scene, options);
      study.resumed = true;
      accuracy::Plan plan(study);
      plan.next();
      return plan.judge();
    });
    warn_of_doubt(outcome);
  };
  return resume_run(scene, directory, own, complain);
}

}  // namespace viscobar
