#include "viscobar/analysis/impulse.hpp"

#include <algorithm>
#include <optional>

namespace viscobar {

// A scheme's velocity is a difference over two steps and shows an impact that much earlier and later.
EndImpulses::EndImpulses(const Case& run, const Recording& recording)
    : times_(recording.times), blur_(is_scheme(run.method) ? 2.0 * *run.step : 0.0) {
  const BarSystem system = make_system(run);
  std::optional<LoadVector> load;
  if (system.loaded()) load.emplace(system);
  const std::size_t n = system.size();
  const Bar& bar = system.bar();
  const Mesh& mesh = system.mesh();
  const double h_left = mesh.element(0), h_right = mesh.element(mesh.elements - 1);
  std::vector<double> momentum(n), force(n);
  const std::vector<double> rest(n);
  struct Row {
    double stored, rate;  // rho M v + eta K u, and E K u - M f
  };
  std::optional<Row> left, right;
  double left_sum = 0.0, right_sum = 0.0;
  for (std::size_t k = 0; k < times_.size(); ++k) {
    const auto nodal = recording.displacement(k);
    const auto u = nodal.subspan(system.first_node(), n);
    system.inertia().multiply(recording.velocity(k).subspan(system.first_node(), n), momentum);
    system.internal_force(u, rest, force);
    if (load) {
      const auto f = load->at(times_[k]);
      for (std::size_t i = 0; i < n; ++i) force[i] += f[i];
    }
    const std::size_t last = nodal.size() - 1;
    const auto advance = [&](std::optional<Row>& before, double stored, double rate, double& sum) {
      if (before) sum += stored - before->stored + 0.5 * (times_[k] - times_[k - 1]) * (rate + before->rate);
      before = Row{stored, rate};
    };
    advance(left, momentum.front() + bar.viscosity * (nodal[0] - nodal[1]) / h_left, -force.front(), left_sum);
    advance(right, momentum.back() + bar.viscosity * (nodal[last] - nodal[last - 1]) / h_right, -force.back(),
            right_sum);
    left_.push_back(left_sum);
    right_.push_back(right_sum);
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
