#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "dynamics/jumps/jump_filter.hpp"
#include "dynamics/natural_scales.hpp"
#include "dynamics/obstacle_motion.hpp"
#include "integration/events/approach.hpp"
#include "integration/exponential/books.hpp"
#include "run/framed_parts.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

namespace exponential {

namespace {

/// A run of the exponential method, leg by leg; on a leg no contact changes. A leg begins with steps that one Taylor
/// series covers. They double as long as they resolve the load, a contact change, the energy flow, and a new maximum of
/// the penetration. Where a step may hide one of these, shorter steps look for it, in the end those of the series,
/// which hides nothing.
class Run : Books {
 public:
  Run(const BarSystem& system, const StartingPoint& start, std::span<const double> times, const Penalty& penalty,
      const Observers& observers)
      : Books(system, start, times, penalty, observers), filter_(system), schedule_(observers, times, t_) {}

  PartEnd operator()(const StartingPoint& start) {
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

  /// Content of a checkpoint.
  static void members(auto& run, auto&& each) {
    each(std::span(run.y_.data(), static_cast<std::size_t>(run.y_.size())), run.penalised_.contacts(), run.watchdog_,
         run.load_, run.load_jumps_, run.largest_displacement_, run.energy_scale_);
    if (run.ends_) each(*run.ends_);
  }

 private:
  static constexpr int max_load_jumps = 1000;

  double shortest_step() const { return 4.0 * rounding * std::max(std::abs(t_), duration_); }

  // A piece of time, from here on, in which the load is smooth.
  void enter_piece() {
    piece_end_ = penalised_.load().begin_leg(t_, times_.back());
    load_.enter(t_, times_.back());
  }

  // Where what holds or bounds an end changes its velocity at once.
  void pass_kink() {
    const auto jump = system_.frame().kink(t_, times_.back());
    if (!jump) return;
    auto [u, w] = state();
    std::vector<double> change = w;
    const double before = energy(contacts(), u, w);
    system_.frame().pass_kink(*jump, u, w);
    for (std::size_t i = 0; i < w.size(); ++i) change[i] = w[i] - change[i];
    std::vector<std::size_t> left;
    if (jump->displaces()) left = left_by_jump(contacts(), *jump, t_, u, largest_displacement_);
    if (ends_ && !jump->displaces()) ends_->pass_kink(change);
    put(u, w);
    if (jump->displaces()) leave_obstacles(left, u, w);
    if (statistics_.energy) statistics_.energy->work += energy(contacts(), u, w) - before;
  }

  void leave_obstacles(const std::vector<std::size_t>& left, std::span<double> u, std::span<double> w) {
    if (ends_) {
      penalised_.complete_velocity(t_, u, w);
      ends_->enter_frame(u, w);
    }
    for (const std::size_t c : left) {
      contacts().set_closed(c, false);
      penalised_.complete_displacement(t_, u);
      penalised_.complete_velocity(t_, u, w);
      tell_change(c, contacts()[c].of(w));
    }
    begin_leg();
  }

  // Puts high modes at their equilibrium (see JumpFilter): at the start, or where the load breaks.
  void settle_high_modes(bool starting) {
    if (!filter_.acts()) return;
    for (std::size_t c = 0; c < contacts().size(); ++c)
      if (starting && contacts().closed(c)) return;
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

  void begin(const State& start) {
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
    for (std::size_t c = 0; c < contacts().size(); ++c) {
      if (!contacts().closed(c)) continue;
      statistics_.max_penetration = std::max(statistics_.max_penetration, -contacts().clearance(c, state.u));
      if (!distance_.follows(c)) contacts().measure(c, state.u);
      tell_change(c, contacts()[c].of(approach));
    }
    put(state.u, state.v);
    begin_leg();
    statistics_.unknowns = static_cast<std::size_t>(y_.size());
    if (observers_.energy) {
      energy_scale_ = energy(contacts(), state.u, state.v);
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

  void go_on(const Checkpoint& checkpoint) {
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

  void begin_leg() {
    Motion::begin_leg();
    if (ends_) ends_->measure_from(contacts().origin().values());
  }

  // True if it made a step; else the next one is to be shorter.
  bool advance() {
    if (t_ >= piece_end_) {
      as_work_on_followers([this] { enter_piece(); });
      pass_kink();
      settle_high_modes(false);
    }
    notice_displacement();
    const double remaining = std::min(schedule_.next().value_or(piece_end_), piece_end_) - t_;
    // A varying load that vanishes at all points of a long step could hide a pulse between them.
    const double longest = load_.varies() ? std::min(remaining, duration_ / 64) : remaining;
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

  // A step by matrix exponentials, unless it may hide something: it looks at quarters of the step for contacts, at
  // eighths for the energy flow and the motion of the ends.
  bool take_long_step(double tau) {
    const int halvings = energy_flows() || ends_ ? 3 : contacts().size() > 0 ? 2 : 0, pieces = 1 << halvings;
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
    if (contacts().size() > 0) ++statistics_.event_evaluations;
    double penetration = statistics_.max_penetration;
    for (std::size_t c = 0; c < contacts().size(); ++c)
      if (contacts()[c].moves ? !distance_.stays_away(c, motion, p, t_, tau, duration_, largest())
                              : !distance_.keeps_state(c, motion, p, tau, largest(), penetration))
        return false;
    if (ends_) {
      const auto sample = [&](std::size_t k, double) { return end_sample(motion[k], 0.0, tau); };
      ends_->look_at(t_, t_ + tau, pieces, sample, no_rates);
      ends_->look_at_joints(t_, t_ + tau, pieces, sample);
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

  // A step that one Taylor series covers, cut at the first contact change.
  void take_short_step(double tau) {
    const Series series = propagator_->expand(y_, p_, tau);
    double sigma = 1.0;
    std::optional<std::size_t> changing;
    std::vector<VectorXd> distances;
    std::vector<std::optional<ContactDistance::Push>> pushes(contacts().size());
    // A bar that has stood at the origin has the size of this step's motion: the load's polynomial has roundings, too.
    ContactDistance::Largest known = largest();
    if (contacts().size() > 0) {
      ++statistics_.event_evaluations;
      known.displacement = std::max(known.displacement,
                                    contacts().origin().largest_displacement(entries(leg().displacement(series, 1.0))));
    }
    for (std::size_t c = 0; c < contacts().size(); ++c) {
      distances.push_back(distance_.along(c, series, p_));
      if (contacts().closed(c)) known.penetration = std::max(known.penetration, std::abs(value(distances[c], 1.0)));
    }
    for (std::size_t c = 0; c < contacts().size(); ++c) {
      const Contact& contact = contacts()[c];
      const auto clearance = [&](double at) {
        return value(distances[c], (at - t_) / tau) + (system_.frame().gap(contact, at) - contact.gap);
      };
      if (contacts()[c].moves) {
        if (may_reach_within(duration_, clearance, breaks_of_gap(system_, contact), distance_.band(c, known), t_,
                             t_ + tau))
          return follow(series, tau);
        continue;
      }
      pushes[c] = distance_.push(c, distances[c], tau, known);
      const std::optional<double> passage = pushes[c] ? first_passage(pushes[c]->along, pushes[c]->band)
                                                      : first_passage(distances[c], distance_.band(c, known));
      if (passage && *passage <= sigma && (!changing || *passage < sigma)) sigma = *passage, changing = c;
      if (!pushes[c] || contacts().closed(c)) continue;
      // The step ends where the node leaves the stop that has let it go.
      const std::optional<double> leaves = first_passage(-distances[c], 0.0);
      if (leaves && *leaves < sigma) sigma = *leaves, changing.reset();
    }
    const double t = t_ + tau * sigma;
    const auto flow_until = [&](double at) {
      return energy_flows() ? gauss_flow(power(series, tau), series, at) : EnergyFlow{};
    };
    output_until(t, tau, flow_until);
    for (std::size_t c = 0; c < contacts().size(); ++c)
      if (contacts().closed(c))
        statistics_.max_penetration =
            std::max(statistics_.max_penetration, distance_.penetration_share(c) * largest_value(distances[c], sigma));
    if (energy_flows()) add(flow_until(sigma));
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

  // The bar may come to an obstacle that moves in this step: from its beginning on the frame follows it. A kink there
  // has been passed.
  void follow(const Series& series, double tau) {
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

  // Contact `first` reaches its change; so do those that are at theirs up to rounding and go on.
  void change_contacts(std::size_t first, const std::vector<VectorXd>& distances,
                       const std::vector<std::optional<ContactDistance::Push>>& pushes, double sigma,
                       const VectorXd& v) {
    std::vector<std::size_t> changing;
    for (std::size_t c = 0; c < contacts().size(); ++c) {
      if (contacts()[c].moves) continue;
      const double away = sign(c) * contacts()[c].of(entries(v));
      const bool leaving = contacts().closed(c) ? away > 0.0 : away < 0.0;
      const bool changes = pushes[c] ? slope(pushes[c]->along, sigma) < 0.0 &&
                                           std::abs(value(pushes[c]->along, sigma)) <= pushes[c]->band
                                     : leaving && std::abs(value(distances[c], sigma)) <= distance_.band(c, largest());
      if (c == first || changes) changing.push_back(c);
    }
    as_work_on_followers([&] {
      for (const std::size_t c : changing) {
        if (pushes[c] && statistics_.energy) {  // the energy of the spring goes as it lets go
          const double out = contacts().closed(c) ? 1.0 : -1.0;
          add({.dissipated = out * contacts()[c].law.stop()->energy(out * value(distances[c], sigma))});
        }
        contacts().set_closed(c, !contacts().closed(c));
        if (contacts().closed(c)) measure_from_obstacle(c);
        if (!distance_.follows(c) && !pushes[c])
          displacement_of(node(c)) = contacts().surface(c) +  // to the digits that only the new leg needs
                                     (contacts()[c].joint > 0 ? displacement_of(node(c) - 1) : 0.0);
        tell_change(c, contacts()[c].of(entries(v)));
      }
      begin_leg();
    });
  }

  // Over a long step; absent where the step may hide some of it.
  std::optional<SampledFlow> resolved_flow(const std::vector<Series>& motion, double tau, double penetration) const {
    SampledFlow sampled = sampled_flow(power(motion.front(), tau), motion);
    const EnergyFlow& flow = sampled.flow;
    // As a bar at rest sets in motion, its energy is so small that a share of it would be below the flow's own
    // rounding.
    const double share = 1e-12 * energy_scale_ * tau / duration_;
    const double known = 64.0 * rounding *
                             (std::abs(flow.dissipated) + std::abs(flow.work) + std::abs(flow.end_inertia) +
                              distance_.cancelled_power(penetration) * tau) +
                         end_power_rounding(motion, tau) * tau;
    if (sampled.error > std::max({share, known, std::numeric_limits<double>::min()})) return std::nullopt;
    return sampled;
  }

  // Rounding error of the power of the end rows: the row (rho h / 24) (3, 4, 1) times accelerations, by forces
  // that are differences of rounded displacements and velocities, times what the step has changed velocities by.
  double end_power_rounding(const std::vector<Series>& motion, double tau) const {
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

  JumpFilter filter_;
  CheckpointSchedule schedule_;
  std::optional<Checkpoint> entered_;  // of a frame that the next part is in
  double piece_end_ = 0.0;             // of the piece in which the load is smooth
  int load_jumps_ = 0;
};

}  // namespace

}  // namespace exponential

Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Exponential& method, const Observers& observers) {
  refuse_directions("exponential", observers);
  if (const auto law = law_refusal("exponential", system.inputs()[0], system.inputs()[1], true))
    throw Unfit("exponential", *law);
  if (system.size() > Exponential::most_unknowns)
    throw Unfit("exponential", {"mesh.elements", "its matrices are dense, and the unknown nodes are too many"});
  const auto has_penalty = [&](const Contact& contact) { return !system.stop(contact); };
  if (std::ranges::any_of(system.contacts(), has_penalty) && !(method.penalty.epsilon > 0.0))
    throw Unfit("exponential", {"contact.epsilon", "must be positive"});
  return run_in_parts(system, start, times, observers, [&](const BarSystem& bar, const StartingPoint& from) {
    return exponential::Run(bar, from, times, method.penalty, observers)(from);
  });
}

}  // namespace viscobar
