#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "discretisation/not_positive.hpp"
#include "dynamics/jumps/jump_filter.hpp"
#include "dynamics/lost_inertia.hpp"
#include "dynamics/obstacle_motion.hpp"
#include "run/notifier.hpp"
#include "run/parts.hpp"
#include "scene/times.hpp"
#include "schemes/settled_start.hpp"
#include "schemes/step_energy.hpp"
#include "schemes/step_reactions.hpp"
#include "schemes/step_snapshot.hpp"
#include "schemes/time_step.hpp"

namespace viscobar {

namespace {

void check(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
           const FullyDiscrete& scheme) {
  if (!(scheme.step > 0.0 && std::isnormal(scheme.step * scheme.step)))
    throw std::invalid_argument(fmt::format("the step of a scheme must be positive, is {}", scheme.step));
  if (!(scheme.restitution >= 0.0 && scheme.restitution <= 1.0))
    throw std::invalid_argument(fmt::format("the restitution must lie in [0, 1], is {}", scheme.restitution));
  require_times(times);
  const auto* state = std::get_if<State>(&start);
  if (state && (state->u.size() != system.size() || state->v.size() != system.size()))
    throw std::invalid_argument("the initial state does not have the size of the system");
}

class Run {
 public:
  Run(const BarSystem& system, const StartingPoint& start, std::span<const double> times, const FullyDiscrete& scheme,
      const Observers& observers)
      : system_(system),
        start_(start),
        times_(times),
        scheme_(scheme),
        observers_(observers),
        statistics_(statistics_before(start)),
        notifier_(observers, statistics_),
        filter_(system) {
    const double steps = (times.back() - times.front()) / scheme.step;
    // An end that misses a step by rounding only is on it.
    steps_ = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(steps * (1.0 - 1e-12))));
    statistics_.unknowns = system.size();
    statistics_.reached_time = begin_of(start, times);
  }

  Statistics operator()() {
    try {
      const auto* checkpoint = std::get_if<Checkpoint>(&start_);
      State start = checkpoint ? system_.initial_state() : std::get<State>(start_);
      const JumpFilter::Taken taken = checkpoint ? JumpFilter::Taken{} : settle_start(start);
      step_.emplace(system_, start, times_.front(), scheme_, times_.back() + scheme_.step);
      energy_.emplace(system_, *step_, times_, scheme_.step);
      was_active_.assign(step_->contacts().size(), 0);
      may_penetrate_ = may_penetrate();
      active_ = step_->active();
      reactions_.emplace(system_, *step_, times_, scheme_.step, steps_);
      if (observers_.snapshot) snapshot_.emplace(system_, *step_, *reactions_, scheme_.step);
      if (checkpoint) {
        go_on(*checkpoint);
      } else {
        begin_accounts(std::get<State>(start_), taken);
        close_at_start(std::get<State>(start_));
      }
      statistics_.completed = advance_to_end();
    } catch (const LoadError& error) {
      fail(Failure::load, error.time, error.what());
    } catch (const NotPositive& error) {
      const double dt = scheme_.step;
      if (!error.finite) fail(Failure::overflow, times_.front(), "the matrix of a step is no longer finite");
      fail(Failure::inertia, times_.front(), lost_inertia(system_, 1.0, dt, dt * dt / 2));
    }
    close_account();
    return statistics_;
  }

  /// Content of a checkpoint, u^{n+1} being known and the outputs told up to t_n.
  static void members(auto& run, auto&& each) {
    each(run.n_, *run.step_, std::span(run.was_active_), run.largest_, *run.energy_);
  }

 private:
  double time(std::size_t n) const { return times_.front() + static_cast<double>(n) * scheme_.step; }

  void go_on(const Checkpoint& checkpoint) {
    restore(*this, checkpoint, times_, observers_);
    step_->restored();
    written_ = checkpoint.outputs;
    if (filter_.acts()) {
      watch_breaks(time(n_) - ahead());
      while (next_break_ <= time(n_) + ahead() && next_break_ < times_.back()) enter_break(time(n_));
    }
    pass_breaks();
    step_->balance(time(++n_));
  }

  void watch_breaks(double t) {
    if (!settled_) settled_.emplace(system_, Penalty{0.0, 0.0});
    next_break_ = settled_->load().begin_leg(t, times_.back());
  }

  JumpFilter::Taken settle_start(State& start) {
    if (!filter_.acts()) return {};
    watch_breaks(times_.front());
    return settle_high_modes(filter_, *settled_, times_.front(), times_.back(), start);
  }

