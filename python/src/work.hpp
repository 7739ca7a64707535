#pragma once

#include <future>

#include "kept.hpp"

namespace viscobar::python {

/// Work of the library in another thread, without Python's lock, while this one hears signals: one that Python raises
/// an exception for stops it.
class Work {
 public:
  explicit Work(Faults& faults) : faults_(faults) {}
  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;

  bool stopped() const { return stopped_; }
  /// For what the work is given to ask.
  std::function<bool()> stop() const {
    return [this] { return stopped(); };
  }

  template <class Task>
  auto operator()(Task task) {
    std::future<decltype(task())> done;
    {
      const py::gil_scoped_release released;
      done = std::async(std::launch::async, std::move(task));
      Signals signals(faults_);
      while (done.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready)
        if (signals.heard()) stopped_ = true;
    }
    faults_.rethrow();
    return done.get();
  }

  /// Tells a Python function how many are done of how many; empty for None. What it raises stops the work.
  std::function<void(std::size_t, std::size_t)> telling(const py::object& progress) {
    if (progress.is_none()) return {};
    return [this, &progress](std::size_t done, std::size_t all) {
      if (stopped()) return;
      const Gil gil;
      try {
        progress(done, all);
      } catch (py::error_already_set& raised) {
        raised.restore();
        faults_.keep();
        stopped_ = true;
      }
    };
  }

 private:
  Faults& faults_;
  std::atomic<bool> stopped_{false};
};

}  // namespace viscobar::python
