#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "results/checksum.hpp"
#include "viscobar/case/case.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/results/outcome.hpp"

namespace viscobar {

/// Files of a result, by their path within its directory.
using FileChecksums = std::map<std::string, Checksum>;

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

/// The text of a summary with the files that belong to it and its own checksum behind all else:
///
///     "files": {"ends.csv": {"bytes": 4711, "crc64": "995dc9bbdf1939fa"}, ...},
///     "crc64": that of this text with sixteen zeros in its place
std::string sealed_summary(nlohmann::ordered_json summary, const FileChecksums& files);
std::string sealed_summary(const std::string& summary, const FileChecksums& files);

enum class Seal {
  sound,
  broken,  ///< the text is not the one that was written
  absent   ///< there is none: of a version that did not make them
};
Seal seal_of(std::string_view text);

/// Those of a summary whose seal is sound.
FileChecksums files_of(std::string_view summary);

}  // namespace viscobar
