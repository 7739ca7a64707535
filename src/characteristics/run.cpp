#include "characteristics/run.hpp"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace viscobar::characteristics {

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
      left_(end_of(scene_.left, scene_.left_input, data_.displacement(0, 0.0))),
      right_(end_of(scene_.right, scene_.right_input, data_.displacement(data_.displacement.size() - 1, 1.0))) {
  if (scene.load) load_ = LoadGain::of(*scene_.load, scene.bar, passage_, times.front(), times.back());
  if (observers_.snapshot) u_.resize(mesh.nodes()), v_.resize(mesh.nodes());
  const double until = (times.back() - times.front()) / passage_;
  last_passage_ = static_cast<std::size_t>(std::max(0.0, std::ceil(until) - 1.0));
  if (last_passage_ > 0 && until - static_cast<double>(last_passage_) < least_passage) --last_passage_;
}

Run::BarEnd Run::end_of(const EndCondition& condition, const EndInput& input, double displacement) const {
  const BarEnd::Memory start{End(condition, displacement, passage_)};
  return {start, start, DrivenEnd(input, impedance_, passage_, times_.front())};
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
  } catch (const LoadError& error) {
    fail(Failure::load, error.what());
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
  if (gain || k_ == 0) now_.velocity_scale = std::max(now_.velocity_scale, arriving->bound());
  now_.place_scale = std::max(now_.place_scale, std::abs(end.now.end.place()));
  const auto answer = [&](const Piecewise& to, Piecewise& by) {
    end.now.end.answer(to, until, {now_.place_scale + passage_ * now_.velocity_scale, now_.velocity_scale}, by);
  };
  if (!end.driven.active()) return answer(*arriving, end.sent);
  end.driven.enter(k_);
  const Piecewise& relative = end.driven.relative(*arriving);
  now_.velocity_scale = std::max(now_.velocity_scale, relative.bound());
  answer(relative, end.moved_if_driven);
  end.driven.send(end.moved_if_driven, *arriving, end.sent);
  if (observers_.energy || observers_.account) end.driven.add(end.now.end, end.moved_if_driven, end.now.driven);
}

void Run::leave() {
  constexpr double of_time = 1e-8;  // what lasts longer is no rounding of a time
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

}  // namespace viscobar::characteristics
