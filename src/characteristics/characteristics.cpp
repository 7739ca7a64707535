#include "viscobar/characteristics/characteristics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "characteristics/driven_end.hpp"
#include "characteristics/end.hpp"
#include "characteristics/field.hpp"
#include "characteristics/initial_waves.hpp"
#include "characteristics/load_gain.hpp"
#include "run/parts.hpp"
#include "run/telling.hpp"
#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar {

namespace {

using namespace characteristics;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double least_passage = 1e-12;  // of the last passage, in passages

// Of a look ahead: a few tenths of a second.
constexpr std::size_t pieces_awaited = 10'000;
constexpr double work_awaited = 1e6, work_of_evaluation = 0.1;  // in pieces that are carried through a passage

double sign_of(const EndCondition& end) {
  const auto* obstacle = std::get_if<Obstacle>(&end);
  return obstacle && obstacle->side == Side::above ? -1.0 : 1.0;
}

// Of a place of an End.
double displacement_at(const EndCondition& end, double place) {
  const auto* obstacle = std::get_if<Obstacle>(&end);
  return obstacle ? sign_of(end) * (place - obstacle->gap) : place;
}

End end_of(const EndCondition& end, double displacement, double passage) {
  if (is_fixed(end)) return {End::Kind::fixed, displacement, passage};
  if (!is_obstacle(end)) return {End::Kind::free, displacement, passage};
  // Data that touch up to their rounding touch.
  const double sign = sign_of(end), gap = std::get<Obstacle>(end).gap, clearance = sign * displacement + gap;
  const double touch = 4.0 * rounding * (std::abs(displacement) + gap);
  return {End::Kind::obstacle, clearance <= touch ? 0.0 : clearance, passage, sign};
}

// Integral of f of a place over [0, 1], polynomial of degree 2 points - 1 between the breaks.
template <class Function>
double integral(std::vector<double>& breaks, Function&& f, std::size_t points = 36) {
  breaks.push_back(0.0);
  breaks.push_back(1.0);
  std::ranges::sort(breaks);
  double sum = 0.0;
  for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
    const double half = 0.5 * (breaks[k + 1] - breaks[k]), middle = 0.5 * (breaks[k + 1] + breaks[k]);
    if (!(half > 0.0)) continue;
    for (const auto [node, weight] : gauss_legendre(points)) sum += half * weight * f(middle + half * node);
  }
  return sum;
}

void add_breaks(const Piecewise& f, std::vector<double>& breaks) {
  for (std::size_t i = 0; i + 1 < f.size(); ++i) breaks.push_back(f[i].end);
}

// Goes from passage to passage. In one, all that arrives at an end was sent by the other end in the passage before, so
// each end answers for itself; output and events are told from what both have sent.
class Run {
 public:
  Run(const Scene& scene, const Mesh& mesh, const std::optional<Checkpoint>& from, std::span<const double> times,
      const Characteristics& method, const Observers& observers, double most_work = infinite)
      : scene_(scene),
        mesh_(mesh),
        times_(times),
        observers_(observers),
        method_(method),
        most_work_(most_work),
        passage_(scene.bar.length / std::sqrt(scene.bar.modulus / scene.bar.density)),
        impedance_(std::sqrt(scene.bar.modulus * scene.bar.density)),
        statistics_(from ? from->statistics : Statistics{}),
        load_evaluations_before_(statistics_.load_evaluations),
        telling_(observers, statistics_),
        t_(from ? from->time : times.front()),
        schedule_(observers, times, t_),
        data_(initial_data(scene_)),
        left_(end_of(scene.left, data_.displacement.polynomial(0)(data_.displacement[0].z(0.0)), passage_)),
        right_(end_of(scene.right, last_value(data_.displacement), passage_)),
        driven_left_(scene_.left_input, impedance_, passage_, times.front()),
        driven_right_(scene_.right_input, impedance_, passage_, times.front()) {
    if (scene.load) load_ = LoadGain::of(*scene_.load, scene.bar, passage_, times.front(), times.back());
    if (observers_.snapshot) u_.resize(mesh.nodes()), v_.resize(mesh.nodes());
    const double until = (times.back() - times.front()) / passage_;
    last_passage_ = static_cast<std::size_t>(std::max(0.0, std::ceil(until) - 1.0));
    if (last_passage_ > 0 && until - static_cast<double>(last_passage_) < least_passage) --last_passage_;
  }

