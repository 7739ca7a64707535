#include "sweep/sweep_workers.hpp"

#include <atomic>
#include <chrono>
#include <future>
#include <mutex>
#include <numeric>
#include <utility>

#include "studies/parallel.hpp"

namespace viscobar {

SweepQueue::SweepQueue(const SweepFile& sweep, std::span<const double> costs, const std::vector<bool>& to_run)
    : sweep_(sweep), costs_(costs) {
  for (const std::size_t i : dispatch_order(costs))
    if (to_run.empty() || to_run[i]) left_.push_back(i);
}

std::optional<SweepCase> SweepQueue::take() {
  if (left_.empty()) return std::nullopt;
  const std::size_t next = left_.front();
  left_.pop_front();
  return case_of(sweep_, next);
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
        const auto one = work.queue.take();
        if (!one) return;
        lock.unlock();
        auto row = run_case(work.scene_text, *one, stopped);
        if (!row) return;
        lock.lock();
        finished.push_back(*std::move(row));
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
