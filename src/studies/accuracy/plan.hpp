#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "studies/accuracy/data_error.hpp"
#include "studies/accuracy/runs.hpp"
#include "studies/accuracy/space_error.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"

namespace viscobar::accuracy {

/// The error of a setting other than the mesh, from runs that differ in it, and the power of it that they follow.
struct Part {
  double error = 0.0, order = 1.0;
};
inline constexpr double excess = 1.2;  ///< of its share, with which a setting stays

/// Chooses settings, makes the runs for the estimate, and judges the solution:
///
///     Plan plan(study);
///     do run(plan.next()), estimate = plan.judge(); while (plan.again());
///
/// All runs are looked at at the same times, which are not the output times: see times_of_errors().
class Plan {
 public:
  /// @throws std::invalid_argument where the goal has no limit
  explicit Plan(const AccuracyStudy& study);
  /// Estimates the error of a case as it is: nothing is chosen. The runs may take so many seconds together.
  Plan(Case as_it_is, double most_seconds, std::function<bool()> stop);

  /// The case to run now, its settings chosen by runs on coarser meshes. @throws StudyStopped, IntegrationError
  Case next();
  /// At which a solution is to be looked at by who runs it anyway.
  const std::vector<double>& times() const { return runs_.times(); }
  /// The estimate for the case of next(), which is run, in memory, where nobody has a sample of it.
  /// @throws StudyStopped, TooLong, IntegrationError
  ErrorEstimate judge(std::optional<Sample> solution = {});
  /// True if next() has a better one.
  bool again() const { return again_; }

 private:
  /// Share of the requested error for each part.
  struct Shares {
    double space = 0.65, penalty = 0.1, time = 0.25;
  };
  static constexpr std::size_t least_elements = 16;  ///< of a solution: fewer are no faster, on any unit
  static constexpr std::size_t most_rungs = 4;       ///< meshes that an error is seen by
  static constexpr double nudge_share = 1e-9;        ///< of the natural velocity

  Case with(const Setting& setting) const;
  Setting at(std::size_t elements) const { return {elements, chosen_.fineness, chosen_.epsilon}; }
  Resolution resolution() const;
  // Distance and alignment of runs that were made. Each distance of fields is computed once.
  double apart(const Setting& coarse, const Setting& fine) const;
  double aligned(const Setting& first, const Setting& second, const Setting& third) const;
  // Elements of the bar that has the fewest; a mesh as coarse as that, or coarser than the chosen one by less, on which
  // each has three.
  std::size_t fewest_at(std::size_t elements) const;
  std::size_t with_enough(std::size_t elements) const;
  // The least multiple of the unit by a power of two that is not less.
  std::size_t doubled_unit(std::size_t elements) const { return unit_ * std::bit_ceil((elements + unit_ - 1) / unit_); }

  // Where a neighbour ended: start.cpp.
  void begin_at(const AccuracyStart& start);
  void leave_fine_settings();

  // The settings in time and penalty: parts.cpp.
  Part part_of(const Setting& finest, double Setting::*number, double least, double most) const;
  std::vector<Setting> time_pair(std::size_t elements) const;
  std::vector<Setting> penalty_pair(std::size_t elements) const;
  Part time_error(std::size_t elements);
  Part penalty_error(std::size_t elements);
  double penetration(const Setting& of);
  bool refine_time(const Part& part);
  bool refine_penalty(const Part& part);
  void settle(std::size_t elements);

  // The mesh: climb.cpp.
  std::optional<Setting> known_rung(std::size_t elements, std::size_t steps) const;
  std::vector<Setting> rungs(std::size_t finest, std::size_t least) const;
  std::vector<MeshStep> ladder(const std::vector<Setting>& steps, bool* same);
  std::vector<MeshStep> made_ladder(std::size_t finest, std::size_t least, bool* same);
  SpaceError seen_error(const std::vector<MeshStep>& steps) const;
  std::size_t multiple(std::size_t elements) const;
  bool affordable(std::size_t elements) const;
  std::size_t wanted_elements(const SpaceError& known, std::size_t from) const;
  void pilot();
  void climb();
  void climb_from(std::size_t& best);

  // The verdict: judge.cpp.
  // The mesh on which settings in time and penalty are compared, and how much coarser it may be.
  std::size_t coarser() const { return loses_rebound_ ? 1 : penalised_ || stepping_ ? 4 : 8; }
  std::size_t coarse() const {
    constexpr std::size_t few = 8;  // on which contacts are still like those of finer meshes
    return with_enough(std::max(chosen_.elements / coarser(),
                                study_.request.given.elements ? std::min(chosen_.elements, few) : timed_elements_));
  }
  std::vector<Setting> wanted_by_judge() const;
  double moved_by_nudge() const;
  double magnification();
  ErrorEstimate begun_estimate();
  ErrorEstimate judge_exact();
  void explain(ErrorEstimate& estimate, const Case& run) const;
  std::optional<Setting> without_rebound() const;
  std::string count_what_grows(SpaceError& space, const std::vector<MeshStep>& steps, const Part& time);
  std::string kept_by_scene(const ErrorEstimate& estimate, double order, double penalty_order) const;
  void tell_runs(ErrorEstimate& estimate) const;

  AccuracyStudy study_;
  AccuracyRequest::Given by_user_;  // of a run that is resumed: not all that is held
  Case base_;
  DataError data_error_;
  std::size_t unit_ = 1;                         // meshes have multiples of it, so that data break at nodes
  bool doubled_ = false;                         // each mesh has the nodes of the coarser ones
  bool apart_ = false;                           // it has few of them
  double theory_ = 4.0;                          // order in h
  std::size_t pilot_elements_ = least_elements;  // of the finest mesh that the search begins with
  std::size_t timed_elements_ = least_elements;  // of that on which it compares settings in time and penalty
  bool begun_ = false;                           // with settings of a neighbour
  bool as_it_is_ = false, stepping_ = false, exact_time_ = false, waves_ = false, penalised_ = false;
  bool loses_rebound_ = false;  // nodes of a viscous bar that a span obstacle throws back: docs/model.md
  Shares shares_;
  double ratio_ = 10.0, time_order_ = 0.0;  // of two settings in time; least order
  double nudge_ = 0.0;                      // of the initial velocity
  Setting guess_, chosen_;                  // before any run, and now
  std::vector<Setting> rungs_;              // of the solution
  std::optional<double> requested_;
  mutable std::map<std::array<Setting, 2>, double> differences_;
  double reachable_ = 0.0;  // the request, or more where settings that the scene fixes do not let it be kept
  double largest_ = 0.0, closing_speed_ = 0.0, end_speed_ = 0.0;  // of the finest run of a ladder: of any node, of ends
  double looser_ = 1.0, pilot_error_ = 0.0;  // of the pilots, beside the chosen tolerance, and what that costs
  std::string doubt_;
  bool piloted_ = false, again_ = false;
  int tries_ = 0;
  Runs runs_;
};

}  // namespace viscobar::accuracy
