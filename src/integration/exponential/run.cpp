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
    State now = state();
    penalised_.complete_velocity(t_, now.u, now.v);
    finish_energy(t_, now.u, now.v);
  } catch (const std::exception&) {  // the cause of the failure may stop this, too
  }
}

void Run::finish_energy(double t, std::span<const double> u, std::span<const double> w) {
  const double of_frame = frame_energy(penalised_, t, u, w);
  statistics_.energy->final = energy(penalised_.contacts(), u, w) + of_frame;
  statistics_.energy->work += of_frame;
}

// Undamped nodes without mass follow their rows at once. Where a load jumps, or opens or closes their contact by that,
// the energy that it gives them is its work.
void Run::as_work_on_followers(auto&& change) {
  const bool follow = statistics_.energy && system_.inertia().has_massless() && !system_.bar().damped();
  const std::vector<double> still(system_.size());
  const auto stored = [&] { return follow ? energy(penalised_.contacts(), state().u, still) : 0.0; };
  const double before = stored();
  change();
  if (follow) statistics_.energy->work += stored() - before;
}

void Run::enter_piece() {
  piece_end_ = penalised_.load().begin_leg(t_, times_.back());
  load_.enter(t_, times_.back());
}

void Run::pass_kink() {
  const auto jump = system_.frame().kink(t_, times_.back());
  if (!jump) return;
  auto [u, w] = state();
  std::vector<double> change = w;
  const double before = energy(penalised_.contacts(), u, w);
  system_.frame().pass_kink(*jump, u, w);
  for (std::size_t i = 0; i < w.size(); ++i) change[i] = w[i] - change[i];
  std::vector<std::size_t> left;
  if (jump->displaces()) left = left_by_jump(penalised_.contacts(), *jump, t_, u, largest_displacement_);
  if (ends_ && !jump->displaces()) ends_->pass_kink(change);
  put(u, w);
  if (jump->displaces()) leave_obstacles(left, u, w);
  if (statistics_.energy) statistics_.energy->work += energy(penalised_.contacts(), u, w) - before;
}

void Run::leave_obstacles(const std::vector<std::size_t>& left, std::span<double> u, std::span<double> w) {
  if (ends_) {
    penalised_.complete_velocity(t_, u, w);
    ends_->enter_frame(u, w);
  }
  for (const std::size_t c : left) {
    penalised_.contacts().set_closed(c, false);
    penalised_.complete_displacement(t_, u);
    penalised_.complete_velocity(t_, u, w);
    tell_change(c, penalised_.contacts()[c].of(w));
  }
  begin_leg();
}

State Run::unpacked() const {
  State all{std::vector<double>(system_.size()), std::vector<double>(system_.size())};
  const Index n = leg().displacements();
  std::copy_n(y_.data(), n, all.u.begin() + static_cast<std::ptrdiff_t>(first_displacement()));
  std::copy(y_.data() + n, y_.data() + y_.size(),
            all.v.begin() + static_cast<std::ptrdiff_t>(system_.inertia().massive_begin()));
  return all;
}

State Run::state() {
  State now = unpacked();
  penalised_.complete_displacement(t_, now.u);
  return now;
}

void Run::put(std::span<const double> u, std::span<const double> w) {
  const auto vector = [](std::span<const double> x) {
    return VectorXd(Eigen::Map<const VectorXd>(x.data(), static_cast<Index>(x.size())));
  };
  y_ = leg().pack(vector(u), vector(w));
}

void Run::settle_high_modes(bool starting) {
  if (!filter_.acts()) return;
  for (std::size_t c = 0; c < contacts(); ++c)
    if (starting && penalised_.contacts().closed(c)) return;
  const State before = state();
  auto [u, w] = before;
  JumpFilter::Taken taken;
  if (starting) {
    // The state is known to rounding.
    const NaturalScales scales = natural_scales(system_, times_.back());
    taken = filter_.begin(penalised_, t_, {1e-12 * scales.displacement, 1e-12 * scales.velocity()}, u, w);
  } else {
    taken = filter_.pass_break(penalised_, t_, times_.back(), u, w);
  }
  if (u == before.u && w == before.v) return;
  put(u, w);
  if (ends_) ends_->begin(t_, u, w);
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
  begin_leg();
  put(state.u, state.v);
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
  if (distance_.follows(closing)) return;
  State now = unpacked();
  penalised_.contacts().measure(closing, now.u);
  put(now.u, now.v);
}

void Run::begin_leg() {
  propagator_ = &propagators_.present();
  if (ends_) ends_->measure_from(penalised_.contacts().origin().values());
  level_ = wait_ = 0;
}

