#include "viscobar/record/record_run.hpp"

#include <algorithm>
#include <iterator>

#include "case/chatter.hpp"
#include "input/described_scene.hpp"
#include "record/run_outcome.hpp"
#include "report/page.hpp"
#include "report/run/run_page.hpp"
#include "results/checkpoint_file.hpp"
#include "results/file_set.hpp"
#include "results/growing_files.hpp"
#include "results/output_file.hpp"
#include "results/result_directory.hpp"
#include "results/summary.hpp"
#include "run/archive.hpp"
#include "run/stopwatch.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

template <class Action>
void attempt(Outcome& outcome, Action&& action) {
  try {
    action();
  } catch (const IoError& error) {
    fail(outcome, Ending::failed, error.what());
  }
}

/// When checkpoints are due on the clock: so many seconds after the last one was made, or as many as it took where that
/// is longer, so that the run keeps half of the time at least.
class CheckpointClock {
 public:
  explicit CheckpointClock(double interval) : interval_(interval) {}

  bool due() const { return last_.seconds() >= std::max(interval_, cost_); }

  template <class Make>
  void make(Make&& make) {
    const WallClock making;
    make();
    cost_ = making.seconds();
    last_ = WallClock();
  }

 private:
  double interval_, cost_ = 0.0;
  WallClock last_;
};

/// A run and its files, from the beginning or from a checkpoint.
class RecordedRun {
 public:
  /// Its files are in `place`, which is `directory` or the part of it for what is not finished.
  RecordedRun(const SceneFile& scene, const ResultDirectory& directory, fs::path place, const RecordOptions& options,
              RunCheckpoint last)
      : scene_(scene),
        directory_(directory),
        place_(std::move(place)),
        options_(options),
        last_(std::move(last)),
        setup_(resolve(scene.run)),
        system_(setup_.system()),
        data_(scene.run, system_),
        chatter_(system_),
        pace_(0.0, scene.run.end, PaceWatch::some_seconds(scene.run.mesh().nodes())) {
    if (last_.schedule && !simulated()) clock_.emplace(last_.schedule->interval);
  }

  RunRecord operator()() {
    begin();
    if (options_.watch && !last_.motion) {
      outputs_ = scene_.run.output_times();
      std::ranges::set_union(outputs_, options_.watch_times, std::back_inserter(times_));
    }
    simulate_into(outcome(), setup_, system_, last_.motion, observers(), times_);
    judge(outcome(), setup_, system_, [this](const std::string& warning) { warn(warning); });
    // Each for itself: what one cannot write, another may.
    for (std::size_t k = 0; k < files_->tables.size(); ++k) close(GrowingFiles::names[k], files_->tables[k]);
    close("field.h5", files_->field);
    if (written_.contains("field.h5")) written_["field.xdmf"] = files_->field->xdmf_checksum();
    if (options_.estimate && outcome().ending == Ending::completed) options_.estimate(outcome());
    write_report();
    finish();
    return std::move(record_);
  }

 private:
  Outcome& outcome() { return record_.outcome; }
  bool simulated() const { return last_.schedule && last_.schedule->clock == CheckpointEvery::Clock::simulated; }
  double wall_seconds() const { return last_.wall_seconds + WallClock(options_.started).seconds(); }

  template <class File>
  void close(const char* name, std::optional<File>& file) {
    if (!file) return;
    attempt(outcome(), [&] {
      file->close();
      written_[name] = file->checksum();
    });
  }

  void write_summary(const char* name = "summary.json", bool durable = false) {
    record_.summary = summary_json(scene_, system_, outcome(), written_);
    write_atomically(place_ / name, record_.summary, durable);
  }

