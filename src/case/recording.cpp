#include "viscobar/case/recording.hpp"

namespace viscobar {

Recording record(const Case& run) {
  const BarSystem system = make_system(run);
  Recording recording;
  recording.label = name(run.method);
  recording.mesh = run.mesh();
  Observers observers;
  observers.energy = observers.account = true;
  observers.snapshot = [&](const Snapshot& s) {
    recording.times.push_back(s.time);
    recording.u.insert(recording.u.end(), s.u.begin(), s.u.end());
    recording.v.insert(recording.v.end(), s.v.begin(), s.v.end());
    recording.reaction_left.push_back(s.reaction_left);
    recording.reaction_right.push_back(s.reaction_right);
    if (s.energy) recording.energy.push_back(*s.energy);
  };
  observers.event = [&](const Event& event) { recording.events.push_back(event); };
  recording.statistics = simulate(run, system, observers);
  return recording;
}

}  // namespace viscobar
