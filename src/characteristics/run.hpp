#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "characteristics/delay_line.hpp"
#include "characteristics/junction.hpp"
#include "characteristics/load_gain.hpp"
#include "dynamics/pieces.hpp"
#include "run/notifier.hpp"
#include "run/parts.hpp"
#include "viscobar/characteristics/characteristics.hpp"

namespace viscobar::characteristics {

/// The data of a bar at the start, over places in lengths of it.
struct InitialData {
  Piecewise displacement, velocity;
  Piecewise strain_velocity;  ///< c u_0'
  double displacement_error = 0.0, velocity_error = 0.0;
};

/// A bar of a scene, from x = begin on.
struct LineBar {
  std::size_t member = 0;
  double begin = 0.0, length = 1.0, density = 1.0, area = 1.0, speed = 1.0;
  double transit() const { return length / speed; }            ///< L / c
  double impedance() const { return area * density * speed; }  ///< A rho c
  double mass() const { return area * density * length; }      ///< A rho L
};
std::vector<LineBar> bars_of(const Scene& scene);
/// The time of a window: the shortest transit.
double window_of(const std::vector<LineBar>& bars);

/// Junctions from left to right, one more than bars; `data` are the bars' own, null where nothing but rates is asked.
/// With `bodies` it lists the member that a body of a junction belongs to, and whether it is its right end.
struct BodyPlace {
  std::size_t body, member;
  bool right;
};
std::vector<Junction> junctions_of(const Scene& scene, const std::vector<LineBar>& bars, double window, double start,
                                   const std::vector<InitialData>* data, std::vector<std::vector<BodyPlace>>* places);

/// Places along the chain as those of x from `begin` on.
NextBreak along(const NextBreak& places, double begin);

/// @throws std::invalid_argument where they are not finite, or the displacement jumps
InitialData initial_data(const Scene& scene, const LineBar& bar);

/// A run of the method `characteristics`. It goes from window to window. A window is the time in which a wave crosses
/// the shortest bar. All that arrives at a junction in a window was sent by others before. So each junction answers for
/// itself. What all have sent gives output and events.
class Run {
 public:
  Run(const Scene& scene, const Mesh& mesh, const Checkpoint* from, std::span<const double> times,
      const Characteristics& method, const Observers& observers,
      double most_work = std::numeric_limits<double>::infinity());

  PartEnd operator()();

  /// Content of a checkpoint: the state at the beginning of its window, and how much of the window has been told.
  static void members(auto& run, auto&& each) {
    each(run.nodes_, run.k_, std::span(run.lines_), std::span(run.junctions_), run.begin_, run.gains_begin_,
         run.initial_moment_, run.told_, run.largest_);
  }

 private:
  static constexpr double least_window = 1e-12;      // of the last window, in windows
  static constexpr double work_of_evaluation = 0.1;  // in pieces that are carried through a window

  // Both ways through a bar.
  struct Line {
    DelayLine rightward, leftward;
    std::size_t simplified[2] = {0, 0};  // pieces after the last time
    static void members(auto& line, auto&& each) {
      each(line.rightward, line.leftward, line.simplified[0], line.simplified[1]);
    }
  };
  // Waves with what a load has given them on their way.
  struct Gained {
    Piecewise at_left, at_right;
  };

  // Sums and largest values so far.
  struct Sums {
    double velocity_scale = 0.0, place_scale = 0.0;
    double work = 0.0, error = 0.0;  // of a varying load; what was simplified
    static void members(auto& self, auto&& each) { each(self.velocity_scale, self.place_scale, self.work, self.error); }
  };

  // The link and its place among all.
  struct Told {
    Junction::Turn turn;
    std::size_t junction;
  };

  double time_at(double s) const { return times_.front() + window_ * (static_cast<double>(k_) + s); }
  // Part of the present window that has passed at t.
  double part_at(double t) const { return std::fma(-static_cast<double>(k_), window_, t - times_.front()) / window_; }
  bool last() const { return k_ == last_window_; }
  const Piecewise& sent_right(std::size_t bar) const { return junctions_[bar].faces.back().sent; }
  const Piecewise& sent_left(std::size_t bar) const { return junctions_[bar + 1].faces.front().sent; }

  Statistics reached();
  void account();
  ContactPeak peak_of(std::size_t junction, std::size_t link, const ContactPeak& latest) const;
  void begin();

  // int f u dx of a steady load: f = (rho c) d(gain)/dx, so by parts no derivative is needed but that of the load's own
  // pieces.
  double moment(std::size_t bar, std::vector<double> breaks, auto&& displacement) const;
  void go_on(const Checkpoint& checkpoint);

  double worked() const;

  // Computes the waves that all junctions send in window k.
  void enter();
  const Piecewise* arriving(std::size_t bar, bool at_left, double until);
  void leave();

  // (w + g)^2 - w^2 of what has arrived.
  double arrived_work(std::size_t bar, const Piecewise& sent, const Piecewise& gain, double until) const;

  // Places between which the field of this window is polynomial, at s.
  std::vector<double> breaks_at(std::size_t bar, double s) const;

  // Work of the load up to s in this window. Of a load that varies it is what the load has given to waves: to those
  // that have arrived and to those on their way.
  double work_at(std::size_t bar, double s, Field& now, const std::vector<double>& breaks);

  // The most terms of a polynomial in the field.
  std::size_t most_terms(std::size_t bar) const;
  EnergyState energy_at(double s, std::vector<Field>& fields);

  void merge_turns();

  // Outputs, events and checkpoints of the present window; the end of this part of the run, where it is there.
  std::optional<PartEnd> tell_window();

  // Those before t, and those at t, too, where `and_at`.
  void tell_events(double t, bool and_at);
  double time_of(const Told& event) const { return std::clamp(time_at(event.turn.s), t_, times_.back()); }

  void tell(const Told& event);
  std::vector<Field> fields(double s, double t);
  void tell_output();
  void finish();

  const Scene scene_;  // formulas are called by one run at a time
  const Mesh mesh_;
  std::size_t nodes_ = mesh_.nodes();  // of the run that a checkpoint is of
  std::span<const double> times_;
  const Observers& observers_;
  const Characteristics method_;
  const double most_work_;
  const Checkpoint* from_;
  double carried_ = 0.0;  // pieces, of all windows
  Statistics statistics_;
  std::size_t load_evaluations_before_;
  Notifier notifier_;
  double t_;
  CheckpointSchedule schedule_;
  std::vector<LineBar> bars_;
  double window_;
  std::vector<InitialData> data_;
  std::vector<std::unique_ptr<LoadGain>> loads_;  // of each bar; none without a load
  std::vector<Line> lines_;
  std::vector<std::vector<BodyPlace>> places_;
  std::vector<Junction> junctions_;
  std::vector<viscobar::Piece> pieces_;  // of the mesh; none without snapshots

  std::size_t k_ = 0, last_window_ = 0;
  std::vector<Gained> gained_;
  Piecewise scratch_;
  Sums now_, begin_;  // the latter at the beginning of the window
  std::vector<LoadGain::Memory> gains_begin_;
  double initial_moment_ = 0.0;  // int f u dx
  std::size_t largest_ = 0;

  std::vector<Told> events_;
  std::size_t told_ = 0, skip_ = 0, next_output_ = 0;
  std::vector<double> u_, v_, joint_forces_;
};

}  // namespace viscobar::characteristics
