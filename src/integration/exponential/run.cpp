#include "integration/exponential/run.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/energy_terms.hpp"
#include "dynamics/obstacle_motion.hpp"
#include "integration/approach.hpp"
#include "run/step_failure.hpp"

namespace viscobar::exponential {

PartEnd Run::operator()(const StartingPoint& start) {
  const auto stopped = [&] {
    close_energy();
    return reached();
  };
  return part_or_failure("exponential", stopped, [&]() -> PartEnd {
    if (const auto* checkpoint = std::get_if<Checkpoint>(&start))
      go_on(*checkpoint);
    else
      begin(std::get<State>(start));
    while (t_ < times_.back()) {
      if (!advance()) continue;
      if (entered_) return std::move(*entered_);
      if (!notifier_.progress(t_)) return reached();
      if (t_ < times_.back() && schedule_.due(t_))
        return Checkpoint{t_, next_output_, reached(), archived(*this), frame_of(system_)};
    }
    statistics_.completed = true;
    return reached();
  });
}

Statistics Run::reached() {
  statistics_.reached_time = t_;
  statistics_.load_evaluations = load_evaluations_before_ + load_.evaluations() + penalised_.load().evaluations();
  notifier_.count_seconds();
  return statistics_;
}

void Run::close_energy() {
  if (!statistics_.energy || y_.size() == 0) return;
  try {
    const std::vector<double> u = displacement();
    std::vector<double> w = velocity();
    penalised_.complete_velocity(t_, u, w);
    const double of_frame = frame_energy(penalised_, t_, u, w);
    statistics_.energy->final = energy(penalised_.contacts(), u, w) + of_frame;
    statistics_.energy->work += of_frame;
  } catch (const std::exception&) {  // the cause of the failure may stop this, too
  }
}

// Undamped nodes without mass follow their rows at once. Where a load jumps, or opens or closes their contact by that,
// the energy that it gives them is its work.
double Run::energy_of_followers() {
  if (!statistics_.energy || !system_.inertia().has_massless() || system_.bar().damped()) return 0.0;
  const std::vector<double> w(system_.size());
  return energy(penalised_.contacts(), displacement(), w);
}

void Run::enter_piece() {
  piece_end_ = penalised_.load().begin_leg(t_, times_.back());
  load_.enter(t_, times_.back());
}

void Run::pass_kink() {
  const auto jump = system_.frame().kink(t_, times_.back());
  if (!jump) return;
  std::vector<double> u = displacement(), w = velocity(), change = w;
  const double before = energy(penalised_.contacts(), u, w);
  system_.frame().pass_kink(*jump, u, w);
  for (std::size_t i = 0; i < w.size(); ++i) change[i] = w[i] - change[i];
  std::vector<std::size_t> left;
  if (jump->displaces()) left = left_by_jump(penalised_.contacts(), *jump, t_, u, largest_displacement_);
  if (ends_ && !jump->displaces()) ends_->pass_kink(change);
  for (Index k = 0; jump->displaces() && k < leg().displacements(); ++k)
    y_[k] -= jump->displacement.at(system_.frame().share(first_displacement() + static_cast<std::size_t>(k)));
  const std::size_t first = system_.inertia().massive_begin(), count = system_.inertia().massive_end() - first;
  std::copy_n(w.data() + first, count, y_.data() + leg().displacements());
  if (jump->displaces()) leave_obstacles(left, u, w);
  if (statistics_.energy) statistics_.energy->work += energy(penalised_.contacts(), u, w) - before;
}

void Run::leave_obstacles(const std::vector<std::size_t>& left, std::span<double> u, std::span<double> w) {
  if (ends_) {
    penalised_.complete_velocity(t_, u, w);
    std::vector<double> measured(u.begin(), u.end());
    for (std::size_t i = 0; i < u.size(); ++i) measured[i] -= propagators_.origin()[static_cast<Index>(i)];
    ends_->enter_frame(measured, w);
  }
  for (const std::size_t c : left) {
    penalised_.contacts().set_closed(c, false);
    penalised_.complete_displacement(t_, u);
    penalised_.complete_velocity(t_, u, w);
    tell_change(c, penalised_.contacts()[c].of(w));
  }
  begin_leg();
}

std::vector<double> Run::displacement() {
  std::vector<double> u(system_.size());
  for (Index k = 0; k < leg().displacements(); ++k) {
    const std::size_t i = first_displacement() + static_cast<std::size_t>(k);
    u[i] = y_[k] + propagators_.origin()[static_cast<Index>(i)];
  }
  penalised_.complete_displacement(t_, u);
  return u;
}

std::vector<double> Run::velocity() const {
  std::vector<double> w(system_.size(), 0.0);
  std::ranges::copy(y_.tail(leg().size() - leg().displacements()),
                    w.begin() + static_cast<std::ptrdiff_t>(system_.inertia().massive_begin()));
  return w;
}

void Run::settle_high_modes(bool starting) {
  if (!filter_.acts()) return;
  for (std::size_t c = 0; c < contacts(); ++c)
    if (starting && penalised_.contacts().closed(c)) return;
  std::vector<double> u = displacement(), w(system_.size());
  const Index n = leg().displacements();
  std::copy_n(y_.data() + n, n, w.begin());
  const std::vector<double> before = u;
  JumpFilter::Taken taken;
  if (starting) {
    // The state is known to rounding.
    const NaturalScales scales = natural_scales(system_, times_.back());
    taken = filter_.begin(penalised_, t_, {1e-12 * scales.displacement, 1e-12 * scales.velocity()}, u, w);
  } else {
    taken = filter_.pass_break(penalised_, t_, times_.back(), u, w);
  }
  if (u == before && std::ranges::equal(w, y_.segment(n, n))) return;
  for (std::size_t i = 0; i < u.size(); ++i) y_[static_cast<Index>(i)] += u[i] - before[i];
  std::ranges::copy(w, y_.data() + n);
  if (ends_) ends_->begin(t_, {y_.data(), u.size()}, w);
  if (!statistics_.energy) return;
  statistics_.energy->take_by_rows(taken.energy);
  statistics_.energy->work += taken.work;
}

void Run::begin(const State& start) {
  State state = start;
  enter_piece();
  penalised_.complete_displacement(t_, state.u);
  penalised_.complete_velocity(t_, state.u, state.v);
  const std::vector<double> approach = state.v;
  penalised_.settle(t_, state.u, state.v);
  const auto vector = [](const std::vector<double>& x) {
    return VectorXd(Eigen::Map<const VectorXd>(x.data(), static_cast<Index>(x.size())));
  };
  begin_leg();
  y_ = leg().pack(vector(state.u), vector(state.v));
  if (observers_.account) {
    statistics_.account.emplace();
    watch_ends();
    ends_->begin(t_, state.u, state.v);
  }
  for (std::size_t c = 0; c < contacts(); ++c) {
    if (!penalised_.contacts().closed(c)) continue;
    statistics_.max_penetration = std::max(statistics_.max_penetration, -penalised_.contacts().clearance(c, state.u));
    measure_from_obstacle(c);
    tell_change(c, penalised_.contacts()[c].of(approach));
  }
  begin_leg();
  statistics_.unknowns = static_cast<std::size_t>(y_.size());
  if (observers_.energy) {
    energy_scale_ = energy(penalised_.contacts(), state.u, state.v);
    const double of_frame = frame_energy(penalised_, t_, state.u, state.v);
    statistics_.energy = {.initial = energy_scale_ + of_frame, .work = -of_frame};
  }
  if (filter_.acts()) {
    // The start is told with the data.
    load_.fit(t_, propagator_->step(0), negligible_load(), p_);
    output_until(t_, propagator_->step(0), [](double) { return EnergyFlow{}; });
  }
  pass_kink();
  settle_high_modes(true);
}

void Run::go_on(const Checkpoint& checkpoint) {
  enter_piece();
  begin_leg();
  y_.resize(leg().size());
  if (observers_.account && statistics_.account) watch_ends();
  restore(*this, checkpoint, times_, observers_);
  next_output_ = checkpoint.outputs;
  for (std::size_t c = 0; c < contacts(); ++c)
    if (measured_[c]) propagators_.measure_from_obstacle(c);
  begin_leg();
  if (checkpoint.frame == Checkpoint::Frame::entered) return;  // the part before has passed what is here
  pass_kink();
  settle_high_modes(false);
}

void Run::watch_ends() {
  ends_.emplace(penalised_, *statistics_.account);
  ends_->ask_for(end_entries_);
  sampled_.resize(end_entries_.size());
}

void Run::measure_from_obstacle(std::size_t closing) {
  if (distance_.follows(closing) || measured_[closing] || penalised_.contacts()[closing].joint > 0) return;
  for (std::size_t c = 0; c < contacts(); ++c) {
    const Contact &one = penalised_.contacts()[c], &other = penalised_.contacts()[closing];
    if (one.where != other.where || one.sign != other.sign) continue;
    measured_[c] = 1;
    displacement_of(node(c)) += propagators_.origin()[node(c)] + one.sign * one.gap;
    propagators_.measure_from_obstacle(c);
  }
}

void Run::begin_leg() {
  propagator_ = &propagators_.present();
  if (ends_) ends_->measure_from(entries(propagators_.origin()));
  level_ = wait_ = 0;
}

bool Run::advance() {
  if (t_ >= piece_end_) {
    const double before = energy_of_followers();
    enter_piece();
    if (statistics_.energy) statistics_.energy->work += energy_of_followers() - before;
    pass_kink();
    settle_high_modes(false);
  }
  const Index count = leg().displacements();
  const auto origin = propagators_.origin().segment(static_cast<Index>(first_displacement()), count);
  largest_displacement_ = std::max(largest_displacement_, (y_.head(count) + origin).cwiseAbs().maxCoeff());
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
  const double massless = system_.inertia().has_massless() ? system_.mesh().spacing() / system_.bar().modulus : 0.0;
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
      motion.push_back(propagator_->expand(y, p[k], tau, system_.has_end_rows() || distance_.lets_go() ? 2 : 1));
    }
    if (k < pieces) propagator_->advance(level_ - halvings, y, rescaled(p_, at, 1.0 / pieces));
  }
  if (contacts() > 0) ++statistics_.event_evaluations;
  double penetration = statistics_.max_penetration;
  for (std::size_t c = 0; c < contacts(); ++c)
    if (penalised_.contacts()[c].moves ? !distance_.stays_away(c, motion, p, t_, tau, run_length(), largest())
                                       : !distance_.keeps_state(c, motion, p, tau, largest(), penetration))
      return false;
  if (ends_) {
    const auto sample = [&](std::size_t k, double) { return end_sample(motion[k], 0.0, tau); };
    ends_->look_at(t_, t_ + tau, pieces, sample, no_rates);
    ends_->look_at_joints(t_, t_ + tau, pieces, sample);
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
  std::vector<std::optional<ContactDistance::Push>> pushes(contacts());
  // A bar that has stood at the origin has the size of this step's motion: the load's polynomial has roundings, too.
  ContactDistance::Largest known = largest();
  if (contacts() > 0) {
    ++statistics_.event_evaluations;
    known.displacement =
        std::max(known.displacement, (leg().displacement(series, 1.0) + propagators_.origin()).cwiseAbs().maxCoeff());
  }
  for (std::size_t c = 0; c < contacts(); ++c) {
    distances.push_back(distance_.along(c, series, p_));
    if (penalised_.contacts().closed(c))
      known.penetration = std::max(known.penetration, std::abs(value(distances[c], 1.0)));
  }
  for (std::size_t c = 0; c < contacts(); ++c) {
    const Contact& contact = penalised_.contacts()[c];
    const auto clearance = [&](double at) {
      return value(distances[c], (at - t_) / tau) + (system_.frame().gap(contact, at) - contact.gap);
    };
    if (penalised_.contacts()[c].moves) {
      if (may_reach_within(run_length(), clearance, breaks_of_gap(system_, contact), distance_.band(c, known), t_,
                           t_ + tau))
        return follow(series, tau);
      continue;
    }
    pushes[c] = distance_.push(c, distances[c], tau, known);
    const std::optional<double> passage = pushes[c] ? first_passage(pushes[c]->along, pushes[c]->band)
                                                    : first_passage(distances[c], distance_.band(c, known));
    if (passage && *passage <= sigma && (!changing || *passage < sigma)) sigma = *passage, changing = c;
    if (!pushes[c] || penalised_.contacts().closed(c)) continue;
    // The step ends where the node leaves the stop that has let it go.
    const std::optional<double> leaves = first_passage(-distances[c], 0.0);
    if (leaves && *leaves < sigma) sigma = *leaves, changing.reset();
  }
  const double t = t_ + tau * sigma;
  output_until(t, tau, [&](double at) {
    return energy_flows() ? gauss_flow(leg(), series, load_.total(p_), tau, at, frame_flow(tau)) : EnergyFlow{};
  });
  for (std::size_t c = 0; c < contacts(); ++c)
    if (penalised_.contacts().closed(c))
      statistics_.max_penetration =
          std::max(statistics_.max_penetration, distance_.penetration_share(c) * largest_value(distances[c], sigma));
  if (energy_flows()) add(gauss_flow(leg(), series, load_.total(p_), tau, sigma, frame_flow(tau)));
  if (ends_) {
    // A series of that degree is the motion to rounding, since (rate bound) * step <= 1.
    const auto sample = [&](std::size_t, double at) { return end_sample(series, (at - t_) / tau, tau); };
    ends_->look_at(t_, t, Bernstein::max_degree, sample, no_rates);
    ends_->look_at_joints(t_, t, Bernstein::max_degree, sample);
    ends_->add();
  }
  const VectorXd u = leg().displacement(series, sigma), v = leg().velocity(series, sigma, tau);
  y_ = leg().pack(u, v);
  t_ = t;
  if (!changing) return lengthen();
  if (ends_) ends_->begin(t_, entries(u), entries(v));
  change_contacts(*changing, distances, pushes, sigma, v);
}

