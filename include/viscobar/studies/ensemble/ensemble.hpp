#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "viscobar/case/case.hpp"
#include "viscobar/studies/fit/fit.hpp"

namespace viscobar {

/// A quantity of every bar of an ensemble, as its text says it:
///
///     u_left@0.1        a column of ends.csv at 0, 0.1, 0.2, ..., and the end            K numbers
///     gauge:0.25@0.01   u, v, strain and stress at x = 0.25, at such times               K x 4
///     events:8          times of the first eight contact changes, NaN beyond the last    8
///     impulse_left      int R dt of an end, or impulse_joint:1 of a joint                1
///     peak_left         max |R| of an end, or peak_joint:1                               1
///     final             u and v of all nodes at the end                                  2 x (J+1)
///
/// Columns of joints.csv are traces, too: force:1@0.1.
struct EnsembleOutput {
  /// The rows above: columns of ends.csv and joints.csv, gauges, and so on.
  enum class Kind { trace, gauge, events, impulse, peak, final };
  std::string name;                ///< the text
  Kind kind = Kind::final;         ///< of the quantity
  TraceColumn column{};            ///< of a trace
  std::size_t account = 0;         ///< of an impulse or a peak: 0 of the left end, 1 of the right one, 1 + k of joint k
  double place = 0.0;              ///< x of a gauge, number of the joint of a trace
  std::size_t most = 0;            ///< contact changes that are told
  std::vector<double> times;       ///< of a trace or gauge
  std::vector<std::size_t> shape;  ///< of one bar's values; empty: a number

  std::size_t width() const;  ///< numbers of one bar
};

/// How a bar ended. The order is that of the codes.
enum class BarStatus {
  kept,      ///< at the end, within the error that was asked for, or by the scene's own method
  not_kept,  ///< at the end; its estimate is above the error that was asked for
  failed,    ///< the run stopped before the end
  faulty,    ///< its scene cannot be run
  not_run    ///< the ensemble was stopped before
};
std::string_view name(BarStatus status);     ///< in one word
std::string_view meaning(BarStatus status);  ///< in a sentence

/// Which way a bar was integrated.
enum class BarWay {
  none,   ///< not at all
  lanes,  ///< scheme (2.8), side by side with others
  alone   ///< by a run of its own
};
std::string_view name(BarWay way);  ///< in one word

/// Many bars: one scene, with numbers that differ.
struct EnsembleStudy {
  /// The case for a value of each key; throws where there is none. Called by several threads at once.
  std::function<Case(std::span<const double> values)> model;
  std::vector<std::string> keys;                ///< numbers of the scene, as "bar.viscosity"
  std::vector<std::span<const double>> values;  ///< of each key: one a bar, or one for all
  std::vector<std::string> outputs;             ///< see EnsembleOutput
  /// The error of integration in time that each bar may have, as a share of the largest value of each quantity. These
  /// are the displacements of ends and joints, with those of gauges and final states that are asked for, and the
  /// contact times and impulses that are. The error of the mesh comes on top. Absent: the scene's own method with its
  /// own settings, and no estimate.
  std::optional<double> error;
  /// Values of a bar that tells what all have in common: which way they go may depend on it. Empty: the first bar that
  /// can be run.
  std::vector<double> common;
  std::size_t most_messages = 100;                                  ///< that say why bars failed
  bool lanes = true;                                                ///< false: each bar by a run of its own
  std::size_t threads = 0;                                          ///< 0: one a core
  std::function<void(std::size_t done, std::size_t all)> progress;  ///< told now and then, by one thread at a time
  std::function<bool()> stop;  ///< asked by every thread, after each step of runs alone; may be empty
};

/// The bars in the order of the values. Nothing in it depends on the number of threads, nor on which other bars there
/// are.
struct EnsembleResult {
  std::size_t bars = 0;                 ///< N
  std::vector<EnsembleOutput> outputs;  ///< in the order of the study
  /// Values of each output: N x its width; NaN where a bar has none; fewer where it was stopped before the first bar.
  std::vector<std::vector<double>> values;
  std::vector<BarStatus> status;   ///< N
  std::vector<BarWay> ways;        ///< N
  std::vector<double> error;       ///< N: the estimate, as EnsembleStudy::error; NaN without one
  std::vector<std::size_t> steps;  ///< N: of the run that is told
  /// Why bars failed or are faulty, of the first of them.
  std::vector<std::pair<std::size_t, std::string>> messages;
};

/// Runs the bars: in lanes by (2.8) where the scene and the error allow it, else each by a run of its own.
/// @throws std::invalid_argument for a study that makes no sense
EnsembleResult ensemble(const EnsembleStudy& study);

/// True for keys that all bars share, for their outputs have the same shape.
bool is_shared_by_bars(std::string_view key);

/// The output that a text means, in a run of that case. @throws std::invalid_argument
EnsembleOutput ensemble_output(std::string_view text, const Case& run);

}  // namespace viscobar
