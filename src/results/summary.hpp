#pragma once

#include <string>

#include "results/sealed_summary.hpp"
#include "viscobar/case/case.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/results/outcome.hpp"

namespace viscobar {

/// summary.json: what was run, what it cost, what came out, and the checksums of the other files. Numbers that a run
/// could not tell are null. `max_reaction` of an impact may have no limit under refinement: see peak_remark().
std::string summary_json(const SceneFile& scene, const BarSystem& system, const Outcome& outcome,
                         const FileChecksums& files);

}  // namespace viscobar
