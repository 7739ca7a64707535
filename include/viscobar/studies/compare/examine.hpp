#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "viscobar/studies/compare/compare.hpp"
#include "viscobar/studies/exact/exact_solutions.hpp"

namespace viscobar {

/// Largest allowed differences of a scheme to its references, in the norms of Difference. An absent bound is not
/// checked.
struct Bounds {
  std::optional<double> displacement_l2 = std::nullopt;  ///< max over time of the L2 norm
  std::optional<double> displacement_h1 = std::nullopt;  ///< max over time of the H1 seminorm
  std::optional<double> velocity_l2 = std::nullopt;      ///< max over time of the L2 norm
  std::optional<double> end_trace = std::nullopt;        ///< max over time and ends of |u - u'|
  std::optional<double> event_shift = std::nullopt;      ///< then every contact change must also have its partner
  std::optional<double> impulse = std::nullopt;          ///< of each contact that both have, at the ends
};

/// A scene on which a scheme is examined.
struct Trial {
  std::string name;  ///< in tables and messages
  Case run;          ///< given to the scheme and, by their methods, to the references
  std::optional<exact::Solution> solution = std::nullopt;  ///< of run.scene, where it is known
  std::vector<MethodName> methods = {};  ///< references; empty: fitting_methods(run) where no solution is known
  Bounds bounds = {};                    ///< of the difference to every reference
};

/// The result on one scene. The scheme is the last run of `check`; the exact solution, where known, the first.
struct TrialResult {
  std::string name;                   ///< of the trial
  Comparison check;                   ///< the scheme and its references
  std::optional<exact::Error> error;  ///< to the exact solution; absent for a scheme that gives its ends only
  std::vector<Finding> findings;      ///< bounds exceeded (key: reference and quantity) and runs that failed

  bool passed() const { return findings.empty(); }               ///< true if nothing was found
  const MethodRun& scheme() const { return check.runs.back(); }  ///< the run of the scheme
  /// The difference of the scheme to a reference; absent where one of the two failed.
  const Difference* to(std::size_t reference) const;
};

/// Runs a scheme of your own on each trial, compares it with the references and checks the trial's bounds.
///
///     Trial trial{"throw", run, {}, {MethodName::cvode, MethodName::ida}, {.end_trace = 1e-5}};
///     for (const TrialResult& result : examine("mine", my_scheme, {&trial, 1})) std::cout << trial_text(result);
///
/// A scheme that throws, or whose recording does not fit the case, is a finding, not an exception.
/// @throws std::invalid_argument when a requested reference does not fit the scene
std::vector<TrialResult> examine(const std::string& label, const Solver& scheme, std::span<const Trial> trials,
                                 std::size_t threads = 0);

}  // namespace viscobar
