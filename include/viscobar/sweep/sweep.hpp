#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"

namespace viscobar {

/// A key of a scene with the values that it takes in a sweep, all of one alternative.
struct VariedKey {
  /// Numbers, whole numbers, or texts.
  using Values = std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::string>>;
  std::string key;  ///< "table.key"
  Values values;    ///< at least one

  std::size_t size() const;  ///< number of values
};

/// How the values of several keys make cases.
enum class Combine {
  grid,  ///< every value with every other, the last key running fastest
  zip    ///< the first values, the second ones, ...
};

/// A column of a sweep's table.
struct QuantityColumn {
  std::string name;     ///< of the column
  std::string unit;     ///< of the quantity, "1" for a number
  std::string meaning;  ///< in half a sentence
};

/// Which cases a sweep consists of: case i takes the value choice(i)[k] of key k.
struct SweepPlan {
  std::vector<VariedKey> keys;               ///< that vary
  Combine combine = Combine::grid;           ///< how their values go together
  std::vector<std::string> sensitivities{};  ///< keys with respect to which a row has derivatives, too
  bool accuracy = false;                     ///< true if each case keeps an error, by settings of its own
  std::size_t joints = 0;                    ///< of the scene's bars in line
  std::vector<QuantityColumn> bars{};        ///< of bars side by side: all that a row tells

  /// Number of cases; that of a grid without keys is 1. A grid of more than 2^64 cases is not counted.
  std::size_t size() const;
  /// The columns of numbers: those of `bars`, if there are any. Else the quantities; those of each joint; where an
  /// error is to be kept, elements, tolerance, step and epsilon of the solution; then QUANTITY/KEY for each of
  /// `differentiated` and each key of `sensitivities`.
  std::vector<QuantityColumn> columns() const;
  std::vector<std::size_t> choice(std::size_t index) const;  ///< an index into the values of each key
  std::vector<Setting> settings(std::size_t index) const;    ///< the value of each key
};

/// Columns of a sweep's table, one number of each case; timings are apart.
enum class Quantity : std::size_t {
  unknowns,
  steps,
  rhs_evaluations,
  linear_solves,
  events,
  reached_time,
  max_penetration,
  energy_initial,
  energy_final,
  energy_dissipated,
  energy_work,
  energy_balance_error,
  u_left_final,
  u_left_min,
  u_left_max,
  u_right_final,
  u_right_min,
  u_right_max,
  closings_left,
  time_in_contact_left,
  impulse_left,
  max_reaction_left,
  closings_right,
  time_in_contact_right,
  impulse_right,
  max_reaction_right,
  closings_span,
  count
};

inline constexpr std::size_t quantities = static_cast<std::size_t>(Quantity::count);  ///< their number

inline constexpr std::size_t chosen_values = 4;  ///< of a row that is to keep an error
inline constexpr std::size_t joint_values = 4;   ///< of each joint: closings, time in contact, impulse, largest force

/// Name, unit and meaning of each quantity, in their order.
std::span<const QuantityColumn, quantities> quantity_columns();

/// Numbers of a row that have derivatives: impulses, the final energy, and the times at which a contact closes and
/// opens first.
inline constexpr std::array<std::string_view, 5> differentiated = {"impulse_left", "impulse_right", "energy_final",
                                                                   "first_closing", "first_opening"};

inline constexpr std::size_t longest_error = 512;  ///< bytes of an error in a row

/// Result of a case.
struct SweepRow {
  std::size_t index = 0;   ///< of the case in its plan
  bool completed = false;  ///< true if it reached the end of its time
  std::string error;       ///< empty when completed; cut off after longest_error bytes
  /// The numbers of SweepPlan::columns(); NaN where the case has no such value, and fewer where it has none behind
  /// them.
  std::vector<double> values = std::vector<double>(quantities, std::numeric_limits<double>::quiet_NaN());
  double seconds = 0.0;              ///< wall clock of the whole case
  double integration_seconds = 0.0;  ///< processor time of the method alone

