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
#include "characteristics/load_gain.hpp"
#include "run/parts.hpp"
#include "run/telling.hpp"
#include "viscobar/characteristics/characteristics.hpp"

namespace viscobar::characteristics {

/// The data of a bar at the start, over places in lengths of it.
struct InitialData {
  Piecewise displacement, velocity;
  Piecewise strain_velocity;  ///< c u_0'
  double displacement_error = 0.0, velocity_error = 0.0;
};

/// @throws std::invalid_argument where they are not finite, or the displacement jumps
InitialData initial_data(const Scene& scene);

/// The bar at one time, by place in lengths of it: the waves on their way through it, and what they have gained.
class Field {
 public:
  /// Waves that the two ends sent in this passage, up to s, and in the one before; the load's gain since then.
  struct Sent {
    const Piecewise &left_now, &left_before, &right_now, &right_before;
    const Piecewise *rightward_gain, *leftward_gain;  ///< null without a load
  };
  /// `left` and `right` are the displacements of the ends, `passage` is L / c.
  Field(const Sent& sent, double s, double left, double right, double passage)
      : left_(left),
        passage_(passage),
        right_going_(sent.left_now, sent.left_before, s),
        left_going_(sent.right_now, sent.right_before, s) {
    if (sent.rightward_gain) rightward_.emplace(*sent.rightward_gain);
    if (sent.leftward_gain) leftward_.emplace(*sent.leftward_gain);
    whole_left_going_ = left_going_.integral(1.0);
    correction_ = right - displacement(1.0);
  }

  double rightward(double place) { return right_going_.value(place) + (rightward_ ? rightward_->value(place) : 0.0); }
  double leftward(double place) { return left_going_.value(1.0 - place) + (leftward_ ? leftward_->value(place) : 0.0); }
  double velocity(double place) { return 0.5 * (rightward(place) + leftward(place)); }
  /// From the left end by the strain; what it misses the right end by, a rounding, is spread over the bar.
  double displacement(double place) {
    double sum = whole_left_going_ - left_going_.integral(1.0 - place) - right_going_.integral(place);
    if (rightward_) sum -= rightward_->integral(place);
    if (leftward_) sum += leftward_->integral(place);
    return left_ + 0.5 * passage_ * sum + place * correction_;
  }

 private:
  // The wave that an end has sent, by the way l that it has come: sent at s - l of this passage, or of the one before.
  class Train {
   public:
    Train(const Piecewise& now, const Piecewise& before, double s)
        : now_(now), before_(before), s_(s), now_integral_(now_.integral(s)), before_integral_(before.integral()) {}
    double value(double way) { return way < s_ ? now_.value(s_ - way) : before_.value(1.0 + s_ - way); }
    double integral(double way) {
      return way < s_ ? now_integral_ - now_.integral(s_ - way)
                      : now_integral_ + before_integral_ - before_.integral(1.0 + s_ - way);
    }

   private:
    Cursor now_, before_;
    double s_, now_integral_, before_integral_;
  };

  double left_, passage_;
  Train right_going_, left_going_;
  std::optional<Cursor> rightward_, leftward_;
  double whole_left_going_ = 0.0, correction_ = 0.0;
};

/// A run of the method `characteristics`. It goes from passage to passage. A passage is the time in which a wave
/// crosses the bar. All that arrives at an end in a passage was sent by the other end in the passage before. So each
/// end answers for itself. What both ends have sent gives output and events.
class Run {
 public:
  Run(const Scene& scene, const Mesh& mesh, const Checkpoint* from, std::span<const double> times,
      const Characteristics& method, const Observers& observers,
      double most_work = std::numeric_limits<double>::infinity());

  PartEnd operator()();

  /// Content of a checkpoint: the state at the beginning of its passage, and how much of the passage has been told.
  static void members(auto& run, auto&& each) {
    each(run.nodes_, run.k_, run.left_, run.right_, run.begin_, run.gain_errors_begin_, run.initial_moment_, run.told_,
         run.largest_);
  }

 private:
  static constexpr double least_passage = 1e-12;     // of the last passage, in passages
  static constexpr double work_of_evaluation = 0.1;  // in pieces that are carried through a passage

