#pragma once

#include <span>
#include <string>
#include <vector>

#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/compare/compare.hpp"

namespace viscobar {

/// Results of `viscobar run`, to be compared as they are.
struct FinishedRuns {
  SceneFile scene;                   ///< of the first
  std::vector<MethodRun> runs;       ///< named by their directories
  std::vector<std::string> remarks;  ///< on values that were interpolated, and scenes that differ
};

/// Reads them. Fields and traces of the others are taken at the output times that the first has while all go on, and at
/// its nodes: by cubics in time through u and v, by polynomials of degree five in x. Where a run has no field.h5 its
/// ends are all there is. @throws std::invalid_argument, IoError
FinishedRuns finished_runs(std::span<const std::string> directories);

}  // namespace viscobar
