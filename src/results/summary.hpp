#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "input/seal.hpp"
#include "viscobar/case/case.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/results/outcome.hpp"

namespace viscobar {

/// summary.json: what was run, what it cost, what came out, and the checksums of the other files. Numbers that a run
/// could not tell are null. `max_reaction` of an impact may have no limit under refinement: see peak_remark().
std::string summary_json(const SceneFile& scene, const BarSystem& system, const Outcome& outcome,
                         const FileChecksums& files);

/// Has it tell the scene that was run, and what of it was chosen.
void tell(nlohmann::ordered_json& json, const SceneFile& scene);

/// As summaries tell them.
nlohmann::ordered_json to_json(const ErrorEstimate& estimate);
nlohmann::ordered_json to_json(const EnergyAccount& energy);
nlohmann::ordered_json to_json(const Allowance& absolute);

/// The sealed text of a summary with the files that belong to it:
///
///     "files": {"ends.csv": {"bytes": 4711, "crc64": "995dc9bbdf1939fa"}, ...}
std::string sealed_summary(nlohmann::ordered_json summary, const FileChecksums& files);
std::string sealed_summary(const std::string& summary, const FileChecksums& files);

}  // namespace viscobar
