#include "viscobar/io/record_run.hpp"

#include <new>

#include "dynamics/archive.hpp"
#include "io/checkpoint_clock.hpp"
#include "io/checkpoint_file.hpp"
#include "io/described_scene.hpp"
#include "io/growing_files.hpp"
#include "io/output_file.hpp"
#include "io/report.hpp"
#include "io/result_directory.hpp"
#include "io/summary.hpp"
#include "io/write_page.hpp"
#include "viscobar/analysis/chatter.hpp"
#include "viscobar/io/io_error.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

/// The first failure is what the user needs to know; those that follow from it are not.
void fail(Outcome& outcome, Ending ending, const std::string& error) {
  if (outcome.ending == Ending::completed) {
    outcome.ending = ending;
    outcome.error = error;
  }
}

template <class Action>
void attempt(Outcome& outcome, Action&& action) {
  try {
    action();
  } catch (const IoError& error) {
    fail(outcome, Ending::failed, error.what());
  }
}

void simulate_into(Outcome& outcome, const Case& run, const BarSystem& system, const std::optional<Checkpoint>& from,
                   const Observers& observers) {
  try {
    outcome.statistics = from ? simulate(run, system, *from, observers) : simulate(run, system, observers);
  } catch (const Interrupted& error) {
    fail(outcome, Ending::interrupted, error.what());
  } catch (const IntegrationError& error) {
    outcome.statistics = error.statistics;
    fail(outcome, Ending::failed, error.what());
  } catch (const std::invalid_argument& error) {
    fail(outcome, Ending::refused, error.what());
  } catch (const std::bad_alloc&) {
    fail(outcome, Ending::failed, "there is not enough memory");
  } catch (const std::exception& error) {
    fail(outcome, Ending::failed, error.what());
  }
  if (!outcome.statistics) return;
  outcome.reached_time = outcome.statistics->reached_time;
  outcome.steps = outcome.statistics->steps;
  outcome.events = outcome.statistics->events;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// A run and its files, from the beginning or from a checkpoint.
RunRecord record(const SceneFile& scene, const fs::path& directory, const RecordOptions& options, RunCheckpoint last) {
  const Case& run = scene.run;
  const BarSystem system = make_system(run);
  ContactSummary contact(run.scene);
  ReportData data(run, system);
  RunRecord record;
  Outcome& outcome = record.outcome;
  const auto write_summary = [&] {
    record.summary = summary_json(scene, system, outcome, contact);
    write_atomically(directory / "summary.json", record.summary);
  };

  // A run that is killed leaves this one, and no report of an earlier run beside its own files.
  fs::remove(directory / "report.html");
  outcome.ending = Ending::interrupted;
  outcome.error = "the run is going on, or was killed";
  write_summary();
  outcome = {};
  if (last.schedule && !last.motion) write_checkpoint(directory, last);

  ChatterWatch chatter(system);
  if (last.motion) {
    ArchiveReader archive(last.collected);
    archive(contact, data, chatter, outcome.warnings);
    outcome.reached_time = last.motion->time;
    outcome.steps = last.motion->statistics.steps;
    outcome.events = last.motion->statistics.events;
  }
  outcome.checkpoints = last.times;
  GrowingFiles files(directory, run, last.motion ? &last.files : nullptr);

  Observers observers;
  observers.energy = true;
  observers.snapshot = [&](const Snapshot& snapshot) {
    files.ends.append(snapshot);
    files.field.append(snapshot);
    contact.add(snapshot);
    data.add(snapshot);
  };
  observers.event = [&](const Event& event) {
    ++outcome.events;
    files.events.append(event);
    contact.add(event);
    data.add(event);
    if (options.event) options.event(event);
    if (const auto first = chatter.heard(event)) {
      outcome.warnings.push_back(chatter_warning(run, system, *first));
      if (options.warning) options.warning(outcome.warnings.back());
    }
  };
  bool stopping = false;
  const bool simulated = last.schedule && last.schedule->clock == CheckpointEvery::Clock::simulated;
  std::optional<CheckpointClock> clock;
  if (last.schedule && !simulated) clock.emplace(last.schedule->interval);
  observers.progress = [&](double time) {
    outcome.reached_time = time;
    ++outcome.steps;
    if (options.progress) options.progress(time, outcome.steps);
    stopping = stopping || (options.stop && options.stop());
    if (stopping && simulated) throw Interrupted();
  };
  if (last.schedule || options.stop) {
    Checkpoints& checkpoints = observers.checkpoints.emplace();
    if (simulated) checkpoints.every = last.schedule->interval;
    checkpoints.asked = [&] { return stopping || (clock && clock->due()); };
    checkpoints.take = [&](const Checkpoint& motion) {
      const auto write = [&] {
        std::vector<double> times = outcome.checkpoints;
        times.push_back(motion.time);
        ArchiveWriter archive;
        archive(contact, data, chatter, outcome.warnings);
        write_checkpoint(directory, {scene.description, last.schedule, motion, files.mark(), archive.take(), times,
                                     last.wall_seconds + seconds_since(options.started)});
        outcome.checkpoints = std::move(times);
      };
      clock ? clock->make(write) : write();
      if (stopping) throw Interrupted();
    };
  }
  simulate_into(outcome, run, system, last.motion, observers);
  // Each for itself: what one cannot write, another may.
  attempt(outcome, [&] { files.ends.close(); });
  attempt(outcome, [&] { files.events.close(); });
  attempt(outcome, [&] { files.field.close(); });

  const auto stop_clock = [&] { outcome.wall_seconds = last.wall_seconds + seconds_since(options.started); };
  stop_clock();
  attempt(outcome, [&] {
    const Page page = report_page(run, system, outcome, contact, data);
    write_atomically(directory / "report.html", page.html());
    if (options.figures) write_figures(directory, page.figure_files());
  });
  stop_clock();
  const Ending before = outcome.ending;
  attempt(outcome, write_summary);
  // The text says what happened also where the file could not.
  if (outcome.ending != before) record.summary = summary_json(scene, system, outcome, contact);
  if (outcome.ending == Ending::completed) remove_checkpoints(directory);
  return record;
}

}  // namespace

RunRecord record_run(const SceneFile& scene, const fs::path& directory, const RecordOptions& options) {
  prepare_result_directory(directory);
  // One of an earlier run does not belong to the files of this one.
  remove_checkpoints(directory);
  RunCheckpoint beginning;
  beginning.description = scene.description;
  beginning.schedule = options.checkpoint;
  return record(scene, directory, options, std::move(beginning));
}

SceneFile scene_of_checkpoint(const fs::path& directory) {
  const std::string description = read_checkpoint(directory).checkpoint.description;
  SceneFile scene = described_scene(description, directory.string());
  if (scene.description != description)
    throw IoError(directory, "the scene in the checkpoint is not understood as it was");
  return scene;
}

RunRecord resume_run(const SceneFile& scene, const fs::path& directory, const RecordOptions& options,
                     const std::function<void(const std::string&)>& complain) {
  FoundCheckpoint found = read_checkpoint(directory);
  if (found.checkpoint.description != scene.description)
    throw std::invalid_argument(directory.string() + " holds the checkpoint of another scene; nothing was changed");
  if (found.checkpoint.motion) found.checkpoint.files.check(directory);
  if (!found.complaint.empty() && complain) complain(found.complaint);
  if (!found.complaint.empty()) remove_newest_checkpoint(directory);
  return record(scene, directory, options, std::move(found.checkpoint));
}

}  // namespace viscobar
