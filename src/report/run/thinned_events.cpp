#include "report/run/thinned_events.hpp"

#include <cmath>

namespace viscobar {

namespace {

const Event& faster(const Event& a, const Event& b) { return std::abs(b.velocity) > std::abs(a.velocity) ? b : a; }

}  // namespace

void ThinnedEvents::add(const Event& event) {
  if (!kept_.empty() && in_last_ < stride_) {
    kept_.back() = faster(kept_.back(), event);
    ++in_last_;
    return;
  }
  if (kept_.size() == most) {
    for (std::size_t i = 0; i < most / 2; ++i) kept_[i] = faster(kept_[2 * i], kept_[2 * i + 1]);
    kept_.resize(most / 2);
    stride_ *= 2;
  }
  kept_.push_back(event);
  in_last_ = 1;
}

}  // namespace viscobar