  // A load that breaks within half a step of t_n is there its mean, and has jumped by a share of the whole.
  double ahead() const { return system_.frame().moving() ? 0.0 : scheme_.step / 2; }

  // The next break, a share of which is in the load at t: the rest is passed with the next step.
  double enter_break(double t) {
    const double share = ahead() == 0.0 ? 1.0 : std::clamp((t + ahead() - next_break_) / scheme_.step, 0.0, 1.0);
    if (share < 1.0) begun_.push_back({next_break_, 1.0 - share});
    next_break_ = settled_->load().begin_leg(next_break_, times_.back());
    return share;
  }

  // Passes those of the load at t_{n+1}, u^{n+1} being known. Most steps have none. The loop asks for that itself: at
  // few nodes a call costs as much as the arithmetic.
  [[gnu::always_inline]] void pass_breaks() {
    if (next_break_ < std::numeric_limits<double>::infinity() || !begun_.empty()) pass_breaks_before();
  }

  [[gnu::noinline]] void pass_breaks_before() {
    const double t = time(n_ + 1);
    if (begun_.empty() && next_break_ > t + ahead()) return;
    for (const auto& [at, share] : std::exchange(begun_, {})) pass_break(at, share);
    while (next_break_ <= t + ahead() && next_break_ < times_.back()) {
      const double at = next_break_;
      pass_break(at, enter_break(t));
    }
  }

  void pass_break(double t, double share) {
    const auto& contacts = step_->contacts();
    Contacts& settled = settled_->contacts();
    for (std::size_t i = 0; i < settled.size(); ++i) {
      bool held = false;
      for (std::size_t k = 0; k < contacts.size(); ++k)
        held |= active_[k] && contacts[k].unknown == settled[i].unknown && contacts[k].sign == settled[i].sign;
      settled.set_closed(i, held);
    }
    std::vector<double> u(system_.size()), p(u);
    step_->order().to_nodes([&](std::size_t i) { return step_->u()[i]; }, u);
    step_->order().to_nodes([&](std::size_t i) { return step_->p()[i]; }, p);
    const std::vector<double> u_before = u, p_before = p;
    const double before = statistics_.energy ? energy_->energy() : 0.0;
    const JumpFilter::Taken taken = filter_.pass_break(*settled_, t, times_.back(), u, p);
    for (std::size_t i = 0; i < u.size(); ++i) {
      u[i] = u_before[i] + share * (u[i] - u_before[i]);
      p[i] = p_before[i] + share * (p[i] - p_before[i]);
    }
    step_->put(u, p);
    if (!statistics_.energy) return;
    const double work = share * taken.work;
    statistics_.energy->work += work;
    statistics_.energy->take_by_rows(before + work - energy_->energy());
  }

  // True if it comes there.
  bool advance_to_end() {
    TimeStep& step = *step_;
    CheckpointSchedule schedule(observers_, times_, statistics_.reached_time);
    for (;; ++n_) {
      const std::size_t n = n_;
      if (!step.finite()) fail(Failure::overflow, time(n), "the displacement is no longer finite");
      const double reached = n < steps_ ? time(n) : times_.back();
      statistics_.steps = statistics_.rhs_evaluations = n;
      statistics_.reached_time = reached;
      if (statistics_.account) reactions_->pass(n, *statistics_.account);
      if (observers_.snapshot && written_ < times_.size() && (times_[written_] <= reached || n == steps_))
        write_until(n);
      if (!notifier_.progress(reached)) return false;
      if (n == steps_) return true;
      const bool due = schedule.due(reached);
      if (!was_active_.empty()) find_events(n);
      step.advance();
      if (observers_.energy) energy_->account(n, *statistics_.energy);
      measure_penetration();
      if (due) {
        if (!take_checkpoint(reached)) return false;
        schedule = {observers_, times_, reached};
      }
      pass_breaks();
      refuse_jumps(time(n + 1));
      step.balance(time(n + 1));
    }
  }

  void begin_accounts(const State& start, const JumpFilter::Taken& taken) {
    if (observers_.energy) {
      const double of_frame = energy_->of_frame(time(1));
      // E^{1/2} is of the motion after what the start takes at once.
      const bool struck =
          !system_.frame().moving() && std::ranges::any_of(step_->start_impulse(), [](double of) { return of > 0.0; });
      const double at_start =
          struck ? std::max(system_.energy(start.u, start.v), energy_->energy()) : energy_->energy();
      const double dissipated = taken.energy + at_start - energy_->energy();
      statistics_.energy = EnergyAccount{.initial = at_start + of_frame + taken.energy - taken.work,
                                         .dissipated = dissipated,
                                         .work = taken.work - of_frame,
                                         .end_inertia = taken.energy};
    }
    if (!observers_.account) return;
    reactions_->begin(start, statistics_.account.emplace());
  }

