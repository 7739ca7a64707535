#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "studies/accuracy/sample.hpp"
#include "studies/accuracy/space_error.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"

namespace viscobar::accuracy {

inline constexpr double time_share = 0.1;  ///< of a request, for the integration

/// The study was asked to stop.
struct Stopped {};

/// The runs for the estimate took longer than the study allows.
struct TooLong {};

/// What runs differ in: J, the relative tolerance or the time step, and epsilon (0: nothing is penalised).
struct Setting {
  std::size_t elements = 0;
  double fineness = 0.0;
  double epsilon = 0.0;
  auto operator<=>(const Setting&) const = default;
};

/// Chooses settings, makes the runs for the estimate, and judges the solution, which somebody else runs:
///
///     Plan plan(study);
///     do sample = run(plan.next()), estimate = plan.judge(sample); while (plan.again());
class Plan {
 public:
  /// @throws std::invalid_argument where the goal has no limit
  explicit Plan(const AccuracyStudy& study);

  /// The case to run now, its settings chosen by runs on coarser meshes. @throws Stopped, IntegrationError
  Case next();
  /// The estimate for the case of next(). @throws Stopped, IntegrationError
  ErrorEstimate judge(Sample solution);
  /// Whether next() has a better one.
  bool again() const { return again_; }

 private:
  /// The error of a setting other than the mesh, from runs that differ in it, and the power of it that they follow.
  struct Part {
    double error = 0.0, order = 1.0;
  };

  Case with(const Setting& setting) const;
  void run(std::vector<Setting> settings);
  const Sample& sample(const Setting& setting) const { return samples_.at(setting); }
  Grain grain() const;
  double apart(const Setting& coarse, const Setting& fine, bool* same = nullptr) const;
  std::vector<Setting> rungs(std::size_t finest) const;
  std::vector<MeshStep> ladder(std::size_t finest, Goal of, bool* same) const;
  /// The order in h that a goal can have: no more than the field shows, for two errors of other orders and signs may
  /// cancel in a number or at an end, and not everywhere in the bar.
  double theory_of_goal(std::size_t finest) const;
  std::vector<std::size_t> coarser(std::size_t elements) const;
  Part time_part(const Setting& finest) const;
  Part penalty_part(const Setting& finest) const;
  Part time_error(std::size_t elements);
  Part penalty_error(std::size_t elements);
  bool refine_time(const Part& part);
  bool refine_penalty(const Part& part);
  void settle(std::size_t elements);
  void pilot();
  bool affordable(std::size_t elements) const;
  std::size_t wanted_elements(const SpaceError& known, std::size_t at) const;
  void climb();
  void climb_from(std::size_t& known);
  double magnification() const;
  ErrorEstimate judge_exact(const Sample& solution);
  void explain(ErrorEstimate& estimate, const Case& run) const;
  std::string kept_by_scene(const ErrorEstimate& estimate, double order, double penalty_order) const;
  void tell(const std::string& what) const;

  AccuracyStudy study_;
  Case base_;
  double theory_ = 4.0;  // order in h
  bool stepping_ = false, exact_time_ = false, waves_ = false, penalised_ = false;
  double ratio_ = 10.0, time_order_ = 0.0;  // of two settings in time; least order
  Setting chosen_;
  std::map<Setting, Sample> samples_;
  std::vector<ErrorEstimate::Run> runs_;
  std::optional<double> requested_;
  double reachable_ = 0.0;  // the request, or more where settings that the scene fixes do not let it be kept
  double largest_ = 0.0, seconds_ = 0.0;
  bool bounded_ = false;  // whether runs are ended where the study allows no more time
  std::string doubt_;
  bool piloted_ = false, again_ = false;
  int tries_ = 0;
};

}  // namespace viscobar::accuracy
