#include "characteristics/run.hpp"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace viscobar::characteristics {

PartEnd Run::operator()(const std::optional<Checkpoint>& from) {
  try {
    if (from)
      go_on(*from);
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
  statistics_.event_evaluations = left_.searched() + right_.searched();
  statistics_.unknowns = largest_;
  telling_.count_seconds();
  if (statistics_.account) {
    account(statistics_.account->left, left_, driven_left_, scene_.left);
    account(statistics_.account->right, right_, driven_right_, scene_.right);
  }
  const double duration = t_ - times_.front();
  const double passages = static_cast<double>(k_) + 1.0;
  const double velocity_error = data_.velocity_error + error_ + driven_left_.error() + driven_right_.error() +
                                (load_ ? load_->errors().arrivals + load_->errors().looked_at : 0.0);
  statistics_.representation = {data_.displacement_error + duration * velocity_error,
                                rounding * passages * (place_scale_ + duration * velocity_scale_), velocity_scale_};
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
  if (load_) load_->restore(gain_errors_begin_);
  left_ = left_begin_;
  right_ = right_begin_;
  work_ = work_begin_;
  error_ = error_begin_;
  driven_left_.restore(driven_left_begin_);
  driven_right_.restore(driven_right_begin_);
  velocity_scale_ = velocity_scale_begin_;
  place_scale_ = place_scale_begin_;
  next_output_ = checkpoint.outputs;
  skip_ = told_;
}

void Run::enter() {
  left_begin_ = left_;
  right_begin_ = right_;
  work_begin_ = work_;
  error_begin_ = error_;
  driven_left_begin_ = driven_left_.account();
  driven_right_begin_ = driven_right_.account();
  if (load_) gain_errors_begin_ = load_->errors();
  velocity_scale_begin_ = velocity_scale_;
  place_scale_begin_ = place_scale_;
  const double until = last() ? std::clamp(part_at(times_.back()), least_passage, 1.0) : 1.0;
  if (load_) load_->enter(k_);
  answer(left_, driven_left_, sent_right_before_, load_ ? &load_->arriving_left() : nullptr, until, moved_left_,
         sent_left_);
  answer(right_, driven_right_, sent_left_before_, load_ ? &load_->arriving_right() : nullptr, until, moved_right_,
         sent_right_);
  error_ += sent_left_.left_out() + sent_right_.left_out();
  largest_ = std::max(largest_, sent_left_.coefficients() + sent_right_.coefficients());
  merge_turns();
}

void Run::answer(End& end, DrivenEnd& driven, const Piecewise& sent, const Piecewise* gain, double until,
                 Piecewise& moved, Piecewise& answer) {
  const Piecewise* arriving = &sent;
  if (gain) {
    combine(sent, 1.0, *gain, 1.0, arriving_);
    arriving = &arriving_;
    if (observers_.energy && !load_->steady()) work_ += arrived_work(sent, *gain, until);
  }
  if (gain || k_ == 0) velocity_scale_ = std::max(velocity_scale_, arriving->bound());
  place_scale_ = std::max(place_scale_, std::abs(end.place()));
  const auto scale = [&] { return End::Scale{place_scale_ + passage_ * velocity_scale_, velocity_scale_}; };
  if (!driven.active()) return end.answer(*arriving, until, scale(), answer);
  driven.enter(k_);
  const Piecewise& relative = driven.relative(*arriving);
  velocity_scale_ = std::max(velocity_scale_, relative.bound());
  end.answer(relative, until, scale(), moved);
  driven.send(moved, *arriving, answer);
  if (!observers_.energy && !observers_.account) return;
  const EndCondition& condition = &end == &left_ ? scene_.left : scene_.right;
  Cursor along(moved);
  driven.add(end, moved, [&](double s) {
    return displacement_at(condition, end.place_at(s, along)) + driven.displacement(time_at(s));
  });
}

const Piecewise& Run::moved(bool left) const {
  if (left) return driven_left_.active() ? moved_left_ : sent_left_;
  return driven_right_.active() ? moved_right_ : sent_right_;
}

void Run::leave() {
  constexpr double of_time = 1e-8;  // what lasts longer is no rounding of a time
  const double tolerance = 8.0 * rounding * velocity_scale_, negligible = 64.0 * rounding * velocity_scale_;
  for (auto [sent, count] : {std::pair{&sent_left_, &simplified_left_}, std::pair{&sent_right_, &simplified_right_}}) {
    if (sent->size() <= 2 * *count + 8) continue;
    error_ += simplify(*sent, tolerance, negligible, of_time, arriving_) + sent->left_out();
    *count = sent->size();
    if (*count > method_.most_pieces)
      fail(
          Failure::detail,
          fmt::format("{} contact changes have broken the waves into more than {} pieces, and each passage breaks them "
                      "further: there is no end of the detail that the exact motion has",
                      statistics_.events, method_.most_pieces));
  }
  carried_ += static_cast<double>(sent_left_.size() + sent_right_.size());
  std::swap(sent_left_, sent_left_before_);
  std::swap(sent_right_, sent_right_before_);
}

}  // namespace viscobar::characteristics