  // One end of the bar, with what it has sent.
  struct BarEnd {
    struct Memory {
      End end;
      DrivenEnd::Account driven = {};
      static void members(auto& memory, auto&& each) { each(memory.end, memory.driven); }
    };
    Memory now, begin;  // the latter at the beginning of the passage
    DrivenEnd driven;
    Piecewise moved_if_driven = {}, sent = {}, sent_before = {};
    std::size_t simplified = 0;  // pieces after the last time

    static void members(auto& end, auto&& each) { each(end.sent_before, end.begin, end.simplified); }

    // The wave it sends relative to its wall or obstacle, by which it moves.
    const Piecewise& moved() const { return driven.active() ? moved_if_driven : sent; }
    double displacement_at(double s, double t) const {
      Cursor along(moved());
      return now.end.displacement_at(s, along) + driven.displacement(t);
    }
  };
  BarEnd end_of(const EndCondition& condition, const EndInput& input, const End::Start& data) const;
  static double kinetic(const BarEnd& end, double v) { return 0.5 * end.driven.mass() * v * v; }  // of its mass

  // Sums and largest values so far.
  struct Sums {
    double velocity_scale = 0.0, place_scale = 0.0;
    double work = 0.0, error = 0.0;  // of a varying load; what was simplified
    static void members(auto& self, auto&& each) { each(self.velocity_scale, self.place_scale, self.work, self.error); }
  };

  double time_at(double s) const { return times_.front() + passage_ * (static_cast<double>(k_) + s); }
  // Part of the present passage that has passed at t.
  double part_at(double t) const { return std::fma(-static_cast<double>(k_), passage_, t - times_.front()) / passage_; }
  bool last() const { return k_ == last_passage_; }

  Statistics reached();

  // Account of R = impedance * (arriving wave), over the passages so far.
  void account(EndAccount& account, const BarEnd& end) const;
  ContactPeak peak_of(const BarEnd& end, const ContactPeak& latest) const {
    return {impedance_ * end.driven.force_factor() * latest.reaction,
            std::clamp(time_at(latest.time), times_.front(), times_.back())};
  }
  [[noreturn]] void fail(Failure why, const std::string& what);
  void begin();

  // int f u dx of a steady load: f = (rho c) d(gain)/dx, so by parts no derivative is needed but that of the load's own
  // pieces.
  double moment(std::vector<double> breaks, auto&& displacement) const;
  void go_on(const Checkpoint& checkpoint);

  double worked() const {
    return carried_ + (load_ ? work_of_evaluation * static_cast<double>(load_->evaluations()) : 0.0);
  }

  // Computes the waves that both ends send in passage k.
  void enter();
  void answer(BarEnd& end, const Piecewise& sent, const Piecewise* gain, double until);

  // (w + g)^2 - w^2 of what has arrived.
  double arrived_work(const Piecewise& sent, const Piecewise& gain, double until) const;

  // Places between which the field of this passage is polynomial, at s.
  std::vector<double> breaks_at(double s) const;

  // Work of the load up to s in this passage. Of a load that varies it is what the load has given to waves: to those
  // that have arrived and to those on their way.
  double work_at(double s, Field& now, const std::vector<double>& breaks) const;

  // The most terms of a polynomial in the field.
  std::size_t most_terms() const;
  EnergyState energy_at(double s, Field& now) const;

  struct Told {
    Turn turn;
    Where where;
  };

  void merge_turns();

  // Outputs, events and checkpoints of the present passage; the end of this part of the run, where it is there.
  std::optional<PartEnd> tell_passage();

  // Those before t, and those at t, too, where `and_at`.
  void tell_events(double t, bool and_at);
  double time_of(const Told& event) const { return std::clamp(time_at(event.turn.s), t_, times_.back()); }

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
  const Checkpoint* from_;
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
  BarEnd left_, right_;
  Piecewise arriving_;
  Sums now_, begin_;  // the latter at the beginning of the passage
  LoadGain::Errors gain_errors_begin_;
  double initial_moment_ = 0.0;  // int f u dx
  std::size_t largest_ = 0;

  std::vector<Told> events_;
  std::size_t told_ = 0, skip_ = 0, next_output_ = 0;
  std::vector<double> u_, v_;
};

}  // namespace viscobar::characteristics
