#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <span>
#include <vector>

#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

/// Hands out cases of a sweep, the dearest first.
class SweepQueue {
 public:
  /// `costs` of all cases; `to_run` says which of them; empty: all.
  SweepQueue(const SweepFile& sweep, std::span<const double> costs, const std::vector<bool>& to_run = {});

  /// Indices of those to run now; empty: none is left.
  std::vector<std::size_t> take();

  std::size_t size() const { return left_.size(); }
  double seconds() const;

 private:
  std::size_t batch_;
  std::span<const double> costs_;
  std::deque<std::size_t> left_;
};

struct SweepWork {
  const SweepFile& sweep;
  SweepQueue& queue;
  std::function<void(const SweepRow&)> take;  ///< each row, in the thread that called; may throw, which ends the sweep
  std::function<void()> tick;                 ///< a few times a second
  std::function<bool()> interrupted;          ///< true to give up; called from any thread
};

/// Runs the cases, each as soon as one of the threads is free. False when interrupted: the cases under way are given
/// up, all finished rows taken.
bool run_on_threads(const SweepWork& work, std::size_t threads);

}  // namespace viscobar