  PartEnd operator()(const std::optional<Checkpoint>& from) {
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

  /// What a checkpoint holds: the state at the beginning of its passage, and how much of the passage has been told.
  static void members(auto& run, auto&& each) {
    each(run.nodes_, run.k_, run.sent_left_before_, run.sent_right_before_, run.left_begin_, run.right_begin_,
         run.work_begin_, run.error_begin_, run.gain_errors_begin_, run.velocity_scale_begin_, run.place_scale_begin_,
         run.simplified_left_, run.simplified_right_, run.initial_moment_, run.told_, run.largest_,
         run.driven_left_begin_, run.driven_right_begin_);
  }

 private:
  static double last_value(const Piecewise& f) {
    const std::size_t last = f.size() - 1;
    return f.polynomial(last)(f[last].z(1.0));
  }

  double time_at(double s) const { return times_.front() + passage_ * (static_cast<double>(k_) + s); }
  // Of a time in the present passage.
  double part_at(double t) const { return std::fma(-static_cast<double>(k_), passage_, t - times_.front()) / passage_; }
  bool last() const { return k_ == last_passage_; }

  Statistics reached() {
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

  // Of R = impedance * (what arrives), over the passages so far.
  void account(EndAccount& account, const End& end, const DrivenEnd& driven, const EndCondition& condition) const {
    const Borne& borne = end.borne();
    account.displacement = displacement_at(condition, end.place()) + driven.displacement(t_);
    account.lowest = displacement_at(condition, borne.lowest);
    account.highest = displacement_at(condition, borne.highest);
    if (sign_of(condition) < 0.0) std::swap(account.lowest, account.highest);
    if (driven.moves()) account.lowest = driven.account().lowest, account.highest = driven.account().highest;
    account.impulse = impedance_ * driven.force_factor() * passage_ * end.impulse();
    account.peak_reaction = impedance_ * driven.force_factor() * borne.max_reaction;
  }

  [[noreturn]] void fail(Failure why, const std::string& what) {
    throw IntegrationError(why, fmt::format("characteristics stopped at t = {}: {}", t_, what), reached());
  }

  void begin() {
    // The waves on their way at the start, as if the ends had sent them in the passage before.
    Piecewise rightward, leftward;
    combine(data_.velocity, 1.0, data_.strain_velocity, -1.0, rightward);
    combine(data_.velocity, 1.0, data_.strain_velocity, 1.0, leftward);
    if (load_ && load_->steady()) {
      Piecewise without;
      combine(rightward, 1.0, load_->rightward(), -1.0, without);
      rightward = without;
      combine(leftward, 1.0, load_->leftward(), -1.0, without);
      leftward = without;
    }
    sent_left_before_ = mirrored(rightward);
    sent_right_before_ = leftward;
    place_scale_ = data_.displacement.bound();
    velocity_scale_ = std::max(data_.velocity.bound(), data_.strain_velocity.bound());
    if (observers_.account) statistics_.account.emplace();
    if (observers_.energy) {
      std::vector<double> breaks;
      add_breaks(rightward, breaks);
      add_breaks(leftward, breaks);
      add_breaks(data_.velocity, breaks);
      add_breaks(data_.strain_velocity, breaks);
      Cursor v(data_.velocity), e(data_.strain_velocity);
      statistics_.energy.emplace().initial =
          0.5 * scene_.bar.density * scene_.bar.length * integral(breaks, [&](double place) {
            const double of_velocity = v.value(place), of_strain = e.value(place);
            return of_velocity * of_velocity + of_strain * of_strain;
          });
      if (load_ && load_->steady())
        initial_moment_ =
            moment([&] { return [u = Cursor(data_.displacement)](double place) mutable { return u.value(place); }; });
    }
  }

  // int f u dx of a steady load: f = (rho c) d(gain)/dx, so by parts no derivative is needed but that of the load's own
  // pieces.
  template <class Make>
  double moment(Make&& make) {
    const Piecewise& gain = load_->rightward();
    auto displacement = make();
    std::vector<double> breaks = moment_breaks_;
    add_breaks(gain, breaks);
    add_breaks(data_.displacement, breaks);
    std::size_t i = 0;
    double sum = 0.0;
    sum = integral(breaks, [&](double place) {
      while (i + 1 < gain.size() && gain[i].end <= place) ++i;
      while (i > 0 && gain[i].begin > place) --i;
      return gain.polynomial(i).derivative()(gain[i].z(place)) / gain[i].half * displacement(place);
    });
    return impedance_ * sum;
  }

  void go_on(const Checkpoint& checkpoint) {
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

  double worked() const {
    return carried_ + (load_ ? work_of_evaluation * static_cast<double>(load_->evaluations()) : 0.0);
  }

  // What both ends send in passage k.
  void enter() {
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

  void answer(End& end, DrivenEnd& driven, const Piecewise& sent, const Piecewise* gain, double until, Piecewise& moved,
              Piecewise& answer) {
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

  // What an end sends against what holds or bounds it, by which it moves.
  const Piecewise& moved(bool left) const {
    if (left) return driven_left_.active() ? moved_left_ : sent_left_;
    return driven_right_.active() ? moved_right_ : sent_right_;
  }

  // (w + g)^2 - w^2 of what has arrived.
  double arrived_work(const Piecewise& sent, const Piecewise& gain, double until) const {
    double sum = 0.0;
    for_common_pieces(sent, gain, until, [&](double from, double to, std::size_t i, std::size_t j) {
      const Chebyshev w = sent.polynomial(i), g = gain.polynomial(j);
      const double half = 0.5 * (to - from), middle = 0.5 * (to + from);
      for (const auto [node, weight] : gauss_legendre(Chebyshev::most_terms)) {
        const double s = middle + half * node, gained = g(gain[j].z(s));
        sum += half * weight * gained * (2.0 * w(sent[i].z(s)) + gained);
      }
    });
    return 0.25 * scene_.bar.density * scene_.bar.length * sum;
  }

  // Places between which the field of this passage is polynomial, at s.
  std::vector<double> breaks_at(double s) const {
    std::vector<double> breaks{s, 1.0 - s};
    for (std::size_t i = 0; i < sent_left_.size(); ++i) breaks.push_back(s - sent_left_[i].begin);
    for (std::size_t i = 0; i < sent_right_.size(); ++i) breaks.push_back(1.0 - (s - sent_right_[i].begin));
    for (std::size_t i = 0; i < sent_left_before_.size(); ++i) breaks.push_back(1.0 + s - sent_left_before_[i].begin);
    for (std::size_t i = 0; i < sent_right_before_.size(); ++i) breaks.push_back(sent_right_before_[i].begin - s);
    if (load_) {
      add_breaks(load_->rightward(), breaks);
      add_breaks(load_->leftward(), breaks);
    }
    std::erase_if(breaks, [](double place) { return !(place > 0.0 && place < 1.0); });
    return breaks;
  }

  // Of the load, up to s in this passage: of a varying one what it has given the waves that have arrived, and those on
  // their way.
  double work_at(double s, Field& now) {
    if (load_->steady())
      return moment([&] { return [&](double place) { return now.displacement(place); }; }) - initial_moment_;
    Cursor right_gain(load_->rightward()), left_gain(load_->leftward());
    const double arrived = work_begin_ + arrived_work(sent_right_before_, load_->arriving_left(), s) +
                           arrived_work(sent_left_before_, load_->arriving_right(), s);
    return arrived + 0.25 * scene_.bar.density * scene_.bar.length * integral(moment_breaks_, [&](double place) {
                       const double g = right_gain.value(place), h = left_gain.value(place);
                       return g * (2.0 * now.rightward(place) - g) + h * (2.0 * now.leftward(place) - h);
                     });
  }

  // The most terms of a polynomial in the field.
  std::size_t most_terms() const {
    std::size_t most = 1;
    const auto look = [&](const Piecewise& f) {
      for (std::size_t i = 0; i < f.size(); ++i) most = std::max<std::size_t>(most, f[i].terms);
    };
    for (const Piecewise* sent : {&sent_left_, &sent_right_, &sent_left_before_, &sent_right_before_}) look(*sent);
    if (load_) look(load_->rightward()), look(load_->leftward());
    return most;
  }

  EnergyState energy_at(double s, Field& now) {
    std::vector<double> breaks = moment_breaks_ = breaks_at(s);
    const double share = 0.125 * scene_.bar.density * scene_.bar.length;
    const std::size_t points = std::min<std::size_t>(most_terms(), 36);
    EnergyState energy;
    energy.kinetic = share * integral(
                                 breaks,
                                 [&](double place) {
                                   const double v = now.rightward(place) + now.leftward(place);
                                   return v * v;
                                 },
                                 points);
    breaks = moment_breaks_;
    energy.elastic = share * integral(
                                 breaks,
                                 [&](double place) {
                                   const double e = now.rightward(place) - now.leftward(place);
                                   return e * e;
                                 },
                                 points);
    if (load_) energy.work = work_at(s, now);
    for (const bool left : {true, false}) {
      const DrivenEnd& driven = left ? driven_left_ : driven_right_;
      if (!driven.active()) continue;
      const DrivenEnd::Account& begin = left ? driven_left_begin_ : driven_right_begin_;
      const DrivenEnd::Flow since = driven.flow(left ? left_ : right_, moved(left), s);
      energy.work += begin.work + since.work;
      energy.dissipated += begin.dissipated + since.dissipated;
    }
    return energy;
  }

  struct Told {
    double s;
    Where where;
    Change change;
    double velocity;
  };

  void merge_turns() {
    events_.clear();
    for (const Turn& turn : left_.turns()) events_.push_back({turn.s, Where::left, turn.change, turn.velocity});
    for (const Turn& turn : right_.turns()) events_.push_back({turn.s, Where::right, turn.change, turn.velocity});
    std::ranges::stable_sort(events_, {}, &Told::s);
    told_ = 0;
  }

  // Outputs, events and checkpoints of the present passage; the end of this part of the run, where it is there.
  std::optional<PartEnd> tell_passage() {
    told_ = std::exchange(skip_, 0);
    const double end = last() ? times_.back() : std::min(time_at(1.0), times_.back());
    if (k_ == 0 && next_output_ == 0) tell_events(times_.front());
    for (;;) {
      const bool output = next_output_ < times_.size() && times_[next_output_] <= end;
      double stop = output ? times_[next_output_] : end;
      if (const auto due = schedule_.next(); due && *due > t_ && *due < stop) stop = *due;
      const bool at_output = output && stop == times_[next_output_];
      tell_events_before(stop);
      if (at_output) tell_output();
      const bool advanced = stop > t_;
      t_ = stop;
      if (stop == end && !output) tell_events(std::numeric_limits<double>::infinity());
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

  // An output tells the side before an event.
  void tell_events_before(double t) {
    while (told_ < events_.size() && time_of(events_[told_]) < t) tell(events_[told_++]);
  }
  void tell_events(double t) {
    while (told_ < events_.size() && time_of(events_[told_]) <= t) tell(events_[told_++]);
  }
  double time_of(const Told& event) const { return std::clamp(time_at(event.s), t_, times_.back()); }

  void tell(const Told& event) {
    ++statistics_.events;
    if (!observers_.event && !statistics_.account) return;
    const bool left = event.where == Where::left;
    const DrivenEnd& driven = left ? driven_left_ : driven_right_;
    const double t = time_of(event);
    Event told{t, event.where, left ? 0 : mesh_.elements, event.change, event.velocity + driven.velocity(t)};
    if (statistics_.account) {
      Cursor sent(moved(left));
      told.impulse = impedance_ * driven.force_factor() * passage_ * (left ? left_ : right_).impulse_at(event.s, sent);
      statistics_.account->count(told);
    }
    telling_.told(told);
  }

  Field field(double s, double t) {
    Cursor left(moved(true)), right(moved(false));
    if (load_) load_->look(s);
    return Field({sent_left_, sent_left_before_, sent_right_, sent_right_before_, load_ ? &load_->rightward() : nullptr,
                  load_ ? &load_->leftward() : nullptr},
                 s, displacement_at(scene_.left, left_.place_at(s, left)) + driven_left_.displacement(t),
                 displacement_at(scene_.right, right_.place_at(s, right)) + driven_right_.displacement(t), passage_);
  }

  void tell_output() {
    const double t = times_[next_output_++];
    if (!observers_.snapshot) return;
    const double s = std::clamp(part_at(t), 0.0, sent_left_.end());
    Field now = field(s, t);
    for (std::size_t j = 0; j < u_.size(); ++j) {
      const double place = mesh_.node(j) / mesh_.length;
      u_[j] = now.displacement(place);
      v_[j] = now.velocity(place);
    }
    Cursor left(moved(true)), right(moved(false));
    u_.front() = displacement_at(scene_.left, left_.place_at(s, left)) + driven_left_.displacement(t);
    u_.back() = displacement_at(scene_.right, right_.place_at(s, right)) + driven_right_.displacement(t);
    v_.front() = left_.velocity_at(s, left) + driven_left_.velocity(t);
    v_.back() = right_.velocity_at(s, right) + driven_right_.velocity(t);
    for (const double u : {u_.front(), u_.back()}) place_scale_ = std::max(place_scale_, std::abs(u));
    Snapshot snapshot{t, u_, v_, impedance_ * driven_left_.force_factor() * left_.force_at(s, left),
                      impedance_ * driven_right_.force_factor() * right_.force_at(s, right)};
    if (observers_.energy) snapshot.energy = energy_at(s, now);
    telling_.snapshot(snapshot);
  }

  void leave() {
    constexpr double of_time = 1e-8;  // what lasts longer is no rounding of a time
    const double tolerance = 8.0 * rounding * velocity_scale_, negligible = 64.0 * rounding * velocity_scale_;
    for (auto [sent, count] :
         {std::pair{&sent_left_, &simplified_left_}, std::pair{&sent_right_, &simplified_right_}}) {
      if (sent->size() <= 2 * *count + 8) continue;
      error_ += simplify(*sent, tolerance, negligible, of_time, arriving_) + sent->left_out();
      *count = sent->size();
      if (*count > method_.most_pieces)
        fail(Failure::detail,
             fmt::format(
                 "{} contact changes have broken the waves into more than {} pieces, and each passage breaks them "
                 "further: there is no end of the detail that the exact motion has",
                 statistics_.events, method_.most_pieces));
    }
    carried_ += static_cast<double>(sent_left_.size() + sent_right_.size());
    std::swap(sent_left_, sent_left_before_);
    std::swap(sent_right_, sent_right_before_);
  }

  void finish() {
    t_ = times_.back();
    statistics_.completed = true;
    if (!statistics_.energy) return;
    const double s = sent_left_.end();
    Field now = field(s, t_);
    std::vector<double> breaks = moment_breaks_ = breaks_at(s);
    const double share = 0.25 * scene_.bar.density * scene_.bar.length;
    EnergyAccount& energy = *statistics_.energy;
    energy.final = share * integral(breaks, [&](double place) {
                     const double a = now.rightward(place), b = now.leftward(place);
                     return a * a + b * b;
                   });
    energy.dissipated = driven_left_.account().dissipated + driven_right_.account().dissipated;
    energy.work = driven_left_.account().work + driven_right_.account().work;
    if (load_) energy.work += work_at(s, now);
  }

  const Scene scene_;  // formulas are called by one run at a time
  const Mesh mesh_;
  std::size_t nodes_ = mesh_.nodes();  // of the run that a checkpoint is of
  std::span<const double> times_;
  const Observers& observers_;
  const Characteristics method_;
  const double most_work_;
  double carried_ = 0.0;        // pieces, of all passages
  double passage_, impedance_;  // L / c, rho c
  Statistics statistics_;
  std::size_t load_evaluations_before_;
  Telling telling_;
  double t_;
  CheckpointSchedule schedule_;
  InitialData data_;
  std::unique_ptr<LoadGain> load_;  // absent without a load

  std::size_t k_ = 0, last_passage_ = 0;
  End left_, right_;
  DrivenEnd driven_left_, driven_right_;
  Piecewise moved_left_, moved_right_;  // of ends that are given something
  Piecewise sent_left_, sent_left_before_, sent_right_, sent_right_before_, arriving_;
  std::size_t simplified_left_ = 0, simplified_right_ = 0;  // pieces after the last time
  double velocity_scale_ = 0.0, place_scale_ = 0.0;
  double work_ = 0.0, error_ = 0.0;  // of a varying load; what was simplified
  double initial_moment_ = 0.0;      // int f u dx
  std::size_t largest_ = 0;
  // At the beginning of the passage.
  End left_begin_ = left_, right_begin_ = right_;
  double velocity_scale_begin_ = 0.0, place_scale_begin_ = 0.0, work_begin_ = 0.0, error_begin_ = 0.0;
  LoadGain::Errors gain_errors_begin_;
  DrivenEnd::Account driven_left_begin_, driven_right_begin_;

  std::vector<Told> events_;
  std::size_t told_ = 0, skip_ = 0, next_output_ = 0;
  std::vector<double> u_, v_, moment_breaks_;
};

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
  return run_in_parts(start, times, observers, [&](const StartingPoint& part) {
    const auto* checkpoint = std::get_if<Checkpoint>(&part);
    const auto begin = checkpoint ? std::optional(*checkpoint) : std::nullopt;
    return Run(scene, mesh, begin, times, method, observers)(begin);
  });
}

std::optional<double> roughens(const Scene& scene, double end) {
  const double times[] = {0.0, end};
  const Characteristics method{.most_pieces = pieces_awaited};
  const Observers nobody;
  require(scene, times, method);
  try {
    Run(scene, Mesh{scene.bar.length, 1}, std::nullopt, times, method, nobody, work_awaited)(std::nullopt);
  } catch (const IntegrationError& error) {
    if (error.failure != Failure::detail) throw;
    return error.statistics.reached_time;
  }
  return std::nullopt;
}

}  // namespace viscobar
