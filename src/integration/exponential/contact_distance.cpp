#include "integration/exponential/contact_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/obstacle_motion.hpp"
#include "integration/bernstein.hpp"
#include "integration/events/approach.hpp"

namespace viscobar::exponential {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// An error that vanishes like s^2 (1-s)^2 on each half, 1 at most, has 1.6 as Bernstein coefficients 2 and 3.
bool may_err(std::size_t i) { return i % 6 == 2 || i % 6 == 3; }

}  // namespace

SampledRange::SampledRange(const Samples& samples) {
  const auto& [f, g] = samples;
  const double first = (36 * f[2] + 22.5 * f[0] + 5.5 * f[4] - 18 * g[1] + 4.5 * g[0] - 1.5 * g[2]) / 64;
  const double third = (36 * f[2] + 5.5 * f[0] + 22.5 * f[4] + 18 * g[1] + 1.5 * g[0] - 4.5 * g[2]) / 64;
  margin_ = 1.6 * 4 * std::max(std::abs(f[1] - first), std::abs(f[3] - third));
  const std::array<double, 3> curvature = {8 * f[2] - 11.5 * f[0] + 3.5 * f[4] - 8 * g[1] - 6 * g[0] - g[2],
                                           2 * (f[0] - 2 * f[2] + f[4]) + 0.5 * (g[0] - g[2]),
                                           8 * f[2] + 3.5 * f[0] - 11.5 * f[4] + 8 * g[1] + g[0] + 6 * g[2]};
  for (std::size_t half = 0; half < 2; ++half) {
    double* const b = control_.data() + 6 * half;
    const double left = f[2 * half], right = f[2 * half + 2];
    b[0] = left;
    b[1] = left + g[half] / 5;
    b[2] = left + 0.4 * g[half] + curvature[half] / 20;
    b[3] = right - 0.4 * g[half + 1] + curvature[half + 1] / 20;
    b[4] = right - g[half + 1] / 5;
    b[5] = right;
  }
}

double SampledRange::lowest() const {
  double lowest = control_[0];
  for (std::size_t i = 1; i < 12; ++i) lowest = std::min(lowest, control_[i] - (may_err(i) ? margin_ : 0.0));
  return lowest;
}

double SampledRange::highest() const {
  double highest = control_[0];
  for (std::size_t i = 1; i < 12; ++i) highest = std::max(highest, control_[i] + (may_err(i) ? margin_ : 0.0));
  return highest;
}

bool SampledRange::monotone() const {
  bool up = true, down = true;
  for (std::size_t i = 0; i + 1 < control_.size(); ++i) {
    const double slack = may_err(i) || may_err(i + 1) ? margin_ : 0.0;
    up &= control_[i + 1] - control_[i] >= slack;
    down &= control_[i] - control_[i + 1] >= slack;
  }
  return up || down;
}

double value(const VectorXd& c, double sigma) {
  double sum = 0.0;
  for (Index k = c.size(); k-- > 0;) sum = sum * sigma + c[k];
  return sum;
}

double slope(const VectorXd& c, double sigma) {
  double sum = 0.0;
  for (Index k = c.size(); k-- > 1;) sum = sum * sigma + static_cast<double>(k) * c[k];
  return sum;
}

double largest_value(const VectorXd& c, double sigma) {
  double rising = 0.0, falling = sigma;
  if (slope(c, 0.0) > 0.0 && slope(c, sigma) < 0.0)
    for (int halving = 0; halving < 30; ++halving) {  // the value is flat there: half of its digits are enough
      const double middle = (rising + falling) / 2;
      (slope(c, middle) > 0.0 ? rising : falling) = middle;
    }
  return std::max(value(c, rising), value(c, sigma));
}

std::optional<double> first_passage(const VectorXd& c, double band) {
  if (c[0] - c.tail(c.size() - 1).cwiseAbs().sum() >= -band) return std::nullopt;
  const std::span<const double> powers(c.data(), static_cast<std::size_t>(c.size()));
  const std::optional<double> passage = Bernstein::of_powers(powers).first_descent(-band, 0x1p-57);
  if (!passage) return std::nullopt;
  double sigma = *passage;
  for (int iteration = 0; iteration < 3 && slope(c, sigma) < 0.0; ++iteration)
    sigma = std::clamp(sigma - value(c, sigma) / slope(c, sigma), 0.0, *passage);
  return sigma;
}

constexpr double rounding = std::numeric_limits<double>::epsilon();

VectorXd ContactDistance::along(std::size_t c, const Series& series, const LoadPolynomial& p) const {
  VectorXd result;
  if (follows(c)) {
    result = series.row(node(c) == 0 ? 1 : node(c) - 1).transpose();
    const MatrixXd load = load_.total(p);
    const Index shared = std::min(load.cols(), result.size());
    if (shared > 0)
      result.head(shared) +=
          load.row(node(c)).head(shared).transpose() *
          (system_.elements().stretch_beside(penalised_.contacts()[c].unknown) / system_.bar().modulus);
  } else {
    result = series.row(node(c)).transpose();
    if (penalised_.contacts()[c].joint > 0) result -= series.row(node(c) - 1).transpose();
  }
  result[0] -= penalised_.contacts().surface(c);
  const bool inwards = penalised_.contacts().closed(c) == (penalised_.contacts()[c].sign > 0.0);
  return inwards ? VectorXd(-result) : result;
}