  // A node that moves in closes its contact where the data touch, at t_0, or else where u^1 does.
  void close_at_start(const State& start) {
    const double slow = velocity_rounding(start.v);
    for (const std::size_t n : {0, 1})  // in the order of time
      for (std::size_t k = 0; k < was_active_.size(); ++k) {
        const Contact& contact = step_->contacts()[k];
        const double velocity = contact.of(start.v);
        const double u = n == 0 ? contact.of(start.u) : step_->stored_contacts()[k].of(step_->u());
        if (was_active_[k] || step_->clearance(k, time(n), u) > 0.0) continue;
        if (!(contact.sign * velocity + (gap(k, 1) - gap(k, 0)) / scheme_.step < -slow)) continue;
        was_active_[k] = 1;
        tell(time(n), k, Change::closing, velocity);
      }
  }

  double gap(std::size_t k, std::size_t n) const { return system_.frame().gap(step_->contacts()[k], time(n)); }

  // Throws LoadError if an obstacle jumps into the bar before the end of the step that begins at t.
  void refuse_jumps(double t) {
    if (!step_->obstacles_move()) return;
    for (const Contact& contact : step_->contacts()) {
      if (!system_.frame().moves(contact) || !breaks_of_gap(system_, contact)) continue;
      const NextBreak& next = breaks_of_gap(system_, contact);
      const double until = t + scheme_.step * (1.0 + 1e-9);
      const double apart = rounding_of_times(0.0, times_.back());
      for (auto at = next(t, until); at; at = next(*at + apart, until)) {
        const double jump = system_.frame().gap_jump(contact, *at, times_.back());
        if (jump < 0.0 && contact.sign * step_->u()[step_->order().place(contact.unknown)] +
                                  system_.frame().gap(contact, *at + apart) <
                              0.0)
          throw LoadError(*at, into_the_bar(contact, *at));
      }
    }
  }

  // The output times in (t_{n-1}, t_n].
  void write_until(std::size_t n) {
    if (written_ == 0) write(snapshot_->at_start(times_.front(), std::get<State>(start_)));
    while (written_ < times_.size() && (times_[written_] <= time(n) || n == steps_)) {
      const double t = times_[written_];
      write(snapshot_->between(t, std::min((t - time(n - 1)) / scheme_.step, 1.0), n == 1));
    }
  }

  void write(Snapshot&& snapshot) {
    ++written_;
    if (observers_.energy) {
      const double now = time(n_);
      snapshot.energy = energy_->parts(now);
      snapshot.energy->dissipated = statistics_.energy->dissipated;
      snapshot.energy->work = statistics_.energy->work + energy_->of_frame(now);
      snapshot.energy->end_inertia = statistics_.energy->end_inertia;
    }
    notifier_.snapshot(snapshot);
  }

  // u^{n+1} is known now. A contact closes at the first t_{n+1} that it holds, with the velocity before, and opens at
  // the last one, with the velocity after; the openings of a step are earlier than its closings.
  [[gnu::always_inline]] void find_events(std::size_t n) {
    ++statistics_.event_evaluations;
    for (std::size_t k = 0, count = active_.size(); k < count; ++k)
      if (active_[k] != was_active_[k]) return tell_changes(n);
  }

  [[gnu::noinline]] void tell_changes(std::size_t n) {
    const auto& contacts = step_->contacts();
    const auto& stored = step_->stored_contacts();
    const double dt = scheme_.step;
    const auto mass = [&](std::size_t k) {
      return system_.bar().density * system_.elements().stretch_beside(contacts[k].unknown) / 2.0;
    };
    // A closing is more than rounding: it pushes its node, or its node has moved in.
    const auto closes = [&](std::size_t k) {
      constexpr double rounding = 64.0 * std::numeric_limits<double>::epsilon();
      return active_[k] && !was_active_[k] &&
             std::max(step_->reaction()[k], mass(k) * std::abs(stored[k].of(step_->p())) / dt) > rounding * largest_;
    };
    const auto opens = [&](std::size_t k) { return was_active_[k] && !active_[k]; };
    bool changes = false;
    for (std::size_t k = 0; k < contacts.size(); ++k) changes |= opens(k) || closes(k);
    if (!changes) return;  // one rests without a force
    const auto largest_of = [](std::span<const double> values) {
      double size = 0.0;
      for (const double value : values) size = std::max(size, std::abs(value));
      return size;
    };
    const double size = largest_of(step_->u());
    largest_ = std::max(largest_, largest_of(step_->load()));  // of a bar that is yet at rest all there is
    for (std::size_t k = 0; k < contacts.size(); ++k)
      largest_ = std::max({largest_, step_->reaction()[k], step_->reaction_before()[k], mass(k) * size / (dt * dt)});
    for (std::size_t k = 0; k < contacts.size(); ++k)
      if (opens(k)) {
        was_active_[k] = 0;
        tell(time(n), k, Change::opening, stored[k].of(step_->p()) + dt * stored[k].of(step_->acceleration()));
      }
    for (std::size_t k = 0; k < contacts.size(); ++k)
      if (closes(k)) {
        was_active_[k] = 1;
        tell(time(n + 1), k, Change::closing, stored[k].of(step_->p()));
      }
  }

