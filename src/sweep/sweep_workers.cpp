#include "sweep/sweep_workers.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <iterator>
#include <mutex>
#include <numeric>
#include <utility>

#include "studies/parallel.hpp"

namespace viscobar {

SweepQueue::SweepQueue(const SweepFile& sweep, std::span<const double> costs, const std::vector<bool>& to_run)
    : batch_(sweep.ensemble.batch), costs_(costs) {
  for (const std::size_t i : dispatch_order(costs))
    if (to_run.empty() || to_run[i]) left_.push_back(i);
}

std::vector<std::size_t> SweepQueue::take() {
  const auto end = left_.begin() + static_cast<std::ptrdiff_t>(std::min(batch_, left_.size()));
  const std::vector<std::size_t> indices(left_.begin(), end);
  left_.erase(left_.begin(), end);
  return indices;
}

double SweepQueue::seconds() const {
  return std::accumulate(left_.begin(), left_.end(), 0.0, [&](double sum, std::size_t i) { return sum + costs_[i]; });
}

bool run_on_threads(const SweepWork& work, std::size_t threads) {
  std::atomic<bool> stop{false};
  const auto stopped = [&] { return stop.load(std::memory_order_relaxed) || work.interrupted(); };
  constexpr std::chrono::milliseconds moment(20);
  std::mutex mutex;
  std::vector<SweepRow> finished;  // on their way to this thread, which writes them
  const auto run = [&](std::size_t) {
    try {
      while (!stopped()) {
        std::unique_lock lock(mutex);
        const std::vector<std::size_t> indices = work.queue.take();
        if (indices.empty()) return;
        lock.unlock();
        std::vector<SweepRow> rows = run_cases(work.sweep, indices, stopped);
        lock.lock();
        std::ranges::move(rows, std::back_inserter(finished));
        if (rows.size() < indices.size()) return;
      }
    } catch (...) {
      stop = true;
      throw;
    }
  };
  const auto take = [&] {
    std::unique_lock lock(mutex);
    const std::vector<SweepRow> rows = std::exchange(finished, {});
    lock.unlock();
    for (const SweepRow& row : rows) work.take(row);
    work.tick();
  };
  auto done = std::async(std::launch::async, [&] { parallel_for(threads, run, threads); });
  try {
    // Rows wait for this moment: to wake the thread for each would take longer than to write it.
    while (done.wait_for(moment) != std::future_status::ready) take();
    take();
  } catch (...) {
    stop = true;
    throw;  // when the cases under way have stopped
  }
  done.get();
  return !work.interrupted();
}

}  // namespace viscobar
