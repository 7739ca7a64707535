#include "integration/exponential/contact_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "integration/exponential/passage.hpp"

namespace viscobar::exponential {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double rounding = std::numeric_limits<double>::epsilon();

bool ContactDistance::massless(std::size_t c) const {
  const std::size_t i = penalised_.contact(c).unknown;
  return i < system_.massive_begin() || i >= system_.massive_end();
}

VectorXd ContactDistance::along(std::size_t c, const Series& series, const LoadPolynomial& p) const {
  VectorXd result;
  if (follows(c)) {
    result = series.row(node(c) == 0 ? 1 : node(c) - 1).transpose();
    const MatrixXd load = load_.total(p);
    const Index shared = std::min(load.cols(), result.size());
    if (shared > 0)
      result.head(shared) += load.row(node(c)).head(shared).transpose() *
                             (system_.spacing_at(penalised_.contact(c).unknown) / system_.bar().modulus);
  } else {
    result = series.row(node(c)).transpose();
  }
  result[0] -= propagators_.surface(c);
  const bool inwards = penalised_.closed(c) == (penalised_.contact(c).sign > 0.0);
  return inwards ? VectorXd(-result) : result;
}

double ContactDistance::band(std::size_t c, const Largest& largest) const {
  if (penalised_.closed(c) && !follows(c))
    return 32.0 * rounding * (largest.penetration + std::abs(propagators_.surface(c)));
  return penalised_.clearance_rounding(c, largest.displacement);
}

// A massless node's velocity is a difference of forces over its viscosity: what the rounding of a strain makes of a
// displacement extrapolated by it over a step. A maximum good to more digits would take steps as short as the node's
// relaxation.
double ContactDistance::slope_noise(std::size_t c, double tau, const Largest& largest) const {
  if (!system_.damped() || !massless(c)) return 0.0;
  const Bar& bar = system_.bar();
  return 8.0 * rounding * largest.displacement * bar.modulus / bar.viscosity * tau;
}

bool ContactDistance::keeps_state(std::size_t c, const std::vector<Series>& motion,
                                  const std::vector<LoadPolynomial>& p, double tau, const Largest& largest,
                                  double& penetration) const {
  const std::size_t quarter = motion.size() / 4;
  std::array<double, 5> values;
  std::array<double, 3> slopes;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const VectorXd sample = along(c, motion[k * quarter], p[k * quarter]);
    values[k] = sample[0];
    if (k % 2 == 0) slopes[k / 2] = sample[1] / 2;
  }
  const SampledRange range(values, slopes);
  if (range.lowest() < -band(c, largest)) return false;
  if (!penalised_.closed(c)) return true;
  const double share = penetration_share(c);
  penetration = std::max(penetration, share * std::ranges::max(values));
  return range.monotone() || share * range.highest() <= penetration * (1.0 + 1e-13) + rounding * largest.displacement +
                                                            std::min(slope_noise(c, tau, largest), 1e-6 * penetration);
}

double ContactDistance::cancelled_power(double penetration) const {
  double power = 0.0;
  for (std::size_t c = 0; c < penalised_.contact_count(); ++c) {
    if (!system_.damped() || !massless(c) || !penalised_.closed(c)) continue;
    const double force = penalised_.law(c).stiffness * penetration;
    power += force * force * system_.spacing_at(penalised_.contact(c).unknown) / system_.bar().viscosity;
  }
  return power;
}

}  // namespace viscobar::exponential
