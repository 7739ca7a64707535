#pragma once

#include <string>
#include <vector>

#include "input/trace_file.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/fit/fit.hpp"

namespace viscobar {

/// t and the columns that a file of measurements may have, as read_traces() takes them.
std::vector<std::string> names_of_traces();
/// Reads a file of measurements, with times that can be those of the scene. @throws SceneError, std::invalid_argument
TraceFile read_measured(const SceneFile& scene, const std::string& file, const std::vector<std::string>& known,
                        const std::vector<std::string>& required, const std::vector<std::string>& words = {});
/// Values in the unit of the scene, where both have one. @throws std::invalid_argument for units that do not fit
void convert(TraceFile& table, TraceFile::Column& column, const std::string& unit, const std::string& file);
/// Name of the scene's unit of a column; empty: none.
std::string unit_of(TraceColumn column, const Units& units);

}  // namespace viscobar
