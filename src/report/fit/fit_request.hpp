#pragma once

#include <functional>
#include <string>
#include <vector>

#include "input/trace_file.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/fit/fit.hpp"

namespace viscobar {

/// What somebody asks `fit` for, as text.
struct FitRequest {
  std::string data, events;             ///< files of the form of ends.csv and events.csv; empty: none
  std::vector<std::string> parameters;  ///< keys
  std::vector<std::string> bounds;      ///< "KEY=LOW:HIGH"
  std::vector<std::string> deviations;  ///< "COLUMN=NUMBER", or "events=NUMBER"
  std::size_t starts = 1, most_runs = 100;
};

/// Reads a file of measurements, with times that can be those of the scene. @throws SceneError, std::invalid_argument
TraceFile read_measured(const SceneFile& scene, const std::string& file, const std::vector<std::string>& known,
                        const std::vector<std::string>& required, const std::vector<std::string>& words = {});
/// Values in the unit of the scene, where both have one. @throws std::invalid_argument for units that do not fit
void convert(TraceFile& table, TraceFile::Column& column, const std::string& unit, const std::string& file);
/// Name of the scene's unit of a column; empty: none.
std::string unit_of(TraceColumn column, const Units& units);

/// A scene, and the study of it that was asked for.
struct PreparedFit {
  SceneFile scene;
  FitStudy study;
};

/// `read` gives the scene with further settings, "table.key=value"; the study's model calls it for each run.
/// @throws std::invalid_argument for a request that makes no sense, SceneError for files and scenes that do not
PreparedFit prepared_fit(const FitRequest& request,
                         const std::function<SceneFile(const std::vector<Setting>& settings)>& read);

}  // namespace viscobar
