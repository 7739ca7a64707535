#pragma once

#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
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

/// Counts runs for whoever watches.
class Progress {
 public:
  explicit Progress(const LimitStudy& study) : tell_(study.progress) {}
  void expect(std::size_t runs) {
    const std::lock_guard lock(mutex_);
    all_ += runs;
  }
  void done() {
    const std::lock_guard lock(mutex_);
    ++done_;
    if (tell_) tell_(done_, all_);
  }

 private:
  const std::function<void(std::size_t, std::size_t)>& tell_;
  std::mutex mutex_;
  std::size_t done_ = 0, all_ = 0;
};

/// A run of a study, its traces or why there are none.
struct Run {
  Case run;
  EndTraces traces = {};
  std::exception_ptr error = {};
  double seconds = 0.0;

  /// @throws IntegrationError
  void trace(std::span<const double> times);
  /// Does what may fail as a run may; whether it succeeds.
  bool attempt(const auto& work) {
    try {
      work();
    } catch (const IntegrationError&) {
      error = std::current_exception();
    }
    return !error;
  }
};

/// The rigid limit on massless contact nodes decides about the limit; on others it stands beside it, and may fail, as
/// bounces without end do.
bool massless(const Run& rigid);

/// The runs of one mesh. Those that a verdict asks for come later, so that references to the others must stay valid.
struct MeshRuns {
  std::deque<Run> scheme;  // dt decreasing
  std::optional<Run> rigid;
  std::vector<Run> penalised;  // epsilon decreasing
  std::vector<double> times;
  std::vector<Run> other_law;
  std::optional<Run> without_obstacles;
  Judgement judgement = {};

  template <class Use>
  void each(Use&& use) {
    for (Run& run : scheme) use(run);
    if (rigid) use(*rigid);
    for (Run& run : penalised) use(run);
  }
  double step() const { return *scheme.back().run.step; }
};

/// Of the scheme, on one mesh. @throws std::invalid_argument where it is not sound
Case scheme_case(const LimitStudy& study, std::size_t elements, double step);

/// That are to be run in any case, the scheme at `step` and two larger ones.
MeshRuns runs_of(const LimitStudy& study, std::size_t elements, double step);

/// All runs of all meshes, independent, in two passes: where contacts change, then the traces on times that show it.
/// @throws IntegrationError when the scheme, the rigid limit of massless nodes or every penalised run of a mesh failed
void carry_out(std::vector<MeshRuns>& meshes, const LimitStudy& study, Progress& progress);

/// Powers of epsilon in u_epsilon - U at each row of a mesh, by derivatives of its runs (see LocalPower), U the traces
/// `limit`. Both norms are those of the common times, the integral by the trapezoidal rule, and so the formulas hold of
/// them exactly, but for one thing: the time of the largest difference hops from one to the next as epsilon falls, and
/// the power with it, by no more than it differs between neighbouring times. Differences below `floor`, the error of
/// the time integration in them, have none.
void add_local_powers(const MeshRuns& mesh, const EndTraces& limit, double floor, std::span<LimitRow> rows);

}  // namespace viscobar::limit