void Run::follow(const Series& series, double tau) {
  output_until(t_, tau, [](double) { return EnergyFlow{}; });  // in the frame that ends here
  VectorXd u = leg().displacement(series, 0.0) + propagators_.origin(), v = leg().velocity(series, 0.0, tau);
  const auto all = [](VectorXd& x) { return std::span(x.data(), static_cast<std::size_t>(x.size())); };
  const double after = t_ + 64.0 * rounding * std::max(std::abs(t_), times_.back());
  const double gained = change_frame(penalised_, system_.following(), after, all(u), all(v));
  u -= propagators_.origin();
  if (statistics_.energy) statistics_.energy->work -= gained;
  if (ends_) ends_->enter_frame(entries(u), entries(v));
  y_ = leg().pack(u, v);
  entered_ = Checkpoint{t_, next_output_, reached(), archived(*this), Checkpoint::Frame::entered};
}

void Run::change_contacts(std::size_t first, const std::vector<VectorXd>& distances,
                          const std::vector<std::optional<ContactDistance::Push>>& pushes, double sigma,
                          const VectorXd& v) {
  std::vector<std::size_t> changing;
  for (std::size_t c = 0; c < contacts(); ++c) {
    if (penalised_.contacts()[c].moves) continue;
    const double away = sign(c) * penalised_.contacts()[c].of(entries(v));
    const bool leaving = penalised_.contacts().closed(c) ? away > 0.0 : away < 0.0;
    const bool changes =
        pushes[c] ? slope(pushes[c]->along, sigma) < 0.0 && std::abs(value(pushes[c]->along, sigma)) <= pushes[c]->band
                  : leaving && std::abs(value(distances[c], sigma)) <= distance_.band(c, largest());
    if (c == first || changes) changing.push_back(c);
  }
  const double before = energy_of_followers();
  for (const std::size_t c : changing) {
    if (pushes[c] && statistics_.energy) {  // the energy of the spring goes as it lets go
      const double out = penalised_.contacts().closed(c) ? 1.0 : -1.0;
      add({.dissipated = out * penalised_.contacts()[c].law.stop()->energy(out * value(distances[c], sigma))});
    }
    penalised_.contacts().set_closed(c, !penalised_.contacts().closed(c));
    if (penalised_.contacts().closed(c)) measure_from_obstacle(c);
    if (!distance_.follows(c) && !pushes[c])
      displacement_of(node(c)) = propagators_.surface(c) +  // to the digits that only the new leg needs
                                 (penalised_.contacts()[c].joint > 0 ? displacement_of(node(c) - 1) : 0.0);
    tell_change(c, penalised_.contacts()[c].of(entries(v)));
  }
  begin_leg();
  if (statistics_.energy) statistics_.energy->work += energy_of_followers() - before;
}

