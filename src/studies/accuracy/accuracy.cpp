#include "viscobar/studies/accuracy/accuracy.hpp"

#include <stdexcept>
#include <utility>

#include "studies/accuracy/plan.hpp"

namespace viscobar {

namespace {

// What a recording says, as a probe would have told it.
accuracy::Sample sample_of_recording(const Case& run, const Recording& recording) {
  accuracy::Probe probe(run);
  for (std::size_t k = 0; k < recording.times.size(); ++k)
    probe.add(Snapshot{recording.times[k], recording.displacement(k), recording.velocity(k)});
  for (const Event& event : recording.events) probe.add(event);
  return probe.take(recording.statistics);
}

}  // namespace

AccuracyResult solve(const AccuracyStudy& study) {
  accuracy::Plan plan(study);
  AccuracyResult result;
  do {
    result.run = plan.next();
    result.recording = record(result.run);
    result.estimate = plan.judge(sample_of_recording(result.run, result.recording));
  } while (plan.again());
  return result;
}

}  // namespace viscobar