bool Run::advance() {
  if (t_ >= piece_end_) {
    as_work_on_followers([this] { enter_piece(); });
    pass_kink();
    settle_high_modes(false);
  }
  const std::span<const double> u(y_.data(), static_cast<std::size_t>(leg().displacements()));
  for (std::size_t k = 0; k < u.size(); ++k)
    largest_displacement_ =
        std::max(largest_displacement_, std::abs(u[k] + penalised_.contacts().origin().at(first_displacement() + k)));
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
    ends_->look_at(
        t_, t_ + tau, pieces, [&](std::size_t k, double) { return end_sample(motion[k], 0.0, tau); }, no_rates);
    if (!ends_->resolved()) return false;
  }
  std::optional<SampledFlow> flow;
  if (energy_flows() && !(flow = resolved_flow(motion, tau, penetration))) return false;
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
        std::max(known.displacement,
                 penalised_.contacts().origin().largest_displacement(entries(leg().displacement(series, 1.0))));
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
  const auto flow_until = [&](double at) {
    return energy_flows() ? gauss_flow(power(series, tau), series, at) : EnergyFlow{};
  };
  output_until(t, tau, flow_until);
  for (std::size_t c = 0; c < contacts(); ++c)
    if (penalised_.contacts().closed(c))
      statistics_.max_penetration =
          std::max(statistics_.max_penetration, distance_.penetration_share(c) * largest_value(distances[c], sigma));
  if (energy_flows()) add(flow_until(sigma));
  if (ends_) {
    // A series of that degree is the motion to rounding, since (rate bound) * step <= 1.
    ends_->look_at(
        t_, t, Bernstein::max_degree, [&](std::size_t, double at) { return end_sample(series, (at - t_) / tau, tau); },
        no_rates);
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
  VectorXd u = leg().displacement(series, 0.0), v = leg().velocity(series, 0.0, tau);
  const auto all = [](VectorXd& x) { return std::span(x.data(), static_cast<std::size_t>(x.size())); };
  const double after = t_ + 64.0 * rounding * std::max(std::abs(t_), times_.back());
  const double gained = change_frame(penalised_, system_.following(), after, all(u), all(v));
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
  as_work_on_followers([&] {
    for (const std::size_t c : changing) {
      if (pushes[c] && statistics_.energy) {  // the energy of the spring goes as it lets go
        const double out = penalised_.contacts().closed(c) ? 1.0 : -1.0;
        add({.dissipated = out * penalised_.contacts()[c].law.stop()->energy(out * value(distances[c], sigma))});
      }
      penalised_.contacts().set_closed(c, !penalised_.contacts().closed(c));
      if (penalised_.contacts().closed(c)) measure_from_obstacle(c);
      if (!distance_.follows(c) && !pushes[c])
        displacement_of(node(c)) = penalised_.contacts().surface(c) +  // to the digits that only the new leg needs
                                   (penalised_.contacts()[c].joint > 0 ? displacement_of(node(c) - 1) : 0.0);
      tell_change(c, penalised_.contacts()[c].of(entries(v)));
    }
    begin_leg();
  });
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

std::optional<SampledFlow> Run::resolved_flow(const std::vector<Series>& motion, double tau, double penetration) const {
  SampledFlow sampled = sampled_flow(power(motion.front(), tau), motion);
  const EnergyFlow& flow = sampled.flow;
  // As a bar at rest sets in motion, its energy is so small that a share of it would be below the flow's own
  // rounding.
  const double share = 1e-12 * energy_scale_ * tau / (times_.back() - times_.front());
  const double known = 64.0 * rounding *
                           (std::abs(flow.dissipated) + std::abs(flow.work) + std::abs(flow.end_inertia) +
                            distance_.cancelled_power(penetration) * tau) +
                       end_power_rounding(motion, tau) * tau;
  if (sampled.error > std::max({share, known, std::numeric_limits<double>::min()})) return std::nullopt;
  return sampled;
}

double Run::end_power_rounding(const std::vector<Series>& motion, double tau) const {
  if (!system_.has_end_rows()) return 0.0;
  double fastest = 0.0, gained = 0.0;
  for (const Series& one : motion) {
    fastest = std::max(fastest, one.col(1).cwiseAbs().maxCoeff() / tau);
    gained = std::max(gained, (one.col(1) - motion[0].col(1)).cwiseAbs().maxCoeff() / tau);
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
    const VectorXd u = leg().displacement(series, s / width), v = leg().velocity(series, s / width, width);
    double of_frame = 0.0;
    if (last && statistics_.energy)
      finish_energy(times_[next_output_], entries(u), entries(v));
    else if (statistics_.energy)
      of_frame = frame_energy(penalised_, times_[next_output_], entries(u), entries(v));
    if (!observers_.snapshot) continue;
    std::optional<EnergyState> energy;
    if (statistics_.energy) {
      const EnergyFlow flow = flow_until((times_[next_output_] - t_) / tau);
      energy = EnergyState{.dissipated = statistics_.energy->dissipated + flow.dissipated + flow.end_inertia,
                           .work = statistics_.energy->work + flow.work + of_frame,
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
