#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

struct NodalLoad;

/// M f(t) of a system, its forces on the ends and the frame's part included, with the buffers that its evaluation
/// needs: one per integration, so that a BarSystem can be shared. Exists only where the system is loaded().
class LoadVector {
 public:
  /// The system is loaded and outlives it. With a step the frame's part is by MovingFrame::lift(t, derivative, step).
  explicit LoadVector(const BarSystem& system, double step = 0.0);

  /// M f(t) over the unknowns (n entries), valid until the next call.
  /// @throws LoadError when the load is not finite at t.
  std::span<const double> at(double t);
  /// Its entry of one unknown, of the same value: the load is evaluated beside its node only. Not counted.
  /// @throws LoadError
  double at(double t, std::size_t unknown) const;
  /// (M f)_e of a fixed end, the frame's part left out. Not counted. @throws LoadError
  double at_held(double t, bool right) const;

  /// Time of the first break of the load after t, at any node, or `end` where there is none before: until then the load
  /// is smooth. From here on at() evaluates it at the nearest time that is 64 roundings of the time away from that
  /// break and from one at t, so that the load has its one-sided limits there. Two breaks closer than that are one.
  /// `end` is the same at every call.
  double enter(double t, double end);
  /// The jumps, after less before, of M f and of its rate where the load has a break at t; false: it has none there,
  /// but for those that a density in x and t has at each node. A rate is of a time `apart`, and 0 where the load breaks
  /// again within that. `end` as in enter(). @throws LoadError
  bool jump(double t, double end, double apart, std::span<double> force, std::span<double> rate);
  /// The time at which at(t) evaluates the load.
  double inside(double t) const { return std::clamp(t, first_, last_); }

  /// Where M f(t) = history(t) profile() but for end_forces(t) on the first and the last unknown, that vector, which
  /// is empty where there are those forces alone.
  std::optional<std::span<const double>> profile() const;
  /// Where (M f)_i is the same function of time times a number, that number.
  std::optional<double> factor(std::size_t unknown) const;
  double history(double t) const;                    ///< not counted @throws LoadError
  std::array<double, 2> end_forces(double t) const;  ///< of ends that are not fixed; not counted @throws LoadError

  bool steady() const { return steady_; }                   ///< the same at all times
  std::size_t evaluations() const { return evaluations_; }  ///< of the load's functions of time

 private:
  template <class Kind>
  const Kind* load_as() const;
  double next_break(double after, double until);
  bool breaks_within(double from, double to) const;
  void density_at_nodes(const SpaceTimeFunction& density, double t, std::span<double> values) const;
  void find_distributed(double t);
  template <class Add>
  void add_moments(double t, std::size_t first, std::size_t last, Add&& add) const;  // of elements [first, last)
  double distributed(double t, std::size_t node) const;
  double separable_history(double t) const;
  void add_inputs(double t);
  Lift lift(double t, int derivative) const;

  const BarSystem& system_;  // outlives this
  const NodalLoad* load_;    // of the system; null: its frame alone
  double step_;
  bool steady_;
  std::vector<double> nodes_, nodal_, weighted_;  // the first two of a load in x and t
  std::vector<LoadVector> difference_;            // loads of the two systems of Difference, or none
  std::optional<double> time_;
  mutable std::optional<double> history_time_;  // of history_, which many nodes ask for at one time
  mutable double history_ = 0.0;
  std::vector<NextBreak> breaks_;
  NextBreakAt breaks_at_;
  std::vector<double> next_;  // breaks of the whole load, and of it at each node, where that has its own
  double first_ = -std::numeric_limits<double>::infinity(), last_ = std::numeric_limits<double>::infinity();
  std::size_t evaluations_ = 0;
};

}  // namespace viscobar
