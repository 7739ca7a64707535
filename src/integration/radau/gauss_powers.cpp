#include "integration/radau/gauss_powers.hpp"

#include <optional>

#include "dynamics/energy_terms.hpp"

namespace viscobar::radau {

std::array<GaussPowers::Points, parts> GaussPowers::weights(int derivative) {
  std::array<Points, parts> weights;
  for (std::size_t g = 0; g < points; ++g) {
    const Parts at_point = Formula::get().weights(0.5 * (1.0 + StepPowers::nodes()[g]), derivative);
    for (std::size_t l = 0; l < parts; ++l) weights[l][static_cast<Eigen::Index>(g)] = at_point[l];
  }
  return weights;
}

std::array<StepPowers::Flow, GaussPowers::points> GaussPowers::operator()(PenalisedSystem& system, const Layout& layout,
                                                                          std::span<const double> w,
                                                                          std::span<const Complex> x, double begin,
                                                                          double length) {
  static const std::array<Points, parts> values = weights(0), rates = weights(1);
  w_.resize(w.size());
  for (std::size_t i = 0; i < w.size(); ++i) w_[i] = w[i] + combined(values, x[i]);
  std::array<StepPowers::Flow, points> flows{};
  const auto put = [&](std::optional<std::size_t> entry, const Points& power) {
    for (std::size_t g = 0; entry && g < points; ++g)
      flows[g][*entry - 2 * layout.nodes] = power[static_cast<Eigen::Index>(g)];
  };
  const auto velocity = [this](std::size_t i) -> const Points& { return w_[i]; };
  const Points zero = Points::Zero();
  put(layout.dissipated,
      dissipated_power(system.contacts(), velocity, system.bar().elements().squared_strain_rate(velocity, zero)));
  if (layout.work) put(layout.work, load(system, begin, length));
  if (layout.end_inertia) {
    Points sum = Points::Zero();
    for (const OneSidedRow& row : system.bar().inertia().matrix().one_sided) {
      Points force = Points::Zero();
      for (std::size_t k = 0; k < row.entries.size(); ++k) force += row.entries[k] * combined(rates, x[row.column(k)]);
      sum += (w_[row.row] * force / length).eval();
    }
    put(layout.end_inertia, sum);
  }
  return flows;
}

GaussPowers::Points GaussPowers::load(PenalisedSystem& system, double begin, double length) const {
  Points power = Points::Zero();
  if (!system.load().varies()) {
    const std::span<const double> load = system.load().nodal(begin);
    for (std::size_t i = 0; i < load.size(); ++i) power += load[i] * w_[i];
    return power;
  }
  for (Eigen::Index g = 0; g < power.size(); ++g) {
    const double s = StepPowers::nodes()[static_cast<std::size_t>(g)];
    const std::span<const double> load = system.load().nodal(begin + 0.5 * (1.0 + s) * length);
    for (std::size_t i = 0; i < load.size(); ++i) power[g] += load[i] * w_[i][g];
  }
  return power;
}

}  // namespace viscobar::radau
