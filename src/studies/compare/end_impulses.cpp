#include "studies/compare/end_impulses.hpp"

#include <algorithm>

#include "case/impulse.hpp"

namespace viscobar {

// A scheme's velocity is a difference over two steps and shows an impact that much earlier and later.
EndImpulses::EndImpulses(const Case& run, const Recording& recording)
    : times_(recording.times), blur_(is_scheme(run.method) ? 2.0 * *run.step : 0.0) {
  const BarSystem system = make_system(run);
  EndImpulse impulse(system);
  for (std::size_t k = 0; k < times_.size(); ++k) {
    impulse.add({times_[k], recording.displacement(k), recording.velocity(k)});
    left_.push_back(impulse.left());
    right_.push_back(impulse.right());
  }
}

double EndImpulses::over(const ContactPeriod& period) const {
  if (period.where == Where::span) return 0.0;
  const std::vector<double>& sums = period.where == Where::left ? left_ : right_;
  const auto after = std::upper_bound(times_.begin(), times_.end(), period.begin - blur_);
  const auto begin = after == times_.begin() ? 0 : after - times_.begin() - 1;
  const auto end =
      std::min<std::ptrdiff_t>(std::lower_bound(times_.begin(), times_.end(), period.end + blur_) - times_.begin(),
                               static_cast<std::ptrdiff_t>(sums.size()) - 1);
  return sums[static_cast<std::size_t>(end)] - sums[static_cast<std::size_t>(begin)];
}

}  // namespace viscobar