void Run::tell_change(std::size_t c, double velocity) {
  watchdog_.change(t_, c);
  if (system_.frame().moving())
    velocity += system_.frame().lift_at(penalised_.contacts()[c], penalised_.load().lift(t_, 1));
  notifier_.event(t_, system_.unknowns().first_node(), penalised_.contacts()[c],
                  penalised_.contacts().closed(c) ? Change::closing : Change::opening, velocity);
}

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
  std::vector<VectorXd> displacements, velocities, loads, accelerations;
  for (std::size_t k = 0; k < motion.size(); ++k) {
    if (system_.frame().moving() || system_.side()) displacements.push_back(motion[k].col(0));
    velocities.push_back(motion[k].col(1) / tau);
    if (system_.loaded()) loads.push_back(load_.total(p[k]).col(0));
    if (system_.has_end_rows()) accelerations.push_back(motion[k].col(2) * (2.0 / (tau * tau)));
  }
  SampledFlow sampled = sampled_flow(leg(), displacements, velocities, loads, accelerations, tau, frame_flow(tau));
  const EnergyFlow& flow = sampled.flow;
  // As a bar at rest sets in motion, its energy is so small that a share of it would be below the flow's own
  // rounding.
  const double share = 1e-12 * energy_scale_ * tau / (times_.back() - times_.front());
  const double known = 64.0 * rounding *
                           (std::abs(flow.dissipated) + std::abs(flow.work) + std::abs(flow.end_inertia) +
                            distance_.cancelled_power(penetration) * tau) +
                       end_power_rounding(velocities) * tau;
  if (sampled.error > std::max({share, known, std::numeric_limits<double>::min()})) return std::nullopt;
  return sampled;
}

