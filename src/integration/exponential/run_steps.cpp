#include <algorithm>
#include <cmath>

#include "integration/exponential/passage.hpp"
#include "integration/exponential/run.hpp"
#include "run/step_failure.hpp"

namespace viscobar::exponential {

namespace {

constexpr int max_load_jumps = 1000;

}  // namespace

bool Run::advance() {
  if (t_ >= piece_end_) {
    enter_piece();
    pass_kink();
  }
  largest_displacement_ = std::max(
      largest_displacement_,
      (y_.head(leg().displacements()) + propagators_.origin().head(leg().displacements())).cwiseAbs().maxCoeff());
  const double remaining = std::min(schedule_.next().value_or(piece_end_), piece_end_) - t_;
  // A varying load that vanishes at all points of a long step could hide a pulse between them.
  const double longest = load_.varies() ? std::min(remaining, (times_.back() - times_.front()) / 64) : remaining;
  while (level_ > 0 && propagator_->step(level_) > longest) --level_;
  const double tau = std::min(propagator_->step(level_), remaining);
  if (t_ + tau == t_) throw StepFailure(Failure::stiffness, "the step vanishes against the time");
  const bool resolved = load_.fit(t_, tau, negligible_load(), p_);
  if (!resolved && tau > shortest_step()) return shorten(), false;
  // A step of a few roundings of t carries nothing: that is how a jump of the load is crossed.
  if (!resolved && ++load_jumps_ > max_load_jumps)
    throw StepFailure(Failure::load, "the load is too rough there: no polynomial in time follows it to rounding");
  if (level_ <= 0)
    take_short_step(tau);
  else if (!take_long_step(tau))
    return shorten(), false;
  ++statistics_.steps;
  watchdog_.step(t_, statistics_.events);
  if (!y_.allFinite()) throw not_finite();
  return true;
}

double Run::negligible_load() const {
  const double duration = times_.back() - times_.front();
  const double massless = system_.has_massless() ? system_.mesh().spacing() / system_.bar().modulus : 0.0;
  return rounding * largest_displacement_ / std::max(duration * duration * propagators_.inverse_inertia(), massless);
}

bool Run::take_long_step(double tau) {
  const int halvings = energy_flows() || ends_ ? 3 : contacts() > 0 ? 2 : 0, pieces = 1 << halvings;
  const bool sampled = pieces > 1;
  std::vector<LoadPolynomial> p;
  std::vector<Series> motion;
  VectorXd y = y_;
  for (int k = 0; k <= pieces; ++k) {
    const double at = static_cast<double>(k) / pieces;
    if (sampled) {
      p.push_back(rescaled(p_, at, 1.0));
      motion.push_back(propagator_->expand(y, p[k], tau, leg().has_end_rows() ? 2 : 1));
    }
    if (k < pieces) propagator_->advance(level_ - halvings, y, rescaled(p_, at, 1.0 / pieces));
  }
  if (contacts() > 0) ++statistics_.event_evaluations;
  double penetration = statistics_.max_penetration;
  for (std::size_t c = 0; c < contacts(); ++c)
    if (!distance_.keeps_state(c, motion, p, tau, largest(), penetration)) return false;
  if (ends_) {
    ends_->look_at(t_, t_ + tau, pieces, [&](std::size_t k, double) { return end_sample(motion[k], 0.0, tau); });
    if (!ends_->resolved()) return false;
  }
  std::optional<SampledFlow> flow;
  if (energy_flows() && !(flow = resolved_flow(motion, p, tau, penetration))) return false;
  if (ends_) ends_->add();
  output_until(t_ + tau, tau, [&](double sigma) { return flow ? flow->until(sigma) : EnergyFlow{}; });
  if (flow) add(flow->flow);
  statistics_.max_penetration = penetration;
  y_ = std::move(y);
  t_ += tau;
  lengthen();
  return true;
}

void Run::take_short_step(double tau) {
  const Series series = propagator_->expand(y_, p_, tau);
  double sigma = 1.0;
  std::optional<std::size_t> changing;
  std::vector<VectorXd> distances;
  if (contacts() > 0) ++statistics_.event_evaluations;
  // Of a bar that has stood at the origin, with the motion of this step: the load's polynomial has roundings, too.
  ContactDistance::Largest known = largest();
  if (contacts() > 0)
    known.displacement =
        std::max(known.displacement, (leg().displacement(series, 1.0) + propagators_.origin()).cwiseAbs().maxCoeff());
  for (std::size_t c = 0; c < contacts(); ++c) {
    distances.push_back(distance_.along(c, series, p_));
    if (penalised_.closed(c)) known.penetration = std::max(known.penetration, std::abs(value(distances[c], 1.0)));
  }
  for (std::size_t c = 0; c < contacts(); ++c) {
    const std::optional<double> passage = first_passage(distances[c], distance_.band(c, known));
    if (passage && (!changing || *passage < sigma)) sigma = *passage, changing = c;
  }
  const double t = t_ + tau * sigma;
  output_until(t, tau, [&](double at) {
    return energy_flows() ? gauss_flow(leg(), series, load_.total(p_), tau, at, frame_loss(tau)) : EnergyFlow{};
  });
  for (std::size_t c = 0; c < contacts(); ++c)
    if (penalised_.closed(c))
      statistics_.max_penetration =
          std::max(statistics_.max_penetration, distance_.penetration_share(c) * largest_value(distances[c], sigma));
  if (energy_flows()) add(gauss_flow(leg(), series, load_.total(p_), tau, sigma, frame_loss(tau)));
  if (ends_) {
    // Of that degree the series is the motion to rounding, since (rate bound) * step <= 1.
    ends_->look_at(t_, t, Bernstein::max_degree,
                   [&](std::size_t, double at) { return end_sample(series, (at - t_) / tau, tau); });
    ends_->add();
  }
  const VectorXd u = leg().displacement(series, sigma), v = leg().velocity(series, sigma, tau);
  y_ = leg().pack(u, v);
  t_ = t;
  if (changing)
    change_contacts(*changing, distances, sigma, v);
  else
    lengthen();
}

void Run::change_contacts(std::size_t first, const std::vector<VectorXd>& distances, double sigma, const VectorXd& v) {
  std::vector<std::size_t> changing;
  for (std::size_t c = 0; c < contacts(); ++c) {
    const double away = sign(c) * v[node(c)];
    const bool leaving = penalised_.closed(c) ? away > 0.0 : away < 0.0;
    if (c == first || (leaving && std::abs(value(distances[c], sigma)) <= distance_.band(c, largest())))
      changing.push_back(c);
  }
  for (const std::size_t c : changing) {
    penalised_.set_closed(c, !penalised_.closed(c));
    if (penalised_.closed(c)) measure_from_obstacle(c);
    if (!distance_.follows(c)) y_[node(c)] = propagators_.surface(c);  // to the digits that only the new leg needs
    tell_change(c, v[node(c)]);
  }
  begin_leg();
}

void Run::tell_change(std::size_t c, double velocity) {
  watchdog_.change(t_, c);
  if (system_.moving()) velocity += system_.lift(t_, 1).at(system_.share(penalised_.contact(c).unknown));
  telling_.event(t_, system_, penalised_.contact(c), penalised_.closed(c) ? Change::closing : Change::opening,
                 velocity);
}

}  // namespace viscobar::exponential
