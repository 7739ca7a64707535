#pragma once

#include <functional>
#include <string>
#include <vector>

#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/fit/fit.hpp"

namespace viscobar {

/// Request to `fit`, as text.
struct FitRequest {
  std::string data, events;             ///< files of the form of ends.csv and events.csv; empty: none
  std::vector<std::string> parameters;  ///< keys
  std::vector<std::string> bounds;      ///< "KEY=LOW:HIGH"
  std::vector<std::string> deviations;  ///< "COLUMN=NUMBER", or "events=NUMBER"
  std::size_t starts = 1, most_runs = 100;
};

struct PreparedFit {
  SceneFile scene;
  FitStudy study;
};

/// `read` gives the scene with further settings, "table.key=value"; the study's model calls it for each run.
/// @throws std::invalid_argument for a request that makes no sense, SceneError for files and scenes that do not
PreparedFit prepared_fit(const FitRequest& request,
                         const std::function<SceneFile(const std::vector<Setting>& settings)>& read);

}  // namespace viscobar