double ContactDistance::band(std::size_t c, const Largest& largest) const {
  if (penalised_.contacts().closed(c) && !follows(c))
    return 32.0 * rounding * (largest.penetration + std::abs(penalised_.contacts().surface(c)));
  return penalised_.contacts()[c].clearance_rounding(largest.displacement);
}

// A massless node's velocity is a difference of forces over its viscosity: what the roundings of a strain and of the
// spring make of a displacement extrapolated by it over a step. A maximum good to more digits would take steps as short
// as the node's relaxation.
double ContactDistance::slope_noise(std::size_t c, double tau, const Largest& largest) const {
  if (!system_.bar().damped() || !massless(c)) return 0.0;
  const Bar& bar = system_.bar();
  const double spring = penalised_.contacts()[c].law.linear().stiffness *
                        system_.elements().stretch_beside(penalised_.contacts()[c].unknown) * largest.penetration;
  return 8.0 * rounding * (largest.displacement * bar.modulus + spring) / bar.viscosity * tau;
}

std::optional<ContactDistance::Push> ContactDistance::push(std::size_t c, const VectorXd& d, double tau,
                                                           const Largest& largest) const {
  if (lags_.empty() || lags_[c] == 0.0) return std::nullopt;
  const double rounded = band(c, largest);
  if (!penalised_.contacts().closed(c) && d[0] >= -rounded) return std::nullopt;
  Push push{d.head(d.size() - 1), rounded};
  for (Index k = 0; k < push.along.size(); ++k) {
    const double rate = lags_[c] / tau * static_cast<double>(k + 1) * d[k + 1];
    push.along[k] += rate;
    push.band += 32.0 * rounding * std::abs(rate);
  }
  return push;
}

namespace {

// At the quarters of a step, of what has the Taylor coefficients along(k) about part k of the motion.
SampledRange::Samples sampled(std::size_t parts, auto&& along) {
  SampledRange::Samples all{};
  for (std::size_t k = 0; k < all.values.size(); ++k) {
    const VectorXd sample = along(k * (parts / 4));
    all.values[k] = sample[0];
    if (k % 2 == 0) all.slopes[k / 2] = sample[1] / 2;
  }
  return all;
}

}  // namespace

SampledRange::Samples ContactDistance::samples(std::size_t c, const std::vector<Series>& motion,
                                               const std::vector<LoadPolynomial>& p) const {
  return sampled(motion.size(), [&](std::size_t k) { return along(c, motion[k], p[k]); });
}

bool ContactDistance::stays_away(std::size_t c, const std::vector<Series>& motion, const std::vector<LoadPolynomial>& p,
                                 double t, double tau, double whole, const Largest& largest) const {
  const Contact& contact = penalised_.contacts()[c];
  const double nearest = SampledRange(samples(c, motion, p)).lowest() - contact.gap;
  return !may_reach_within(
      whole, [&](double at) { return nearest + system_.frame().gap(contact, at); }, breaks_of_gap(system_, contact),
      band(c, largest), t, t + tau);
}

// d + (c/k) d' stays positive during the step.
bool ContactDistance::keeps_push(std::size_t c, const std::vector<Series>& motion, const std::vector<LoadPolynomial>& p,
                                 double tau, const Largest& largest) const {
  double band = 0.0;
  bool pushes = true;
  const auto all = sampled(motion.size(), [&](std::size_t k) {
    VectorXd d = along(c, motion[k], p[k]);
    const auto sample = push(c, d, tau, largest);
    pushes &= sample.has_value();
    band = std::max(band, sample ? sample->band : 0.0);
    return sample ? sample->along : d;
  });
  return pushes && SampledRange(all).lowest() >= -band;
}

bool ContactDistance::keeps_state(std::size_t c, const std::vector<Series>& motion,
                                  const std::vector<LoadPolynomial>& p, double tau, const Largest& largest,
                                  double& penetration) const {
  const SampledRange::Samples samples = this->samples(c, motion, p);
  const SampledRange range(samples);
  const bool lets_go = !lags_.empty() && lags_[c] > 0.0, closed = penalised_.contacts().closed(c);
  if (lets_go && closed && !keeps_push(c, motion, p, tau, largest)) return false;
  if (range.lowest() < -band(c, largest)) return lets_go && !closed && keeps_push(c, motion, p, tau, largest);
  if (!closed) return true;
  const double share = penetration_share(c);
  penetration = std::max(penetration, share * std::ranges::max(samples.values));
  return range.monotone() || share * range.highest() <= penetration * (1.0 + 1e-13) + rounding * largest.displacement +
                                                            std::min(slope_noise(c, tau, largest), 1e-6 * penetration);
}

double ContactDistance::cancelled_power(double penetration) const {
  double power = 0.0;
  for (std::size_t c = 0; c < penalised_.contacts().size(); ++c) {
    if (!system_.bar().damped() || !massless(c) || !penalised_.contacts().closed(c)) continue;
    const double force = penalised_.contacts()[c].law.linear().stiffness * penetration;
    power +=
        force * force * system_.elements().stretch_beside(penalised_.contacts()[c].unknown) / system_.bar().viscosity;
  }
  return power;
}

}  // namespace viscobar::exponential
