#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "characteristics/driven_end.hpp"
#include "characteristics/end.hpp"
#include "characteristics/field.hpp"
#include "characteristics/initial_waves.hpp"
#include "characteristics/load_gain.hpp"
#include "run/parts.hpp"
#include "run/telling.hpp"
#include "viscobar/characteristics/characteristics.hpp"
#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar::characteristics {

inline double sign_of(const EndCondition& end) {
  const auto* obstacle = std::get_if<Obstacle>(&end);
  return obstacle && obstacle->side == Side::above ? -1.0 : 1.0;
}

/// Of a place of an End.
inline double displacement_at(const EndCondition& end, double place) {
  const auto* obstacle = std::get_if<Obstacle>(&end);
  return obstacle ? sign_of(end) * (place - obstacle->gap) : place;
}

inline End end_of(const EndCondition& end, double displacement, double passage) {
  if (is_fixed(end)) return {End::Kind::fixed, displacement, passage};
  if (!is_obstacle(end)) return {End::Kind::free, displacement, passage};
  // Data that touch up to their rounding touch.
  const double sign = sign_of(end), gap = std::get<Obstacle>(end).gap, clearance = sign * displacement + gap;
  const double touch = 4.0 * rounding * (std::abs(displacement) + gap);
  return {End::Kind::obstacle, clearance <= touch ? 0.0 : clearance, passage, sign};
}

/// A run of the method `characteristics`. It goes from passage to passage. A passage is the time in which a wave
/// crosses the bar. All that arrives at an end in a passage was sent by the other end in the passage before. So each
/// end answers for itself. What both ends have sent gives output and events.
class Run {
 public:
  Run(const Scene& scene, const Mesh& mesh, const std::optional<Checkpoint>& from, std::span<const double> times,
      const Characteristics& method, const Observers& observers,
      double most_work = std::numeric_limits<double>::infinity())
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

  PartEnd operator()(const std::optional<Checkpoint>& from);

  /// What a checkpoint holds: the state at the beginning of its passage, and how much of the passage has been told.
  static void members(auto& run, auto&& each) {
    each(run.nodes_, run.k_, run.sent_left_before_, run.sent_right_before_, run.left_begin_, run.right_begin_,
         run.work_begin_, run.error_begin_, run.gain_errors_begin_, run.velocity_scale_begin_, run.place_scale_begin_,
         run.simplified_left_, run.simplified_right_, run.initial_moment_, run.told_, run.largest_,
         run.driven_left_begin_, run.driven_right_begin_);
  }

 private:
  static constexpr double least_passage = 1e-12;     // of the last passage, in passages
  static constexpr double work_of_evaluation = 0.1;  // in pieces that are carried through a passage

  static double last_value(const Piecewise& f) {
    const std::size_t last = f.size() - 1;
    return f.polynomial(last)(f[last].z(1.0));
  }

  double time_at(double s) const { return times_.front() + passage_ * (static_cast<double>(k_) + s); }
  // Of a time in the present passage.
  double part_at(double t) const { return std::fma(-static_cast<double>(k_), passage_, t - times_.front()) / passage_; }
  bool last() const { return k_ == last_passage_; }

  Statistics reached();

  // Of R = impedance * (what arrives), over the passages so far.
  void account(EndAccount& account, const End& end, const DrivenEnd& driven, const EndCondition& condition) const;
  [[noreturn]] void fail(Failure why, const std::string& what);
  void begin();

  // int f u dx of a steady load: f = (rho c) d(gain)/dx, so by parts no derivative is needed but that of the load's own
  // pieces.
  template <class Make>
  double moment(Make&& make);
  void go_on(const Checkpoint& checkpoint);

  double worked() const {
    return carried_ + (load_ ? work_of_evaluation * static_cast<double>(load_->evaluations()) : 0.0);
  }

  // What both ends send in passage k.
  void enter();
  void answer(End& end, DrivenEnd& driven, const Piecewise& sent, const Piecewise* gain, double until, Piecewise& moved,
              Piecewise& answer);

  // What an end sends against what holds or bounds it, by which it moves.
  const Piecewise& moved(bool left) const;

  // (w + g)^2 - w^2 of what has arrived.
  double arrived_work(const Piecewise& sent, const Piecewise& gain, double until) const;

  // Places between which the field of this passage is polynomial, at s.
  std::vector<double> breaks_at(double s) const;

  // Work of the load up to s in this passage. Of a load that varies it is what the load has given to waves: to those
  // that have arrived and to those on their way.
  double work_at(double s, Field& now);

  // The most terms of a polynomial in the field.
  std::size_t most_terms() const;
  EnergyState energy_at(double s, Field& now);

  struct Told {
    double s;
    Where where;
    Change change;
    double velocity;
  };

  void merge_turns();

  // Outputs, events and checkpoints of the present passage; the end of this part of the run, where it is there.
  std::optional<PartEnd> tell_passage();

  // An output tells the side before an event.
  void tell_events_before(double t);
  void tell_events(double t);
  double time_of(const Told& event) const { return std::clamp(time_at(event.s), t_, times_.back()); }

  void tell(const Told& event);
  Field field(double s, double t);
  void tell_output();
  void leave();
  void finish();

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

}  // namespace viscobar::characteristics
