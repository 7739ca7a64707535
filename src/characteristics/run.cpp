#include "characteristics/run.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <utility>
#include <variant>

#include "run/step_failure.hpp"

namespace viscobar::characteristics {

namespace {

constexpr std::size_t rough_awaited = 3'000;  // evaluations for one passage, by a look ahead

}  // namespace

Run::Run(const Scene& scene, const Mesh& mesh, const Checkpoint* from, std::span<const double> times,
         const Characteristics& method, const Observers& observers, double most_work)
    : scene_(scene),
      mesh_(mesh),
      times_(times),
      observers_(observers),
      method_(method),
      most_work_(most_work),
      from_(from),
      passage_(scene.bar.length / std::sqrt(scene.bar.modulus / scene.bar.density)),
      impedance_(std::sqrt(scene.bar.modulus * scene.bar.density)),
      statistics_(from ? from->statistics : Statistics{}),
      load_evaluations_before_(statistics_.load_evaluations),
      telling_(observers, statistics_),
      t_(from ? from->time : times.front()),
      schedule_(observers, times, t_),
      data_(initial_data(scene_)),
      left_(end_of(scene_.left, scene_.left_input, {data_.displacement(0, 0.0), data_.velocity(0, 0.0)})),
      right_(end_of(
          scene_.right, scene_.right_input,
          {data_.displacement(data_.displacement.size() - 1, 1.0), data_.velocity(data_.velocity.size() - 1, 1.0)})) {
  if (scene.load) load_ = LoadGain::of(*scene_.load, scene.bar, passage_, times.front(), times.back());
  if (load_ && std::isfinite(most_work)) load_->most_rough = rough_awaited;
  if (observers_.snapshot) u_.resize(mesh.nodes()), v_.resize(mesh.nodes());
  const double until = (times.back() - times.front()) / passage_;
  last_passage_ = static_cast<std::size_t>(std::max(0.0, std::ceil(until) - 1.0));
  if (last_passage_ > 0 && until - static_cast<double>(last_passage_) < least_passage) --last_passage_;
}

Run::BarEnd Run::end_of(const EndCondition& condition, const EndInput& input, const End::Start& data) const {
  const DrivenEnd driven(input, impedance_, passage_, times_.front());
  const BarEnd::Memory start{End(condition, data, passage_, driven.rate())};
  return {start, start, driven};
}

PartEnd Run::operator()() {
  try {
    if (from_)
      go_on(*from_);
    else
      begin();
    for (;; ++k_) {
      enter();
      if (auto end = tell_passage()) return std::move(*end);
      if (k_ == last_passage_) break;
      leave();
      if (worked() > most_work_) return reached();
    }
  } catch (const RoughLoad& error) {
    fail(Failure::detail, error.what());
  } catch (const LoadError& error) {
    fail(Failure::load, error.what());
  } catch (const StepFailure& error) {
    fail(error.why, error.what());
  }
  finish();
  return reached();
}

Statistics Run::reached() {
  statistics_.reached_time = t_;
  statistics_.load_evaluations = load_ ? load_evaluations_before_ + load_->evaluations() : 0;
  statistics_.event_evaluations = left_.now.end.searched() + right_.now.end.searched();
  statistics_.unknowns = largest_;
  telling_.count_seconds();
  if (statistics_.account) {
    account(statistics_.account->left, left_);
    account(statistics_.account->right, right_);
  }
  const double duration = t_ - times_.front();
  const double passages = static_cast<double>(k_) + 1.0;
  const double velocity_error = data_.velocity_error + now_.error + left_.driven.error() + right_.driven.error() +
                                (load_ ? load_->errors.arrivals + load_->errors.looked_at : 0.0);
  statistics_.representation = {data_.displacement_error + duration * velocity_error,
                                rounding * passages * (now_.place_scale + duration * now_.velocity_scale),
                                now_.velocity_scale};
  return statistics_;
}

void Run::fail(Failure why, const std::string& what) {
  throw IntegrationError(why, fmt::format("characteristics stopped at t = {}: {}", t_, what), reached());
}

void Run::go_on(const Checkpoint& checkpoint) {
  restore(*this, checkpoint, times_, observers_);
  if (nodes_ != mesh_.nodes())
    throw std::invalid_argument("the checkpoint is of another run than the one to go on with");
  if (load_ && k_ > 0 && !load_->steady()) load_->enter(k_ - 1);
  if (load_) load_->errors = gain_errors_begin_;
  for (BarEnd* end : {&left_, &right_}) end->now = end->begin;
  now_ = begin_;
  next_output_ = checkpoint.outputs;
  skip_ = told_;
}

void Run::enter() {
  for (BarEnd* end : {&left_, &right_}) end->begin = end->now;
  begin_ = now_;
  if (load_) gain_errors_begin_ = load_->errors;
  const double until = last() ? std::clamp(part_at(times_.back()), least_passage, 1.0) : 1.0;
  if (load_) load_->enter(k_);
  answer(left_, right_.sent_before, load_ ? &load_->arriving_left() : nullptr, until);
  answer(right_, left_.sent_before, load_ ? &load_->arriving_right() : nullptr, until);
  now_.error += left_.sent.left_out() + right_.sent.left_out();
  largest_ = std::max(largest_, left_.sent.coefficients() + right_.sent.coefficients());
  merge_turns();
}

void Run::answer(BarEnd& end, const Piecewise& sent, const Piecewise* gain, double until) {
  const Piecewise* arriving = &sent;
  if (gain) {
    combine(sent, 1.0, *gain, 1.0, arriving_);
    arriving = &arriving_;
    if (observers_.energy && !load_->steady()) now_.work += arrived_work(sent, *gain, until);
  }
  const auto measure = [&](const Piecewise& waves) {
    const double bound = waves.bound();
    if (!std::isfinite(bound)) throw not_finite();
    now_.velocity_scale = std::max(now_.velocity_scale, bound);
  };
  if (gain || k_ == 0) measure(*arriving);
  now_.place_scale = std::max(now_.place_scale, std::abs(end.now.end.place()));
  const auto answer = [&](const Piecewise& to, Piecewise& by) {
    end.now.end.answer(to, until, {now_.place_scale + passage_ * now_.velocity_scale, now_.velocity_scale}, by);
  };
  if (!end.driven.active()) return answer(*arriving, end.sent);
  end.driven.enter(k_);
  const Piecewise& relative = end.driven.relative(*arriving);
  measure(relative);
  answer(relative, end.moved_if_driven);
  end.driven.send(end.now.end, end.moved_if_driven, *arriving, end.sent);
  if (observers_.energy || observers_.account) end.driven.add(end.now.end, end.moved_if_driven, end.now.driven);
}

void Run::leave() {
  constexpr double of_time = 1e-8;  // a longer piece is no rounding of a time
  const double tolerance = 8.0 * rounding * now_.velocity_scale, negligible = 64.0 * rounding * now_.velocity_scale;
  for (BarEnd* end : {&left_, &right_}) {
    if (end->sent.size() <= 2 * end->simplified + 8) continue;
    now_.error += simplify(end->sent, tolerance, negligible, of_time, arriving_) + end->sent.left_out();
    end->simplified = end->sent.size();
    if (end->simplified > method_.most_pieces)
      fail(
          Failure::detail,
          fmt::format("{} contact changes have broken the waves into more than {} pieces, and each passage breaks them "
                      "further: there is no end of the detail that the exact motion has",
                      statistics_.events, method_.most_pieces));
  }
  carried_ += static_cast<double>(left_.sent.size() + right_.sent.size());
  for (BarEnd* end : {&left_, &right_}) std::swap(end->sent, end->sent_before);
}

void Run::merge_turns() {
  events_.clear();
  for (const Turn& turn : left_.now.end.turns()) events_.push_back({turn, Where::left});
  for (const Turn& turn : right_.now.end.turns()) events_.push_back({turn, Where::right});
  std::ranges::stable_sort(events_, {}, [](const Told& event) { return event.turn.s; });
  told_ = 0;
}

std::optional<PartEnd> Run::tell_passage() {
  told_ = std::exchange(skip_, 0);
  const double end = last() ? times_.back() : std::min(time_at(1.0), times_.back());
  if (k_ == 0 && next_output_ == 0) tell_events(times_.front(), true);
  for (;;) {
    const bool output = next_output_ < times_.size() && times_[next_output_] <= end;
    double stop = output ? times_[next_output_] : end;
    if (const auto due = schedule_.next(); due && *due > t_ && *due < stop) stop = *due;
    const bool at_output = output && stop == times_[next_output_];
    tell_events(stop, false);  // an output tells the side before an event
    if (at_output) tell_output();
    const bool advanced = stop > t_;
    t_ = stop;
    if (stop == end && !output) tell_events(std::numeric_limits<double>::infinity(), true);
    if (advanced) {
      if (!telling_.progress(t_)) return reached();
      if (t_ < times_.back() && schedule_.due(t_)) return Checkpoint{t_, next_output_, reached(), archived(*this)};
    }
    if (!at_output && stop == end) {
      ++statistics_.steps;
      return std::nullopt;
    }
  }
}

void Run::tell_events(double t, bool and_at) {
  const auto due = [&](double time) { return and_at ? time <= t : time < t; };
  while (told_ < events_.size() && due(time_of(events_[told_]))) tell(events_[told_++]);
}

void Run::tell(const Told& event) {
  ++statistics_.events;
  if (!observers_.event && !statistics_.account) return;
  const bool at_left = event.where == Where::left;
  const BarEnd& end = at_left ? left_ : right_;
  const double t = time_of(event), velocity = event.turn.velocity + end.driven.velocity(t);
  Event told{t, event.where, at_left ? 0 : mesh_.elements, event.turn.change, velocity};
  if (statistics_.account) {
    Cursor along(end.moved());
    told.impulse = impedance_ * end.driven.force_factor() * passage_ * end.now.end.impulse_at(event.turn.s, along);
    statistics_.account->count(told);
    if (told.change == Change::opening) told.peak = peak_of(end, event.turn.peak);
  }
  telling_.told(told);
}

Field Run::field(double s, double t) {
  if (load_) load_->look(s);
  return Field({left_.sent, left_.sent_before, right_.sent, right_.sent_before, load_ ? &load_->rightward() : nullptr,
                load_ ? &load_->leftward() : nullptr},
               s, left_.displacement_at(s, t), right_.displacement_at(s, t), passage_);
}

void Run::tell_output() {
  const double t = times_[next_output_++];
  if (!observers_.snapshot) return;
  const double s = std::clamp(part_at(t), 0.0, left_.sent.end());
  Field now = field(s, t);
  for (std::size_t j = 0; j < u_.size(); ++j) {
    const double place = mesh_.node(j) / mesh_.length;
    u_[j] = now.displacement(place);
    v_[j] = now.velocity(place);
  }
  Snapshot snapshot{t, u_, v_};
  const auto tell_end = [&](const BarEnd& end, double& u, double& v, double& reaction) {
    Cursor along(end.moved());
    u = end.displacement_at(s, t);
    v = end.now.end.velocity_at(s, along) + end.driven.velocity(t);
    reaction = impedance_ * end.driven.force_factor() * end.now.end.force_at(s, along);
    now_.place_scale = std::max(now_.place_scale, std::abs(u));
  };
  tell_end(left_, u_.front(), v_.front(), snapshot.reaction_left);
  tell_end(right_, u_.back(), v_.back(), snapshot.reaction_right);
  if (observers_.energy) snapshot.energy = energy_at(s, now);
  telling_.snapshot(snapshot);
}

}  // namespace viscobar::characteristics

