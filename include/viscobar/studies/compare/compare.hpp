#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "viscobar/case/case.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/studies/compare/difference.hpp"

namespace viscobar {

/// The methods that one scene is to be run by, the reference first.
struct MethodChoice {
  /// A method that does not fit.
  struct Skipped {
    MethodName method;   ///< which
    std::string reason;  ///< in a sentence
  };
  std::vector<Case> cases;               ///< one for each method
  std::vector<Skipped> skipped;          ///< methods that do not fit the scene
  std::vector<MethodName> default_step;  ///< schemes whose step was chosen, the scene having none
  std::vector<std::string> remarks;      ///< to be read before the differences
};

/// Every method that fits the scene, characteristics first, else exponential, which is left out on a mesh of more than
/// 100 elements.
MethodChoice fitting_methods(const Case& scene);

/// These methods in this order. @throws std::invalid_argument when one does not fit the scene, or comes twice
MethodChoice chosen_methods(const Case& scene, std::span<const MethodName> methods);

/// One entry of a cross-check: a built-in method, or a scheme of your own.
struct Contender {
  std::string label;   ///< its name in tables
  Case run;            ///< scene and settings of its run
  Solver solver = {};  ///< empty: the case's own method
};

/// One run of a cross-check.
struct MethodRun {
  std::string label;                    ///< its name in tables
  bool built_in = true;                 ///< run by the case's own method
  Setup setup;                          ///< that it ran on, which may differ from the scene's
  std::optional<Recording> recording;   ///< absent when the run failed
  std::vector<ContactPeriod> contacts;  ///< bounces within a hundredth of the run merged
  std::string error;                    ///< why it failed; empty when it did not
  std::size_t index = 0;                ///< among the runs of its comparison
};

/// One scene by several methods, and how far every two of them are apart.
struct Comparison {
  /// How far two runs are apart.
  struct Pair {
    std::size_t first = 0;  ///< index of one run
    std::size_t other = 0;  ///< index of the other
    Difference difference;  ///< of the first to the other
  };
  std::vector<MethodRun> runs;           ///< in the order of the contenders
  std::optional<std::size_t> reference;  ///< the first run that did not fail
  std::vector<Pair> pairs;               ///< every two runs that did not fail

  /// The difference of the reference to a run; absent for the reference itself and for a run that failed.
  const Difference* to_reference(std::size_t run) const;
  bool completed() const;  ///< true if no run failed
};

/// Runs the contenders, which share mesh and output times, on all cores (or on `threads`; solvers are then called at
/// the same time). A run that fails, or a recording that does not fit its case, is reported and leaves the others
/// standing.
Comparison compare(std::span<const Contender> contenders, std::size_t threads = 0);
/// The same of runs that are there, of one mesh and the same output times; their contacts are found here.
Comparison compare(std::vector<MethodRun> runs);
/// The same for built-in methods.
Comparison compare(std::span<const Case> cases, std::size_t threads = 0);

}  // namespace viscobar
