#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "sweep/sweep_queue.hpp"

namespace viscobar {

struct SweepWork {
  const std::string& scene_text;
  SweepQueue& queue;
  std::function<void(const SweepRow&)> take;  ///< each row, in the thread that called; may throw, which ends the sweep
  std::function<void()> tick;                 ///< a few times a second
  std::function<bool()> interrupted;          ///< true to give up; called from any thread
};

/// Runs the cases, each as soon as one of the threads is free. False when interrupted: the cases under way are given
/// up, all finished rows taken.
bool run_on_threads(const SweepWork& work, std::size_t threads);

}  // namespace viscobar
