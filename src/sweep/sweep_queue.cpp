#include "sweep/sweep_queue.hpp"

#include <numeric>

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

}  // namespace viscobar
