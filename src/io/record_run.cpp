#include "viscobar/io/record_run.hpp"

#include <new>

#include "dynamics/archive.hpp"
#include "io/checkpoint_clock.hpp"
#include "io/checkpoint_file.hpp"
#include "io/described_scene.hpp"
#include "io/growing_files.hpp"
#include "io/output_file.hpp"
#include "io/pace_watch.hpp"
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
class RecordedRun {
 public:
  RecordedRun(const SceneFile& scene, const fs::path& directory, const RecordOptions& options, RunCheckpoint last)
      : scene_(scene),
        directory_(directory),
        options_(options),
        last_(std::move(last)),
        system_(make_system(scene.run)),
        contact_(scene.run.scene),
        data_(scene.run, system_),
        chatter_(system_),
        pace_(0.0, scene.run.end) {
    if (last_.schedule && !simulated()) clock_.emplace(last_.schedule->interval);
  }

  RunRecord operator()() {
    begin();
    simulate_into(outcome(), scene_.run, system_, last_.motion, observers());
    // Each for itself: what one cannot write, another may.
    attempt(outcome(), [&] { files_->ends.close(), written_["ends.csv"] = files_->ends.checksum(); });
    attempt(outcome(), [&] { files_->events.close(), written_["events.csv"] = files_->events.checksum(); });
    attempt(outcome(), [&] {
      files_->field.close();
      written_["field.h5"] = files_->field.checksum();
      written_["field.xdmf"] = files_->field.xdmf_checksum();
    });
    write_pages();
    if (outcome().ending == Ending::completed) remove_checkpoints(directory_);
    return std::move(record_);
  }

 private:
  Outcome& outcome() { return record_.outcome; }
  bool simulated() const { return last_.schedule && last_.schedule->clock == CheckpointEvery::Clock::simulated; }
  double wall_seconds() const { return last_.wall_seconds + seconds_since(options_.started); }

  void write_summary() {
    record_.summary = summary_json(scene_, system_, outcome(), contact_, written_);
    write_atomically(directory_ / "summary.json", record_.summary);
  }

  void begin() {
    // A run that is killed leaves this one, and no report of an earlier run beside its own files.
    fs::remove(directory_ / "report.html");
    outcome().ending = Ending::interrupted;
    outcome().error = "the run is going on, or was killed";
    write_summary();
    outcome() = {};
    if (last_.schedule && !last_.motion) write_checkpoint(directory_, last_);
    files_.emplace(directory_, scene_.run, last_.motion ? &last_.files : nullptr);
    if (!last_.motion) return;
    ArchiveReader archive(last_.collected);
    archive(contact_, data_, chatter_, pace_, outcome().warnings);
    outcome().reached_time = last_.motion->time;
    outcome().steps = last_.motion->statistics.steps;
    outcome().events = last_.motion->statistics.events;
    outcome().checkpoints = last_.times;
  }

  Observers observers() {
    Observers observers;
    observers.energy = true;
    observers.snapshot = [this](const Snapshot& snapshot) {
      files_->ends.append(snapshot);
      files_->field.append(snapshot);
      contact_.add(snapshot);
      data_.add(snapshot);
    };
    observers.event = [this](const Event& event) {
      ++outcome().events;
      files_->events.append(event);
      contact_.add(event);
      data_.add(event);
      if (options_.event) options_.event(event);
      if (const auto first = chatter_.heard(event)) warn(chatter_warning(scene_.run, system_, *first));
    };
    observers.progress = [this](double time) {
      outcome().reached_time = time;
      ++outcome().steps;
      // The steps of a scheme are what the user chose.
      if (!is_scheme(scene_.run.method))
        if (const auto slow = pace_.heard(time)) warn(*slow);
      if (options_.progress) options_.progress(time, outcome().steps);
      stopping_ = stopping_ || (options_.stop && options_.stop());
      if (stopping_ && simulated()) throw Interrupted();
    };
    if (last_.schedule || options_.stop) {
      Checkpoints& checkpoints = observers.checkpoints.emplace();
      if (simulated()) checkpoints.every = last_.schedule->interval;
      checkpoints.asked = [this] { return stopping_ || (clock_ && clock_->due()); };
      checkpoints.take = [this](const Checkpoint& motion) { take(motion); };
    }
    return observers;
  }

  void warn(const std::string& warning) {
    outcome().warnings.push_back(warning);
    if (options_.warning) options_.warning(warning);
  }

  void take(const Checkpoint& motion) {
    const auto write = [&] {
      std::vector<double> times = outcome().checkpoints;
      times.push_back(motion.time);
      ArchiveWriter archive;
      archive(contact_, data_, chatter_, pace_, outcome().warnings);
      write_checkpoint(directory_, {scene_.description, last_.schedule, motion, files_->mark(), archive.take(), times,
                                    wall_seconds()});
      outcome().checkpoints = std::move(times);
    };
    clock_ ? clock_->make(write) : write();
    if (stopping_) throw Interrupted();
  }

  void write_pages() {
    outcome().wall_seconds = wall_seconds();
    attempt(outcome(), [&] {
      const Page page = report_page(scene_.run, system_, outcome(), contact_, data_);
      written_.merge(write_page(directory_, "report.html",
                                {page.html(), options_.figures ? page.figure_files() : std::vector<FigureFile>{}}));
    });
    outcome().wall_seconds = wall_seconds();
    const Ending before = outcome().ending;
    attempt(outcome(), [&] { write_summary(); });
    // The text says what happened also where the file could not.
    if (outcome().ending != before) record_.summary = summary_json(scene_, system_, outcome(), contact_, written_);
  }

  const SceneFile& scene_;
  const fs::path& directory_;
  const RecordOptions& options_;
  const RunCheckpoint last_;  // from which it goes on
  const BarSystem system_;
  ContactSummary contact_;
  ReportData data_;
  ChatterWatch chatter_;
  PaceWatch pace_;
  std::optional<GrowingFiles> files_;
  FileChecksums written_;  // what is whole
  std::optional<CheckpointClock> clock_;
  bool stopping_ = false;
  RunRecord record_;
};

}  // namespace

RunRecord record_run(const SceneFile& scene, const fs::path& directory, const RecordOptions& options) {
  prepare_result_directory(directory);
  // One of an earlier run does not belong to the files of this one.
  remove_checkpoints(directory);
  RunCheckpoint beginning;
  beginning.description = scene.description;
  beginning.schedule = options.checkpoint;
  return RecordedRun(scene, directory, options, std::move(beginning))();
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
  FoundCheckpoint found = read_checkpoint(directory, CheckFiles::yes);
  if (found.checkpoint.description != scene.description)
    throw std::invalid_argument(directory.string() + " holds the checkpoint of another scene; nothing was changed");
  if (!found.complaint.empty() && complain) complain(found.complaint);
  if (!found.complaint.empty()) remove_newest_checkpoint(directory);
  return RecordedRun(scene, directory, options, std::move(found.checkpoint))();
}

}  // namespace viscobar
