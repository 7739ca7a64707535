#include "integration/exponential/run.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "run/step_failure.hpp"

namespace viscobar::exponential {

PartEnd Run::operator()(const StartingPoint& start) {
  try {
    if (const auto* checkpoint = std::get_if<Checkpoint>(&start))
      go_on(*checkpoint);
    else
      begin(std::get<State>(start));
    while (t_ < times_.back()) {
      if (!advance()) continue;
      if (!telling_.progress(t_)) return reached();
      if (t_ < times_.back() && schedule_.due(t_)) return Checkpoint{t_, next_output_, reached(), archived(*this)};
    }
  } catch (const LoadError& error) {
    fail(Failure::load, error);
  } catch (const StepFailure& failure) {
    fail(failure.why, failure);
  }
  statistics_.completed = true;
  return reached();
}

Statistics Run::reached() {
  statistics_.reached_time = t_;
  statistics_.load_evaluations = load_evaluations_before_ + load_.evaluations() + penalised_.load_evaluations();
  telling_.count_seconds();
  return statistics_;
}

void Run::fail(Failure why, const std::exception& cause) {
  throw IntegrationError(why, fmt::format("exponential stopped at t = {}: {}", t_, cause.what()), reached());
}

void Run::enter_piece() {
  piece_end_ = penalised_.begin_leg(t_, times_.back());
  load_.enter(t_, times_.back());
}

void Run::pass_kink() {
  const auto jump = system_.kink(t_, times_.back());
  if (!jump) return;
  std::vector<double> w(system_.size(), 0.0);
  const auto first = static_cast<std::ptrdiff_t>(system_.massive_begin());
  const auto velocities = y_.tail(leg().size() - leg().displacements());
  std::ranges::copy(velocities, w.begin() + first);
  std::vector<double> change = w;
  const double gained = system_.pass_kink(*jump, w);
  for (std::size_t i = 0; i < w.size(); ++i) change[i] = w[i] - change[i];
  if (ends_) ends_->pass_kink(change);
  for (Index k = 0; k < velocities.size(); ++k) y_[leg().displacements() + k] = w[static_cast<std::size_t>(first + k)];
  if (statistics_.energy) statistics_.energy->work += gained;
}

void Run::begin(const State& start) {
  State state = start;
  enter_piece();
  penalised_.complete_displacement(t_, state.u);
  penalised_.complete_velocity(t_, state.u, state.v);
  const std::vector<double> approach = state.v;
  penalised_.settle(t_, state.u, state.v);
  const VectorXd u = Eigen::Map<const VectorXd>(state.u.data(), static_cast<Index>(system_.size()));
  const VectorXd v = Eigen::Map<const VectorXd>(state.v.data(), static_cast<Index>(system_.size()));
  begin_leg();
  y_ = leg().pack(u, v);
  if (observers_.account) {
    statistics_.account.emplace();
    watch_ends();
    std::vector<double> both = state.u;
    both.insert(both.end(), state.v.begin(), state.v.end());
    ends_->begin(t_, both);
  }
  for (std::size_t c = 0; c < contacts(); ++c) {
    if (!penalised_.closed(c)) continue;
    statistics_.max_penetration = std::max(statistics_.max_penetration, -penalised_.clearance(c, state.u));
    measure_from_obstacle(c);
    tell_change(c, approach[node(c)]);
  }
  begin_leg();
  statistics_.unknowns = static_cast<std::size_t>(y_.size());
  if (observers_.energy) {
    energy_scale_ = penalised_.energy(state.u, state.v);
    const double of_frame = penalised_.frame_energy(t_, state.u, state.v);
    statistics_.energy = {.initial = energy_scale_ + of_frame, .work = -of_frame};
  }
  pass_kink();
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
  pass_kink();
}

void Run::watch_ends() {
  ends_.emplace(penalised_, *statistics_.account);
  ends_->ask_for(end_entries_);
  sampled_.resize(end_entries_.size());
}

void Run::measure_from_obstacle(std::size_t closing) {
  if (distance_.follows(closing) || measured_[closing]) return;
  for (std::size_t c = 0; c < contacts(); ++c) {
    const Contact &one = penalised_.contact(c), &other = penalised_.contact(closing);
    if (one.where != other.where || one.sign != other.sign) continue;
    measured_[c] = 1;
    y_[node(c)] += propagators_.origin()[node(c)] + one.sign * one.gap;
    propagators_.measure_from_obstacle(c);
  }
}

void Run::begin_leg() {
  propagator_ = &propagators_.present();
  if (ends_) ends_->measure_from(entries(propagators_.origin()));
  level_ = wait_ = 0;
}

}  // namespace viscobar::exponential