  void tell(double t, std::size_t k, Change change, double velocity) {
    if (t > times_.back()) return;
    const Contact& contact = step_->contacts()[k];
    if (system_.frame().moving()) velocity += system_.frame().lift_at(contact, system_.frame().lift(t, 1));
    const std::size_t node = contact.joint > 0 ? contact.joint : contact.unknown + system_.unknowns().first_node();
    Event event{t, contact.where, node, change, velocity};
    count_change(statistics_, event);
    if (statistics_.account && change == Change::closing) reactions_->close(k, t, event, *statistics_.account);
    if (observers_.event) notifier_.told(event);
  }

  // With a restitution the constraint does not bound u^{n+1} alone, and at a joint to rounding. Else u^{n+1} is in K_h
  // to the last bit.
  bool may_penetrate() const {
    const auto at_joint = [](const Contact& contact) { return contact.joint > 0; };
    return scheme_.restitution > 0.0 || scheme_.impact != Impact::paoli_schatzman || step_->obstacles_move() ||
           std::ranges::any_of(step_->contacts(), at_joint);
  }

  void measure_penetration() {
    if (!may_penetrate_) return;
    const std::span<const double> u = step_->u();
    double deepest = statistics_.max_penetration;
    for (std::size_t k = 0, count = active_.size(); k < count; ++k)
      deepest = std::max(deepest, -step_->clearance(k, time(n_ + 1), step_->stored_contacts()[k].of(u)));
    statistics_.max_penetration = deepest;
  }

  bool take_checkpoint(double t) {
    count();
    const auto outputs = static_cast<std::size_t>(std::ranges::upper_bound(times_, t) - times_.begin());
    return notifier_.checkpoint({t, outputs, statistics_, archived(*this)});
  }

  void close_account() {
    count();
    if (!step_ || !statistics_.energy) return;
    const double of_frame = energy_->of_frame(time(n_));
    statistics_.energy->final = energy_->energy() + of_frame;
    statistics_.energy->work += of_frame;
  }

  void count() {
    if (step_) step_->count(statistics_);
    notifier_.count_seconds();
  }

  [[noreturn]] void fail(Failure why, double t, const std::string& what) {
    close_account();
    throw IntegrationError(why, fmt::format("fully discrete scheme (2.8) at t = {}: {}", t, what), statistics_);
  }

  const BarSystem& system_;
  const StartingPoint& start_;
  std::span<const double> times_;
  const FullyDiscrete& scheme_;
  const Observers& observers_;
  Statistics statistics_;  // with those of the run before it was begun from a checkpoint
  Notifier notifier_;
  std::size_t steps_ = 1, n_ = 1, written_ = 0;
  std::span<const unsigned char> active_;  // of the step
  std::vector<unsigned char> was_active_;
  bool may_penetrate_ = true;
  double largest_ = 0.0;  // force on a contact that a change has met
  JumpFilter filter_;
  std::optional<PenalisedSystem> settled_;  // the system of the scheme, as the filter takes it
  double next_break_ = std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, double>> begun_;  // breaks that the load has a part of, and the share that is left
  std::optional<TimeStep> step_;
  std::optional<StepEnergy> energy_;  // of it
  std::optional<StepReactions> reactions_;
  std::optional<StepSnapshot> snapshot_;  // where somebody asks
};

}  // namespace

Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const FullyDiscrete& scheme, const Observers& observers) {
  refuse_directions("fully_discrete", observers);
  refuse_laws("fully_discrete", system.inputs());
  check(system, start, times, scheme);
  return Run(system, start, times, scheme, observers)();
}

}  // namespace viscobar