  /// The value of a quantity.
  double& operator[](Quantity quantity) { return values[static_cast<std::size_t>(quantity)]; }
  /// The value of a quantity.
  double operator[](Quantity quantity) const { return values[static_cast<std::size_t>(quantity)]; }
  /// Value in SweepPlan::columns()[k].
  double column(std::size_t k) const {
    return k < values.size() ? values[k] : std::numeric_limits<double>::quiet_NaN();
  }
};

/// The order in which cases are handed out, one whenever a worker is free: the most expensive first, so that no long
/// one is left for the end. With exact costs c the last of m workers is done by
///
///     max(sum c / m, max c) (4/3 - 1/(3m))
///
/// [Graham 1969]; with wrong ones still by sum c / m + max c. Equal costs keep the order of the cases.
std::vector<std::size_t> dispatch_order(std::span<const double> costs);

/// Cases that run as bars of an ensemble, many side by side.
struct SweepEnsemble {
  std::vector<std::string> outputs;  ///< see EnsembleOutput; empty: each case is a run of its own
  std::optional<double> error;       ///< of the integration, see EnsembleStudy
  std::vector<double> common;        ///< values of the first case that can be run
  std::size_t batch = 1;             ///< cases that a worker takes at a time
};

/// A sweep as read: the scene, what holds for all cases, and what varies.
struct SweepFile {
  std::string title;              ///< free text
  std::string scene_source;       ///< path of the scene, for diagnostics
  std::string scene_text;         ///< the scene itself, so that every worker runs the same
  std::vector<Setting> settings;  ///< for all cases: [set], then those of the command line
  SweepPlan plan;                 ///< keys that vary, and their values
  SweepEnsemble ensemble{};       ///< [ensemble]
  Units units{};                  ///< those that the scene names

  /// Where a key of [set] or [vary] stands: a finding about its value in a case is one there.
  std::map<std::string, Diagnostic, std::less<>> places;

  /// All that decides about the results, as text: two sweeps with the same one have the same rows.
  std::string identity() const;
};

/// Sets what the plan owes to the scene and the settings: derivatives, and whether an error is to be kept.
void heed_scene(SweepFile& sweep);

/// Reads a sweep (TOML, see docs/sweep.md) and its scene. The values are checked one by one; whether they fit together
/// is known case by case, see plan_cases().
/// @throws SceneError with everything wrong in the sweep file in one go
SweepFile read_sweep(const std::filesystem::path& file, std::span<const std::string> overrides = {});

/// The same from text; `file` names it in diagnostics, and its scene is looked for beside it.
SweepFile parse_sweep(const std::string& text, const std::filesystem::path& file,
                      std::span<const std::string> overrides = {});

/// A case as the workers run it: the scene's text and all that is laid over it.
struct SweepCase {
  std::size_t index = 0;          ///< in the plan
  std::vector<Setting> settings;  ///< those for all cases, and the varied keys
};

/// 0 <= index < sweep.plan.size()
SweepCase case_of(const SweepFile& sweep, std::size_t index);

/// One of several parts of a sweep, which different machines run. Its cases are every `of`-th of a pack that is always
/// shuffled alike, so that all parts cost about the same, whatever the grid.
struct SweepPart {
  std::size_t number = 1;  ///< from 1
  std::size_t of = 1;      ///< number of parts

  std::string name() const;                                                          ///< "part-3-of-16"
  std::vector<bool> own(std::size_t cases) const;                                    ///< true for each case that it has
  std::size_t count(std::size_t cases) const { return (cases + of - number) / of; }  ///< of those
};

/// Reads every case of a part (on `threads`, or all cores) and estimates what it costs; 0 for one that is refused.
/// @throws SceneError when all of a whole sweep are refused, with all reasons
std::vector<double> plan_cases(const SweepFile& sweep, std::size_t threads = 0, const SweepPart& part = {});

/// Runs cases of a sweep by their indices; fewer where `interrupted` says yes.
std::vector<SweepRow> run_cases(const SweepFile& sweep, std::span<const std::size_t> indices,
                                const std::function<bool()>& interrupted = {});

/// Runs a case of the scene in `scene_text`. Whatever goes wrong with it is in the row: findings of the scene, the
/// integrator's words. `interrupted` is asked after each step: there is no row when it says yes.
std::optional<SweepRow> run_case(const std::string& scene_text, const SweepCase& one,
                                 const std::function<bool()>& interrupted = {});

}  // namespace viscobar