  // Until the new files take their places, those of an earlier run that was stopped can be resumed.
  void begin() {
    if (!last_.motion) files_.emplace(place_, scene_, nullptr);
    const std::vector<std::string> figures = replaced_figures(place_ / "summary.json", {});
    // A run that is killed leaves this one, and no report of an earlier run beside its own files.
    outcome().ending = Ending::interrupted;
    outcome().error = "the run is going on, or was killed";
    write_summary();
    outcome() = {};
    // From here on files that an earlier summary tells of may change.
    for (const std::string& name : figures) remove_file(place_ / name);
    if (last_.motion) files_.emplace(place_, scene_, &last_.files);
    for (const char* old : {"report.html", ResultDirectory::final_summary}) remove_file(place_ / old);
    // Those of the run before that this one does not write.
    for (std::size_t k = 0; k < files_->tables.size(); ++k)
      if (!files_->tables[k]) remove_file(place_ / GrowingFiles::names[k]);
    for (const char* old : {"field.h5", "field.xdmf"})
      if (!files_->field) remove_file(place_ / old);
    if (!last_.motion) {
      // It may be what this run was resumed from: there is always one.
      last_.schedule ? write_checkpoint(place_, last_) : remove_checkpoints(place_);
      files_->take_places();
      if (!scene_.run.warning.empty()) warn(scene_.run.warning);
      return;
    }
    ArchiveReader archive(last_.collected);
    archive(data_, chatter_, pace_, outcome().warnings, outcome().changes);
    record_.began = outcome().reached_time = last_.motion->time;
    outcome().steps = last_.motion->statistics.steps;
    outcome().events = last_.motion->statistics.events;
    outcome().checkpoints = last_.times;
  }

  Observers observers() {
    Observers observers;
    observers.energy = observers.account = true;
    observers.directions = scene_.run.directions;
    observers.snapshot = [this](const Snapshot& snapshot) {
      const bool watched = !times_.empty() && std::ranges::binary_search(options_.watch_times, snapshot.time);
      if (watched) options_.watch(snapshot);
      if (watched && !std::ranges::binary_search(outputs_, snapshot.time)) return;
      files_->append(snapshot);
      data_.add(snapshot);
      if (options_.snapshot) options_.snapshot(snapshot);
    };
    observers.event = [this](const Event& event) {
      ++outcome().events;
      files_->append(event);
      if (!event.sensitivities.empty()) outcome().changes.push_back(event.sensitivities);
      data_.add(event);
      if (options_.event) options_.event(event);
      // Changes of the bar itself are no chatter of a mesh.
      if (scene_.run.method == MethodName::characteristics) return;
      if (const auto first = chatter_.heard(event)) warn(chatter_warning(setup_, system_, *first));
    };
    observers.progress = [this](double time) {
      outcome().reached_time = time;
      ++outcome().steps;
      // The steps of a scheme are what the user chose.
      if (!is_scheme(scene_.run.method))
        if (const auto slow = pace_.heard(time)) warn(*slow);
      if (options_.progress) options_.progress(time, outcome().steps);
      stopping_ = stopping_ || (options_.stop && options_.stop());
      return stopping_ && simulated() ? RunControl::stop : RunControl::go_on;
    };
    if (last_.schedule || options_.stop) {
      Checkpoints& checkpoints = observers.checkpoints.emplace();
      if (simulated()) checkpoints.every = last_.schedule->interval;
      checkpoints.asked = [this] { return stopping_ || (clock_ && clock_->due()); };
      checkpoints.take = [this](const Checkpoint& motion) {
        take(as_resumed(motion));
        return stopping_ ? RunControl::stop : RunControl::go_on;
      };
    }
    return observers;
  }