FrameFlow Run::frame_flow(double tau) const {
  if (!system_.frame().moving() && !system_.side()) return {};
  return [this, tau](double sigma, const VectorXd& u, const VectorXd& v, const VectorXd& a) {
    const double t = t_ + sigma * tau, loss = frame_loss(penalised_.bar(), t, entries(v));
    const bool moves = system_.frame().moving() && system_.has_end_rows();
    const VectorXd placed = u + propagators_.origin();
    const double end = moves ? end_power(penalised_, t, entries(placed), entries(v), entries(a)).of_frame : 0.0;
    return EnergyFlow{loss, loss + end, end + leg().side_power(v, u)};
  };
}

double Run::end_power_rounding(const std::vector<VectorXd>& velocities) const {
  if (!system_.has_end_rows()) return 0.0;
  double fastest = 0.0, gained = 0.0;
  for (const VectorXd& v : velocities) {
    fastest = std::max(fastest, v.cwiseAbs().maxCoeff());
    gained = std::max(gained, (v - velocities[0]).cwiseAbs().maxCoeff());
  }
  const Bar& bar = system_.bar();
  return 4.0 / 3.0 * gained * bar.density * propagators_.inverse_inertia() * rounding *
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
        statistics_.energy ? frame_energy(penalised_, times_[next_output_], entries(u), entries(v)) : 0.0;
    if (last && statistics_.energy) {
      statistics_.energy->final = energy(penalised_.contacts(), entries(u), entries(v)) + of_frame;
      statistics_.energy->work += of_frame;
    }
    if (!observers_.snapshot) continue;
    std::optional<EnergyState> energy;
    if (statistics_.energy) {
      const EnergyFlow flow = flow_until((times_[next_output_] - t_) / tau);
      energy = EnergyState{.dissipated = statistics_.energy->dissipated + flow.dissipated + flow.end_inertia,
                           .work = statistics_.energy->work + flow.work + (last ? 0.0 : of_frame),
                           .end_inertia = statistics_.energy->end_inertia + flow.end_inertia};
    }
    tell_snapshot(times_[next_output_], u, v, series, p, s / width, energy);
  }
}

