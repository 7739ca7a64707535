#include <algorithm>
#include <cmath>

#include "integration/exponential/passage.hpp"
#include "integration/exponential/run.hpp"

namespace viscobar::exponential {

std::span<const double> Run::end_sample(const Series& series, double sigma, double tau) {
  const auto n = static_cast<std::size_t>(series.rows());
  for (std::size_t k = 0; k < end_entries_.size(); ++k) {
    const bool rate = end_entries_[k] >= n;
    const auto row = series.row(static_cast<Index>(rate ? end_entries_[k] - n : end_entries_[k]));
    double sum = 0.0;
    for (Index j = row.size(); j-- > (rate ? 1 : 0);)
      sum = sum * sigma + (rate ? static_cast<double>(j) : 1.0) * row[j];
    sampled_[k] = rate ? sum / tau : sum;
  }
  return sampled_;
}

std::optional<SampledFlow> Run::resolved_flow(const std::vector<Series>& motion, const std::vector<LoadPolynomial>& p,
                                              double tau, double penetration) const {
  std::vector<VectorXd> velocities, loads, accelerations;
  for (std::size_t k = 0; k < motion.size(); ++k) {
    velocities.push_back(motion[k].col(1) / tau);
    if (system_.loaded()) loads.push_back(load_.total(p[k]).col(0));
    if (leg().has_end_rows()) accelerations.push_back(motion[k].col(2) * (2.0 / (tau * tau)));
  }
  SampledFlow sampled = sampled_flow(leg(), velocities, loads, accelerations, tau, frame_loss(tau));
  EnergyFlow& flow = sampled.flow;
  // As a bar at rest sets in motion, its energy is so small that a share of it would be below the flow's own
  // rounding.
  const double share = 1e-12 * energy_scale_ * tau / (times_.back() - times_.front());
  // What may be rounding alone would add up in a long flight.
  const double ends = end_power_rounding(velocities) * tau;
  if (std::abs(flow.end_inertia) <= ends) {
    flow.end_inertia = 0.0;
    for (EnergyFlow& power : sampled.powers) power.end_inertia = 0.0;
  }
  const double known = 64.0 * rounding *
                           (std::abs(flow.dissipated) + std::abs(flow.work) + std::abs(flow.end_inertia) +
                            distance_.cancelled_power(penetration) * tau) +
                       ends;
  if (sampled.error > std::max({share, known, std::numeric_limits<double>::min()})) return std::nullopt;
  return sampled;
}

FrameLoss Run::frame_loss(double tau) const {
  if (!system_.moving()) return {};
  return [this, tau](double sigma, const VectorXd& v) { return penalised_.frame_loss(t_ + sigma * tau, entries(v)); };
}

double Run::end_power_rounding(const std::vector<VectorXd>& velocities) const {
  if (!system_.has_end_rows()) return 0.0;
  double fastest = 0.0;
  for (const VectorXd& v : velocities) fastest = std::max(fastest, v.cwiseAbs().maxCoeff());
  const Bar& bar = system_.bar();
  return 4.0 / 3.0 * fastest * bar.density * propagators_.inverse_inertia() * rounding *
         (bar.modulus * largest_displacement_ + bar.viscosity * fastest);
}

void Run::output_until(double t, double tau, const std::function<EnergyFlow(double)>& flow_until) {
  for (; next_output_ < times_.size() && times_[next_output_] <= t; ++next_output_) {
    const bool last = next_output_ + 1 == times_.size();
    if (!observers_.snapshot && !(last && statistics_.energy)) continue;
    VectorXd y = y_;
    LoadPolynomial p = p_;
    double s = times_[next_output_] - t_, width = tau;
    for (int level = level_ - 1; level >= 0; --level) {
      width /= 2;
      const LoadPolynomial first_half = rescaled(p, 0.0, 0.5);
      if (s < width) {
        p = first_half;
        continue;
      }
      propagator_->advance(level, y, first_half);
      p = rescaled(p, 0.5, 0.5);
      s -= width;
    }
    const Series series = propagator_->expand(y, p, width);
    const VectorXd u = leg().displacement(series, s / width) + propagators_.origin();
    const VectorXd v = leg().velocity(series, s / width, width);
    const double of_frame =
        statistics_.energy ? penalised_.frame_energy(times_[next_output_], entries(u), entries(v)) : 0.0;
    if (last && statistics_.energy) {
      statistics_.energy->final = penalised_.energy(entries(u), entries(v)) + of_frame;
      statistics_.energy->work += of_frame;
    }
    if (!observers_.snapshot) continue;
    std::optional<EnergyState> energy;
    if (statistics_.energy) {
      const EnergyFlow flow = flow_until((times_[next_output_] - t_) / tau);
      energy = EnergyState{.dissipated = statistics_.energy->dissipated + flow.dissipated,
                           .work = statistics_.energy->work + flow.work + (last ? 0.0 : of_frame),
                           .end_inertia = statistics_.energy->end_inertia + flow.end_inertia};
    }
    tell_snapshot(times_[next_output_], u, v, series, p, s / width, energy);
  }
}

void Run::tell_snapshot(double t, const VectorXd& u, const VectorXd& v, const Series& series, const LoadPolynomial& p,
                        double sigma, std::optional<EnergyState> energy) {
  Snapshot snapshot = snapshot_(t, entries(u), entries(v));
  if (energy) {
    const EnergyState held = snapshot_.energy(entries(u));
    energy->kinetic = held.kinetic;
    energy->elastic = held.elastic;
    energy->contact = held.contact;
    snapshot.energy = energy;
  }
  // Again from the penetration itself, which has more digits than the displacement.
  const auto reaction = [&](Index end) {
    double sum = 0.0;
    for (std::size_t c = 0; c < contacts(); ++c)
      if (penalised_.closed(c) && node(c) == end)
        sum += sign(c) *
               penalised_.law(c).reaction(distance_.penetration_share(c) * value(distance_.along(c, series, p), sigma),
                                          -sign(c) * v[end]);
    return sum;
  };
  if (!system_.left_fixed()) snapshot.reaction_left = reaction(0);
  if (!system_.right_fixed()) snapshot.reaction_right = reaction(v.size() - 1);
  telling_.snapshot(snapshot);
}

bool Run::energy_flows() const {
  return statistics_.energy && (penalised_.takes_energy() || system_.loaded() || system_.has_end_rows());
}

void Run::add(const EnergyFlow& flow) {
  statistics_.energy->dissipated += flow.dissipated;
  statistics_.energy->work += flow.work;
  statistics_.energy->end_inertia += flow.end_inertia;
  energy_scale_ = std::max(energy_scale_, statistics_.energy->initial + std::abs(statistics_.energy->work));
}

}  // namespace viscobar::exponential
