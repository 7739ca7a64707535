#include "viscobar/analysis/impulse.hpp"

#include <algorithm>

namespace viscobar {

EndImpulse::EndImpulse(const BarSystem& system)
    : system_(system), momentum_(system.size()), force_(system.size()), rest_(system.size()) {
  if (system.loaded()) load_.emplace(system);
}

void EndImpulse::add(const Snapshot& at) {
  const std::size_t n = system_.size(), last = at.u.size() - 1;
  const Mesh& mesh = system_.mesh();
  const double eta = system_.bar().viscosity, h_left = mesh.element(0), h_right = mesh.element(mesh.elements - 1);
  system_.inertia().multiply(at.v.subspan(system_.first_node(), n), momentum_);
  system_.internal_force(at.u.subspan(system_.first_node(), n), rest_, force_);
  if (load_) {
    const auto f = load_->at(at.time);
    for (std::size_t i = 0; i < n; ++i) force_[i] += f[i];
  }
  const auto advance = [&](std::optional<Row>& before, double stored, double rate, double& sum) {
    if (before) sum += stored - before->stored + 0.5 * (at.time - time_) * (rate + before->rate);
    before = Row{stored, rate};
  };
  advance(left_, momentum_.front() + eta * (at.u[0] - at.u[1]) / h_left, -force_.front(), left_sum_);
  advance(right_, momentum_.back() + eta * (at.u[last] - at.u[last - 1]) / h_right, -force_.back(), right_sum_);
  time_ = at.time;
}

// A scheme's velocity is a difference over two steps and shows an impact that much earlier and later.
EndImpulses::EndImpulses(const Case& run, const Recording& recording)
    : times_(recording.times), blur_(is_scheme(run.method) ? 2.0 * *run.step : 0.0) {
  if (run.method == MethodName::characteristics) {
    left_ = recording.impulse_left;
    right_ = recording.impulse_right;
    return;
  }
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
