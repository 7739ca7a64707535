#pragma once

#include <string>
#include <vector>

#include "input/trace_file.hpp"
#include "results/json.hpp"
#include "scene/unit_names.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/fit/fit.hpp"

namespace viscobar {

/// t and the columns that a file of measurements may have, as read_traces() takes them.
std::vector<std::string> names_of_traces();
/// Reads a file of measurements, with times that can be those of the scene, and values in the units of the scene where
/// both have them. @throws SceneError, std::invalid_argument
TraceFile read_measured(const SceneFile& scene, const std::string& file, const std::vector<std::string>& known,
                        const std::vector<std::string>& required, const std::vector<std::string>& words = {});
/// The unit of a column, "u_left" or "stress@0.25"; of none where it is a strain or no such column.
UnitPowers unit_of_trace(const std::string& column);
/// Contact changes of a file with the columns t, where and change. @throws std::invalid_argument
std::vector<Event> changes_in(const TraceFile& table, const std::string& file);

/// The JSON of a study of measurements, with its warnings, the scene and the program at its end.
std::string study_json(Json json, const std::vector<std::string>& warnings, const SceneFile& scene);

}  // namespace viscobar
