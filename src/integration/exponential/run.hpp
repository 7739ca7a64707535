#pragma once

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/jumps/jump_filter.hpp"
#include "dynamics/natural_scales.hpp"
#include "integration/contact_watch.hpp"
#include "integration/exponential/contact_distance.hpp"
#include "integration/exponential/energy_integral.hpp"
#include "integration/snapshot.hpp"
#include "run/framed_parts.hpp"
#include "run/notifier.hpp"
#include "run/watchdog.hpp"

namespace viscobar::exponential {

using Eigen::VectorXd;
using Series = LinearLeg<double>::Series;

/// A run of the exponential method, leg by leg; on a leg no contact changes. A leg begins with steps that one Taylor
/// series covers. They double as long as they resolve the load, a contact change, the energy flow, and a new maximum of
/// the penetration. Where a step may hide one of these, shorter steps look for it, in the end those of the series,
/// which hides nothing.
class Run {
 public:
  Run(const BarSystem& system, const StartingPoint& start, std::span<const double> times, const Penalty& penalty,
      const Observers& observers)
      : system_(system),
        penalised_(system, penalty),
        times_(times),
        observers_(observers),
        snapshot_(penalised_, observers.reactions),
        filter_(system),
        statistics_(statistics_before(start)),
        load_evaluations_before_(statistics_.load_evaluations),
        notifier_(observers, statistics_),
        load_(system, times.front(), times.back()),
        propagators_(penalised_, load_, statistics_.matrix_factorisations),
        distance_(system_, penalised_, load_),
        watchdog_(times.front(), times.back(), 10'000, 1e9),
        t_(begin_of(start, times)),
        schedule_(observers, times, t_) {}

  PartEnd operator()(const StartingPoint& start);

  /// Content of a checkpoint.
  static void members(auto& run, auto&& each) {
    each(std::span(run.y_.data(), static_cast<std::size_t>(run.y_.size())), run.penalised_.contacts(), run.watchdog_,
         run.load_, run.load_jumps_, run.largest_displacement_, run.energy_scale_);
    if (run.ends_) each(*run.ends_);
  }

 private:
  static constexpr int patience = 8;  // steps before a length that failed is tried again
  static constexpr int max_load_jumps = 1000;
  static constexpr double rounding = std::numeric_limits<double>::epsilon();

  const LinearLeg<double>& leg() const { return propagator_->leg(); }
  std::size_t contacts() const { return penalised_.contacts().size(); }
  Index node(std::size_t c) const { return distance_.node(c); }
  ContactDistance::Largest largest() const { return {largest_displacement_, statistics_.max_penetration}; }
  double run_length() const { return times_.back() - times_.front(); }
  double shortest_step() const { return 4.0 * rounding * std::max(std::abs(t_), times_.back() - times_.front()); }

  Statistics reached();
  void close_energy();  // of a run that could not go on

  void finish_energy(double t, std::span<const double> u, std::span<const double> w);
  void as_work_on_followers(auto&& change);  // the energy that a change gives them
  void enter_piece();                        // of time, from here on, in which the load is smooth
  void pass_kink();                          // where what holds or bounds an end changes its velocity at once
  // Puts high modes at their equilibrium (see JumpFilter): at the start, or where the load breaks.
  void settle_high_modes(bool starting);
  void leave_obstacles(const std::vector<std::size_t>& left, std::span<double> u, std::span<double> w);
  // The unknown whose displacement is the first of y.
  std::size_t first_displacement() const {
    return static_cast<std::size_t>(leg().displacements()) == system_.size() ? 0 : system_.inertia().massive_begin();
  }
  double& displacement_of(Index node) { return y_[node - static_cast<Index>(first_displacement())]; }
  // Displacements, measured as the contacts do, and velocities of all unknowns: what y has, the state, and back.
  State unpacked() const;
  State state();
  void put(std::span<const double> u, std::span<const double> w);
  void begin(const State& start);
  void go_on(const Checkpoint& checkpoint);
  void watch_ends();

  // The entries of (u, u') that ContactWatch samples.
  std::span<const double> end_sample(const Series& series, double sigma, double tau);
  double sign(std::size_t c) const { return penalised_.contacts()[c].sign; }

  // Measures the displacement of a node from the obstacle that it has come to: the penetration keeps all its digits.
  void measure_from_obstacle(std::size_t closing);
  void begin_leg();

  // True if it made a step; else the next one is to be shorter.
  bool advance();

  // A force that displaces the bar by less than the rounding of its displacement: over the run by T^2 / mass, and a
  // massless node by h / E.
  double negligible_load() const;

  void shorten() { --level_, wait_ = patience; }
  void lengthen() { wait_ > 0 ? --wait_ : ++level_; }

  // A step by matrix exponentials, unless it may hide something: it looks at quarters of the step for contacts, at
  // eighths for the energy flow and the motion of the ends.
  bool take_long_step(double tau);

  // Over a long step; absent where the step may hide some of it.
  std::optional<SampledFlow> resolved_flow(const std::vector<Series>& motion, double tau, double penetration) const;
  StepPower power(const Series& motion, double tau) const { return {penalised_, t_, tau, motion, load_.total(p_)}; }

  // Rounding error of the power of the end rows: the row (rho h / 24) (3, 4, 1) times accelerations, by forces
  // that are differences of rounded displacements and velocities, times what the step has changed velocities by.
  double end_power_rounding(const std::vector<Series>& motion, double tau) const;

  // A step that one Taylor series covers, cut at the first contact change.
  void take_short_step(double tau);

  // The bar may come to an obstacle that moves in this step: from its beginning on the frame follows it. A kink there
  // has been passed.
  void follow(const Series& series, double tau);

  // Contact `first` reaches its change; so do those that are at theirs up to rounding and go on.
  void change_contacts(std::size_t first, const std::vector<VectorXd>& distances,
                       const std::vector<std::optional<ContactDistance::Push>>& pushes, double sigma,
                       const VectorXd& v);
  void tell_change(std::size_t c, double velocity);

  // Tells the solution at the output times up to t, which lie in the current step, of length tau; it is bisected for
  // them. `flow_until` gives the energy that has flown at a part of the step.
  void output_until(double t, double tau, const std::function<EnergyFlow(double)>& flow_until);
  void tell_snapshot(double t, const VectorXd& u, const VectorXd& v, const Series& series, const LoadPolynomial& p,
                     double sigma, const std::optional<EnergyState>& energy);

  // True if energy flows that somebody wants to know.
  bool energy_flows() const;
  void add(const EnergyFlow& flow);

  const BarSystem& system_;
  PenalisedSystem penalised_;
  std::span<const double> times_;
  const Observers& observers_;
  SnapshotBuilder snapshot_;
  JumpFilter filter_;
  Statistics statistics_;
  std::size_t load_evaluations_before_;
  Notifier notifier_;

  LoadInterpolation load_;
  PropagatorCache propagators_;
  ContactDistance distance_;
  std::optional<ContactWatch> ends_;
  std::vector<std::size_t> end_entries_;  // that it samples
  std::vector<double> sampled_;
  Propagator* propagator_ = nullptr;
  Watchdog watchdog_;

  std::optional<Checkpoint> entered_;  // of a frame that the next part is in

  double t_;
  double piece_end_ = 0.0;  // of the piece in which the load is smooth
  CheckpointSchedule schedule_;
  VectorXd y_;
  LoadPolynomial p_;  // on the current step
  int level_ = 0;     // of the current step; below 0 where the load asks for less than a Taylor series could do
  int wait_ = 0;      // steps until a longer one is tried
  int load_jumps_ = 0;
  std::size_t next_output_ = 0;
  double largest_displacement_ = 0.0;
  double energy_scale_ = 0.0;
};

}  // namespace viscobar::exponential