void Run::tell_snapshot(double t, const VectorXd& u, const VectorXd& v, const Series& series, const LoadPolynomial& p,
                        double sigma, const std::optional<EnergyState>& energy) {
  Snapshot snapshot = snapshot_(t, entries(u), entries(v));
  if (energy) snapshot.energy = snapshot_.energy(snapshot, entries(u), *energy);
  // Again from the penetration itself, which has more digits than the displacement.
  const auto reaction = [&](Index end) {
    double sum = 0.0;
    for (std::size_t c = 0; c < contacts(); ++c) {
      if (!penalised_.contacts().closed(c) || penalised_.contacts()[c].joint > 0 || node(c) != end) continue;
      const double force = penalised_.contacts()[c].law.linear().reaction(
          distance_.penetration_share(c) * value(distance_.along(c, series, p), sigma), -sign(c) * v[end]);
      sum += sign(c) * (penalised_.contacts()[c].law.stop() ? std::max(force, 0.0) : force);
    }
    return sum;
  };
  if (!system_.unknowns().left_fixed()) snapshot.reaction_left = reaction(0);
  if (!system_.unknowns().right_fixed()) snapshot.reaction_right = reaction(v.size() - 1);
  notifier_.snapshot(snapshot);
}

bool Run::energy_flows() const {
  return statistics_.energy && (takes_energy(penalised_.contacts()) || system_.loaded() || system_.has_end_rows());
}

void Run::add(const EnergyFlow& flow) {
  statistics_.energy->dissipated += flow.dissipated + flow.end_inertia;
  statistics_.energy->work += flow.work;
  statistics_.energy->end_inertia += flow.end_inertia;
  statistics_.energy->notice(statistics_.energy->dissipated, statistics_.energy->work);
  energy_scale_ = std::max(energy_scale_, statistics_.energy->initial + std::abs(statistics_.energy->work));
}

}  // namespace viscobar::exponential
