#include "viscobar/io/record_run.hpp"

#include "io/csv.hpp"
#include "io/field_file.hpp"
#include "io/output_file.hpp"
#include "io/report.hpp"
#include "io/result_directory.hpp"
#include "io/summary.hpp"
#include "io/write_page.hpp"
#include "viscobar/io/io_error.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

/// The files that grow with a run.
struct GrowingFiles {
  EndsCsv ends;
  EventsCsv events;
  FieldFile field;

  GrowingFiles(const fs::path& directory, const Case& run)
      : ends(directory / "ends.csv"),
        events(directory / "events.csv"),
        field(directory, run.mesh(), static_cast<std::size_t>(run.end / run.output_every) + 2) {}
};

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

void simulate_into(Outcome& outcome, const Case& run, const BarSystem& system, const Observers& observers) {
  try {
    outcome.statistics = simulate(run, system, observers);
  } catch (const Interrupted& error) {
    fail(outcome, Ending::interrupted, error.what());
  } catch (const IntegrationError& error) {
    outcome.statistics = error.statistics;
    fail(outcome, Ending::failed, error.what());
  } catch (const std::invalid_argument& error) {
    fail(outcome, Ending::refused, error.what());
  } catch (const std::exception& error) {
    fail(outcome, Ending::failed, error.what());
  }
  if (!outcome.statistics) return;
  outcome.reached_time = outcome.statistics->reached_time;
  outcome.steps = outcome.statistics->steps;
  outcome.events = outcome.statistics->events;
}

}  // namespace

RunRecord record_run(const SceneFile& scene, const fs::path& directory, const RecordOptions& options) {
  prepare_result_directory(directory);
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

  GrowingFiles files(directory, run);
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
  };
  observers.progress = [&](double time) {
    outcome.reached_time = time;
    ++outcome.steps;
    if (options.progress) options.progress(time, outcome.steps);
  };
  simulate_into(outcome, run, system, observers);
  // Each for itself: what one cannot write, another may.
  attempt(outcome, [&] { files.ends.close(); });
  attempt(outcome, [&] { files.events.close(); });
  attempt(outcome, [&] { files.field.close(); });

  const auto stop_clock = [&] {
    outcome.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - options.started).count();
  };
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
  return record;
}

}  // namespace viscobar