namespace viscobar {

namespace {

// Work of a look ahead: a few tenths of a second.
constexpr std::size_t pieces_awaited = 10'000;
constexpr double work_awaited = 1e6;  // in pieces that are carried through a passage

void require(const Scene& scene, std::span<const double> times, const Characteristics& method) {
  require_times(times);
  if (const auto why = refusal(scene, times.back() - times.front(), method)) throw Unfit("characteristics", *why);
}

}  // namespace

Statistics integrate(const Scene& scene, const Mesh& mesh, const std::optional<Checkpoint>& from,
                     std::span<const double> times, const Characteristics& method, const Observers& observers) {
  refuse_directions("characteristics", observers);
  require(scene, times, method);
  const StartingPoint start = from ? StartingPoint(*from) : StartingPoint(State{});
  return run_in_parts(start, times, observers, [&](const StartingPoint& begin) {
    return characteristics::Run(scene, mesh, std::get_if<Checkpoint>(&begin), times, method, observers)();
  });
}

std::optional<double> roughens(const Scene& scene, double end) {
  const double times[] = {0.0, end};
  const Characteristics method{.most_pieces = pieces_awaited};
  const Observers nobody;
  require(scene, times, method);
  try {
    characteristics::Run(scene, Mesh{scene.bar.length, 1}, nullptr, times, method, nobody, work_awaited)();
  } catch (const IntegrationError& error) {
    if (error.failure != Failure::detail || error.statistics.events == 0) throw;
    return error.statistics.reached_time;
  }
  return std::nullopt;
}

}  // namespace viscobar
