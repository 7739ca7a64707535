#include "case/impulse.hpp"

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

}  // namespace viscobar
