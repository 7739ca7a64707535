#include "viscobar/case/recording.hpp"

namespace viscobar {

Recording record(const Case& run) {
  const BarSystem system = make_system(run);
  Recording recording;
  recording.label = name(run.method);
  recording.mesh = run.mesh();
  Observers observers;
  observers.energy = observers.account = true;
  observers.directions = run.directions;
  for (const Direction& along : run.directions) recording.sensitivities.push_back({along.key, {}, {}, {}, {}});
  observers.snapshot = [&](const Snapshot& s) {
    recording.times.push_back(s.time);
    recording.u.insert(recording.u.end(), s.u.begin(), s.u.end());
    recording.v.insert(recording.v.end(), s.v.begin(), s.v.end());
    recording.reaction_left.push_back(s.reaction_left);
    recording.reaction_right.push_back(s.reaction_right);
    for (std::size_t k = 0; k < s.sensitivities.size(); ++k) {
      const FieldSensitivity& from = s.sensitivities[k];
      RecordedSensitivity& to = recording.sensitivities[k];
      to.u.insert(to.u.end(), from.u.begin(), from.u.end());
      to.v.insert(to.v.end(), from.v.begin(), from.v.end());
      to.reaction_left.push_back(from.reaction_left);
      to.reaction_right.push_back(from.reaction_right);
    }
  };
  observers.event = [&](const Event& event) { recording.events.push_back(event); };
  recording.statistics = simulate(run, system, observers);
  return recording;
}

}  // namespace viscobar
