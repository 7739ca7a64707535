#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <utility>
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
  /// Contact k closes at t: lambda^n, which leads there, is of it, and what the start takes of a place's first one.
  void close(std::size_t k, double t, Event& event, RunAccount& account) const;

  double of_contact(std::size_t k, double theta) const {
    return (1.0 - theta) * step_.reaction_before()[k] + theta * step_.reaction()[k];
  }
  /// Sums over the contacts of an end that is not fixed, and of the span obstacle, in the direction of u.
  double of_end(bool right, double theta) const;
  double of_span(double theta) const {
    return (1.0 - theta) * span_sum(step_.reaction_before()) + theta * span_sum(step_.reaction());
  }

 private:
  struct WatchedEnd {
    bool right;
    const double *u, *p;  // of its node; of a wall in a moving frame u alone
  };
  double time(std::size_t n) const { return begin_ + static_cast<double>(n) * dt_; }
  double sign(std::size_t k) const { return step_.contacts()[k].sign; }
  double span_sum(std::span<const double> values) const;
  template <class Use>
  void each_contact_at(bool right, Use&& use) const {
    for (std::size_t k = at_end_[right].first; k < at_end_[right].second; ++k) use(k);
  }

  const BarSystem& system_;
  const TimeStep& step_;
  double begin_, end_, dt_;
  std::size_t steps_;
  bool spanned_;                                                 // by an obstacle
  std::array<std::pair<std::size_t, std::size_t>, 2> at_end_{};  // contacts from one up to another
  std::vector<WatchedEnd> watched_;                              // that move
};

}  // namespace viscobar
