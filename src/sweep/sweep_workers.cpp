#include "sweep/sweep_workers.hpp"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "viscobar/record/record_run.hpp"

namespace viscobar {

namespace {

/// Finished rows on their way from the workers to the thread that writes them.
class Inbox {
 public:
  void add(SweepRow row) {
    const std::lock_guard lock(mutex_);
    rows_.push_back(std::move(row));
  }
  void worker_left() {
    const std::lock_guard lock(mutex_);
    ++left_;
    changed_.notify_one();
  }
  /// What has come within a moment; the second is how many workers have left. Rows wait for it: to wake the thread for
  /// each would take longer than to write it.
  std::pair<std::vector<SweepRow>, std::size_t> fetch() {
    std::unique_lock lock(mutex_);
    const std::size_t known = left_;
    changed_.wait_for(lock, std::chrono::milliseconds(20), [&] { return left_ != known; });
    return {std::exchange(rows_, {}), left_};
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<SweepRow> rows_;
  std::size_t left_ = 0;
};

}  // namespace

bool run_on_threads(const SweepWork& work, std::size_t threads) {
  std::atomic<std::size_t> next{0};
  std::atomic<bool> stop{false};
  std::exception_ptr error;
  Inbox inbox;
  const auto stopped = [&] { return stop.load(std::memory_order_relaxed) || work.interrupted(); };
  const auto serve = [&] {
    try {
      for (std::size_t i = next++; i < work.order.size() && !stopped(); i = next++)
        if (const auto row = run_case(work.sweep.scene_text, case_of(work.sweep, work.order[i]), stopped))
          inbox.add(*row);
    } catch (...) {
      if (!stop.exchange(true)) error = std::current_exception();
    }
    inbox.worker_left();
  };
  std::exception_ptr own_error;
  {
    std::vector<std::jthread> pool;
    for (std::size_t k = 0; k < threads; ++k) pool.emplace_back(serve);
    try {
      for (std::size_t left = 0; left < threads;) {
        const auto [rows, now_left] = inbox.fetch();
        for (const SweepRow& row : rows) work.take(row);
        work.tick();
        left = now_left;
      }
    } catch (...) {
      own_error = std::current_exception();
      stop = true;
    }
  }
  if (own_error) std::rethrow_exception(own_error);
  if (error) std::rethrow_exception(error);
  return !work.interrupted();
}

}  // namespace viscobar