  // A run that is resumed has the output times alone.
  Checkpoint as_resumed(Checkpoint motion) const {
    if (times_.empty() || motion.outputs == 0) return motion;
    const auto told = std::ranges::upper_bound(outputs_, times_[motion.outputs - 1]);
    motion.outputs = static_cast<std::size_t>(told - outputs_.begin());
    return motion;
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
      archive(data_, chatter_, pace_, outcome().warnings, outcome().changes);
      write_checkpoint(place_, {last_.description, last_.chosen, last_.schedule, motion, files_->mark(), archive.take(),
                                times, wall_seconds()});
      outcome().checkpoints = std::move(times);
    };
    clock_ ? clock_->make(write) : write();
  }

  void write_report() {
    outcome().wall_seconds = wall_seconds();
    if (!scene_.run.files.report) return;
    attempt(outcome(), [&] {
      Page page = report_page(setup_, system_, outcome(), data_);
      outcome().wall_seconds = wall_seconds();  // the page's and the summary's
      tell_whole_run(page, outcome().wall_seconds);
      written_.merge(
          write_page(place_, "report.html", options_.figures ? page.with_figures() : PicturedPage{page.html(), {}}));
    });
  }

  // The summary comes last, and says completed only when all else is there.
  void finish() {
    record_.directory = place_;
    const bool replaces = place_ != directory_.path();
    if (outcome().ending == Ending::completed)
      attempt(outcome(), [&] {
        check_run_files(place_, written_);
        for (const auto& [name, checksum] : written_) sync_file(place_ / name);
        write_summary(replaces ? ResultDirectory::final_summary : "summary.json", true);
        sync_directory(place_);
        if (replaces) directory_.replace_by_finished();
        remove_checkpoints(place_);
        record_.directory = directory_.path();
      });
    if (outcome().ending == Ending::completed) return;
    if (!fs::exists(place_))
      record_.directory = directory_.path();  // whole, and not yet in its place: the error says so
    // The text says what happened also where the file cannot.
    record_.summary = summary_json(scene_, system_, outcome(), written_);
    attempt(outcome(), [&] {
      if (fs::exists(place_)) write_summary();
    });
  }

  const SceneFile& scene_;
  const ResultDirectory& directory_;
  const fs::path place_;
  const RecordOptions& options_;
  const RunCheckpoint last_;  // from which it goes on
  const Setup setup_;
  const BarSystem system_;
  ReportData data_;
  ChatterWatch chatter_;
  PaceWatch pace_;
  std::optional<GrowingFiles> files_;
  FileChecksums written_;  // of the files that are whole
  std::optional<CheckpointClock> clock_;
  std::vector<double> outputs_, times_;  // and those at which it is watched, too; empty where it is not
  bool stopping_ = false;
  RunRecord record_;
};

void tell_if_unlocked(const ResultDirectory& results, const RecordOptions& options) {
  if (!results.locked() && options.warning)
    options.warning(results.path().string() +
                    " is on a file system without locks: see to it that no other run uses it");
}

}  // namespace

RunRecord record_run(const SceneFile& scene, const fs::path& directory, const RecordOptions& options) {
  const ResultDirectory results(directory, ResultKind::run);
  tell_if_unlocked(results, options);
  RunCheckpoint beginning;
  beginning.description = scene.description();
  for (const auto& [key, value] : scene.chosen) beginning.chosen.push_back(key);
  beginning.schedule = options.checkpoint;
  return RecordedRun(scene, results, results.place_of_new_run(), options, std::move(beginning))();
}

SceneFile scene_of_checkpoint(const fs::path& directory) {
  settle_result_directory(directory);
  const RunCheckpoint found = read_checkpoint(place_of_stopped_run(directory)).checkpoint;
  SceneFile scene = described_scene(found.description, directory.string());
  if (scene.description() != found.description)
    throw IoError(directory, "the scene in the checkpoint is not understood as it was");
  count_as_chosen(scene, found.chosen);
  return scene;
}

RunRecord resume_run(const SceneFile& scene, const fs::path& directory, const RecordOptions& options,
                     const std::function<void(const std::string&)>& complain) {
  read_checkpoint(place_of_stopped_run(directory));  // where there is none, nothing is made
  const ResultDirectory results(directory);
  tell_if_unlocked(results, options);
  const fs::path place = place_of_stopped_run(directory);
  FoundCheckpoint found = read_checkpoint(place, CheckFiles::yes);
  if (found.checkpoint.description != scene.description())
    throw std::invalid_argument(directory.string() + " holds the checkpoint of another scene; nothing was changed");
  if (!found.complaint.empty() && complain) complain(found.complaint);
  if (!found.complaint.empty()) remove_newest_checkpoint(place);
  return RecordedRun(scene, results, place, options, std::move(found.checkpoint))();
}

}  // namespace viscobar
