#include "sweep/sweep_queue.hpp"

#include <algorithm>
#include <numeric>

#include "sweep/neighbours.hpp"

namespace viscobar {

SweepQueue::SweepQueue(const SweepFile& sweep, std::span<const double> costs, std::span<const SweepRow* const> finished)
    : sweep_(sweep),
      costs_(costs),
      neighbours_(neighbours(sweep.plan)),
      finished_(costs.size()),
      starts_(costs.size()) {
  for (const SweepRow* row : finished) finish(*row);
  for (const bool waiting : {false, true})
    for (const std::size_t i : dispatch_order(costs))
      if (!finished_[i] && neighbours_[i].has_value() == waiting) left_.push_back(i);
}

std::optional<SweepCase> SweepQueue::take() {
  const auto next =
      std::ranges::find_if(left_, [&](std::size_t i) { return !neighbours_[i] || finished_[*neighbours_[i]]; });
  if (next == left_.end()) return std::nullopt;
  SweepCase one = case_of(sweep_, *next);
  left_.erase(next);
  if (const auto neighbour = neighbours_[one.index])
    if (const auto& start = starts_[*neighbour]) one.neighbour = {*neighbour, *start};
  return one;
}

void SweepQueue::finish(const SweepRow& row) {
  finished_[row.index] = true;
  starts_[row.index] = row.start();
}

double SweepQueue::seconds() const {
  return std::accumulate(left_.begin(), left_.end(), 0.0, [&](double sum, std::size_t i) { return sum + costs_[i]; });
}

}  // namespace viscobar
