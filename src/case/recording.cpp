#include "viscobar/case/recording.hpp"

namespace viscobar {

void Recording::keep(const Snapshot& s, std::span<const Direction> directions) {
  times.push_back(s.time);
  u.insert(u.end(), s.u.begin(), s.u.end());
  v.insert(v.end(), s.v.begin(), s.v.end());
  reaction_left.push_back(s.reaction_left);
  reaction_right.push_back(s.reaction_right);
  if (s.energy) energy.push_back(*s.energy);
  for (std::size_t k = sensitivities.size(); k < directions.size(); ++k)
    sensitivities.push_back({directions[k].key, {}, {}, {}, {}});
  for (std::size_t k = 0; k < s.sensitivities.size(); ++k) {
    const FieldSensitivity& from = s.sensitivities[k];
    RecordedSensitivity& to = sensitivities[k];
    to.u.insert(to.u.end(), from.u.begin(), from.u.end());
    to.v.insert(to.v.end(), from.v.begin(), from.v.end());
    to.reaction_left.push_back(from.reaction_left);
    to.reaction_right.push_back(from.reaction_right);
  }
}

Recording record(const Case& run) {
  const BarSystem system = make_system(run);
  Recording recording;
  recording.label = name(run.method);
  recording.mesh = run.mesh();
  const std::size_t outputs = run.output_times().size();
  for (std::vector<double>* field : {&recording.u, &recording.v}) field->reserve(outputs * recording.mesh.nodes());
  Observers observers;
  observers.energy = observers.account = true;
  observers.directions = run.directions;
  observers.snapshot = [&](const Snapshot& s) { recording.keep(s, run.directions); };
  observers.event = [&](const Event& event) { recording.events.push_back(event); };
  recording.statistics = simulate(run, system, observers);
  return recording;
}

}  // namespace viscobar
