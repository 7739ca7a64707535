#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "studies/limit/verdict.hpp"
#include "viscobar/case/end_traces.hpp"
#include "viscobar/studies/limit/limit.hpp"

namespace viscobar::limit {

/// From one step of the scheme to the next: a third of a decade. A half would put a contact that closes in the second
/// half of a step at the same time again.
extern const double scheme_refinement;

/// Cost of a step of the case in seconds, on the machine of the table of methods: so the runs of a study depend on the
/// clock only at the end of its budget.
double step_seconds(const Case& run);

/// The processor seconds that a study may spend, over all its threads, and who watches it.
class Purse {
 public:
  explicit Purse(const LimitStudy& study) : study_(study) {}

  void spend(double seconds) { spent_ = spent_ + seconds; }
  double spent() const { return spent_; }
  double left() const { return study_.budget - spent_; }
  bool interrupted() const { return study_.interrupted && study_.interrupted(); }
  /// True if runs are to stop. A budget of 0 lets the runs that were asked for go on.
  bool empty() const { return interrupted() || (study_.budget > 0.0 && spent_ + kept_ > study_.budget); }
  /// From here on runs are to stop that much earlier.
  void keep(double seconds) { kept_ = seconds; }
  /// True if a run may begin that takes so long; of those that were asked for with a budget of 0, too.
  bool allows(double seconds, bool asked) const {
    return !interrupted() && (study_.budget > 0.0 ? spent_ + kept_ + seconds <= study_.budget : asked);
  }
  void expect(std::size_t runs) {
    const std::lock_guard lock(mutex_);
    all_ += runs;
  }
  void done() {
    const std::lock_guard lock(mutex_);
    ++done_;
    if (study_.progress) study_.progress(done_, all_);
  }
  void tell(const LimitRow& row) {
    const std::lock_guard lock(mutex_);
    if (study_.row) study_.row(row);
  }

 private:
  const LimitStudy& study_;
  std::atomic<double> spent_ = 0.0, kept_ = 0.0;
  std::mutex mutex_;
  std::size_t done_ = 0, all_ = 0;
};

/// Error of a limit `run`, by the same run with a hundredfold tolerance, `rough`.
double limit_error(const EndTraces& run, const EndTraces& rough);

/// A run of a study, its traces or why there are none.
struct Run {
  Case run;
  EndTraces traces = {};
  std::optional<IntegrationError> error = {};
  double seconds = 0.0;
  bool complete = false;

  /// Stops where the purse is empty; true if it came to its end. Errors of the integration are kept, and no run is made
  /// after one.
  bool trace(std::span<const double> times, Purse& purse);
  /// The same of one that nobody expected.
  bool trace_one_more(std::span<const double> times, Purse& purse) {
    purse.expect(1);
    trace(times, purse);
    purse.done();
    return complete;
  }
};

/// Limit of a sequence by the method `rigid`: a run, and the same with a hundredfold tolerance, which tells its error.
struct KnownLimit {
  Run run, rough;

  bool known() const { return run.complete && rough.complete; }
  double error() const { return limit_error(run.traces, rough.traces); }
};

/// The runs of one mesh. Those that a verdict asks for come later, so that references to the others must stay valid.
struct MeshRuns {
  std::deque<Run> scheme;     // dt decreasing
  std::deque<Run> penalised;  // epsilon decreasing
  std::optional<KnownLimit> of_scheme;
  std::optional<KnownLimit> of_penalty;  // where that is another motion than the scheme's
  bool one_limit = false;                // by theory: both are of_scheme
  bool magnifies = false;                // small differences, so that distances over the whole run have no order
  std::vector<double> times;
  std::vector<Run> other_law;
  std::optional<Run> without_obstacles;
  Judgement judgement = {};
  std::optional<double> lacking_seconds;  // of the next run, which the budget did not allow

  const KnownLimit* scheme_limit() const { return of_scheme && of_scheme->known() ? &*of_scheme : nullptr; }
  const KnownLimit* own_limit() const {
    if (one_limit) return scheme_limit();
    return of_penalty && of_penalty->known() ? &*of_penalty : nullptr;
  }
  double step() const { return *scheme.back().run.step; }
};

/// The study on meshes of which those of a chain refine all bars by one factor, where they are multiples of the
/// coarsest.
LimitStudy by_one_factor(LimitStudy study);

/// Beginning of traces on these times, up to `until`.
EndTraces beginning_of(const EndTraces& traces, std::span<const double> times, double until);

/// Cases of one mesh: penalised, of the scheme, and of `rigid` with a restitution.
/// @throws std::invalid_argument where they are not sound
Case penalised_case(const LimitStudy& study, std::size_t elements, double epsilon);
Case scheme_case(const LimitStudy& study, std::size_t elements, double step);

/// Carries out the runs that were asked for: the limits first, whose contact changes tell the times, then the scheme at
/// `step` and two larger ones and the penalised runs, in parallel. Runs that the budget does not allow are left out.
/// @throws IntegrationError when the scheme, the rigid limit of massless nodes or every penalised run failed
MeshRuns runs_of(const LimitStudy& study, std::size_t elements, double step, Purse& purse);

/// Runs the limits again at a tolerance a hundredth of theirs; whether that changed anything.
bool tighten(MeshRuns& mesh, Purse& purse);

/// Error of the time integration in a difference of runs.
double tolerance_error(const MeshRuns& mesh);
/// zeta ~ 1 of an end node on its spring 1 / epsilon; under a span the spring is h / epsilon. Absent without viscosity,
/// and of bars in line, whose joints have their own.
std::optional<double> boundary_of(const Case& run);

/// Judges the mesh, and runs more until the verdict is known, nothing more can be learnt, or the budget does not allow
/// the next run: decide.cpp.
void decide(MeshRuns& mesh, const LimitStudy& study, Purse& purse);
/// So small a step that the distances to the scheme show the penalty's order over the epsilons asked for, or as many of
/// them as a small part of the budget buys. A finer run may tell its own error so much better that the rest is cheap.
void refine_scheme(MeshRuns& mesh, const LimitStudy& study, Purse& purse);

/// The row of a penalised run, its distance to the scheme apart.
LimitRow row_of(const MeshRuns& mesh, const Run& penalised);

/// Absent for fewer than three meshes, where a limit is not known, or the budget is spent.
std::optional<OwnMotion> own_motion_of(const LimitStudy& study, const LimitResult& result,
                                       std::span<const MeshRuns> meshes, Purse& purse);

}  // namespace viscobar::limit
