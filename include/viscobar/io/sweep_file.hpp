#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "viscobar/analysis/sweep.hpp"
#include "viscobar/io/scene_file.hpp"

namespace viscobar {

/// A sweep as read: the scene, what holds for all cases, and what varies.
struct SweepFile {
  std::string title;                  ///< free text
  std::string scene_source;           ///< path of the scene, for diagnostics
  std::string scene_text;             ///< the scene itself, so that every worker runs the same
  std::vector<std::string> settings;  ///< "table.key=value" for all cases: [set], then those of the command line
  SweepPlan plan;                     ///< what varies

  /// Where a key of [set] or [vary] stands: a finding about its value in a case is one there.
  std::map<std::string, Diagnostic, std::less<>> places;

  /// All that decides about the results, as text: two sweeps with the same one have the same rows.
  std::string identity() const;
};

/// Reads a sweep (TOML, see docs/sweep.md) and its scene. The values are checked one by one; whether they fit together
/// is known case by case, see plan_cases().
/// @throws SceneError with everything wrong in the sweep file in one go
SweepFile read_sweep(const std::filesystem::path& file, std::span<const std::string> overrides = {});

/// The same from text; `file` names it in diagnostics, and its scene is looked for beside it.
SweepFile parse_sweep(const std::string& text, const std::filesystem::path& file,
                      std::span<const std::string> overrides = {});

/// A case as the workers run it: the scene's text and all overrides.
struct SweepCase {
  std::size_t index = 0;               ///< in the plan
  std::vector<std::string> overrides;  ///< "table.key=value", settings and varied keys
};

/// 0 <= index < sweep.plan.size()
SweepCase case_of(const SweepFile& sweep, std::size_t index);

/// What a case of the scene in `scene_text` is estimated to cost; 0 when it is refused.
double planned_seconds(const std::string& scene_text, const SweepCase& one);

/// Reads every case (on `threads`, or all cores) and estimates what it costs; 0 for one that is refused.
/// @throws SceneError when all are refused, with all reasons
std::vector<double> plan_cases(const SweepFile& sweep, std::size_t threads = 0);

/// Runs a case of the scene in `scene_text`. Whatever goes wrong with it is in the row: findings of the scene, the
/// integrator's words. `interrupted` is asked after each step. @throws Interrupted when it says yes
SweepRow run_case(const std::string& scene_text, const SweepCase& one, const std::function<bool()>& interrupted = {});

}  // namespace viscobar
