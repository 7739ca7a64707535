#include "studies/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace viscobar {

std::size_t cores() {
  static const std::size_t count = std::max(1u, std::thread::hardware_concurrency());
  return count;
}

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& work, std::size_t threads) {
  if (threads == 0) threads = cores();
  std::atomic<std::size_t> next{0};
  std::exception_ptr error;
  std::mutex mutex;
  const auto run = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!error) error = std::current_exception();
        next = count;
      }
    }
  };
  {
    std::vector<std::jthread> pool;
    for (std::size_t k = 1; k < std::min(threads, count); ++k) pool.emplace_back(run);
    run();
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace viscobar
