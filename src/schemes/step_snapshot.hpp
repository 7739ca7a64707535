#pragma once

#include <span>
#include <vector>

#include "schemes/step_reactions.hpp"
#include "schemes/time_step.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// Snapshots of scheme (2.8) between t_{n-1} and t_n, u^{n+1} being known: u, v = (u^{n+1} - u^{n-1}) / (2 dt) and
/// lambda, which are interpolated from the one time to the other.
class StepSnapshot {
 public:
  /// All but dt outlive it.
  StepSnapshot(const BarSystem& system, TimeStep& step, const StepReactions& reactions, double dt);

  /// At t = t_{n-1} + theta dt, without its energy; `first`: n is 1. Valid until the next call.
  Snapshot between(double t, double theta, bool first);
  /// At t_0, n being 1: the state of the start, massless nodes as the balance of their rows puts them.
  Snapshot at_start(double t, const State& start);

 private:
  Snapshot built(double t, double theta, bool first);
  double reaction(bool right, double t, double theta) const;

  const BarSystem& system_;
  TimeStep& step_;
  const StepReactions& reactions_;
  double dt_;
  std::vector<double> u_, v_, u_nodal_, v_nodal_;
  std::vector<double> a_nodal_;  // where an end is fixed
  std::vector<double> joint_forces_;
};

}  // namespace viscobar
