#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "schemes/time_step.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// Reactions of scheme (2.8), and the account of the ends, joints and a span obstacle: from t_{n-1} to t_n, at a share
/// theta of it, u and
///
///     lambda = (1 - theta) lambda^{n-1} + theta lambda^n
///
/// are linear. lambda^0 has its part in what the start takes.
class StepReactions {
 public:
  /// Steps are dt from times.front() on; the last of them, `steps`, may end behind times.back(). The first three
  /// outlive it.
  StepReactions(const BarSystem& system, const TimeStep& step, std::span<const double> times, double dt,
                std::size_t steps);

  /// Enters the ends and joints at the start, and what an impact there takes at once. Massless nodes are where the
  /// balance of their rows puts them. To be called before TimeStep::advance().
  void begin(const State& start, RunAccount& account) const;
  /// Adds (t_{n-1}, t_n].
  void pass(std::size_t n, RunAccount& account) const;
  /// Contact k closes at t: lambda^n, which leads there, is of it, and what the start takes of an end's first one.
  void close(std::size_t k, double t, Event& event, RunAccount& account) const;

  double of_contact(std::size_t k, double theta) const {
    return (1.0 - theta) * step_.reaction_before()[k] + theta * step_.reaction()[k];
  }
  /// Sums over the contacts of an end that is not fixed, and of the span obstacle, in the direction of u.
  double of_end(bool right, double theta) const { return of(forces_[right], theta); }
  double of_span(double theta) const { return of(forces_[2], theta); }

 private:
  struct WatchedEnd {
    bool right;
    const double *u, *p;  // of its node; of a wall in a moving frame u alone
  };
  // The sum of the contacts from one up to another, but under a span obstacle of its own ones: N of a joint.
  struct Force {
    Where where;
    std::size_t first, last;
  };
  double time(std::size_t n) const { return begin_ + static_cast<double>(n) * dt_; }
  double sum(const Force& force, std::span<const double> values) const;
  double of(const Force& force, double theta) const {
    return (1.0 - theta) * sum(force, step_.reaction_before()) + theta * sum(force, step_.reaction());
  }
  ContactAccount& account_of(const Force& force, RunAccount& account) const;

  const BarSystem& system_;
  const TimeStep& step_;
  double begin_, end_, dt_;
  std::size_t steps_;
  std::vector<Force> forces_;        // of the ends, a span obstacle, and joints
  std::vector<WatchedEnd> watched_;  // that move
};

}  // namespace viscobar
