#pragma once

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "dynamics/energy_terms.hpp"
#include "integration/accounts/contact_watch.hpp"
#include "integration/exponential/energy_integral.hpp"
#include "integration/exponential/motion.hpp"
#include "integration/snapshot.hpp"
#include "run/notifier.hpp"
#include "run/watchdog.hpp"

namespace viscobar::exponential {

/// The accounts of a run, and those whom the motion is told to.
class Books : protected Motion {
 protected:
  Books(const BarSystem& system, const StartingPoint& start, std::span<const double> times, const Penalty& penalty,
        const Observers& observers)
      : Motion(system, penalty, times, begin_of(start, times)),
        times_(times),
        observers_(observers),
        before_(statistics_before(start)),
        statistics_(before_),
        snapshot_(penalised_, observers.reactions),
        notifier_(observers, statistics_),
        watchdog_(times.front(), times.back(), 10'000, 1e9) {}

  ContactDistance::Largest largest() const { return {largest_displacement_, statistics_.max_penetration}; }

  Statistics reached() {
    statistics_.reached_time = t_;
    statistics_.load_evaluations = before_.load_evaluations + load_.evaluations() + penalised_.load().evaluations();
    statistics_.matrix_factorisations = before_.matrix_factorisations + exponentials_;
    notifier_.count_seconds();
    return statistics_;
  }

  // Ends the account of a run that could not go on.
  void close_energy() {
    if (!statistics_.energy || y_.size() == 0) return;
    try {
      State now = state();
      penalised_.complete_velocity(t_, now.u, now.v);
      finish_energy(t_, now.u, now.v);
    } catch (const std::exception&) {  // the cause of the failure may stop this, too
    }
  }

  void finish_energy(double t, std::span<const double> u, std::span<const double> w) {
    const double of_frame = frame_energy(penalised_, t, u, w);
    statistics_.energy->final = energy(contacts(), u, w) + of_frame;
    statistics_.energy->work += of_frame;
  }

  // Undamped nodes without mass follow their rows at once. Where a load jumps, or opens or closes their contact by
  // that, the energy that it gives them is its work.
  void as_work_on_followers(auto&& change) {
    const bool follow = statistics_.energy && system_.inertia().has_massless() && !system_.bar().damped();
    const std::vector<double> still(system_.size());
    const auto stored = [&] { return follow ? energy(contacts(), state().u, still) : 0.0; };
    const double before = stored();
    change();
    if (follow) statistics_.energy->work += stored() - before;
  }

  void watch_ends() {
    ends_.emplace(penalised_, *statistics_.account);
    ends_->ask_for(end_entries_);
    sampled_.resize(end_entries_.size());
  }

  void tell_change(std::size_t c, double velocity) {
    watchdog_.change(t_, c);
    if (system_.frame().moving()) velocity += system_.frame().lift_at(contacts()[c], penalised_.load().lift(t_, 1));
    notifier_.event(t_, system_.unknowns().first_node(), contacts()[c],
                    contacts().closed(c) ? Change::closing : Change::opening, velocity);
  }

  // The entries of (u, u') that ContactWatch samples.
  std::span<const double> end_sample(const Series& series, double sigma, double tau) {
    const auto n = static_cast<std::size_t>(series.rows());
    for (std::size_t k = 0; k < end_entries_.size(); ++k) {
      const bool rate = end_entries_[k] >= n;
      const auto row = series.row(static_cast<Index>(rate ? end_entries_[k] - n : end_entries_[k]));
      double sum = 0.0;
      for (Index j = row.size(); j-- > (rate ? 1 : 0);)
        sum = sum * sigma + (rate ? static_cast<double>(j) : 1.0) * row[j];
      sampled_[k] = rate ? sum / tau : sum;
    }
    return sampled_;
  }

  StepPower power(const Series& motion, double tau) const { return {penalised_, t_, tau, motion, load_.total(p_)}; }

  // Tells the solution at the output times up to t, which lie in the current step, of length tau; it is bisected for
  // them. `flow_until` gives the energy that has flown at a part of the step.
  void output_until(double t, double tau, const std::function<EnergyFlow(double)>& flow_until) {
    for (; next_output_ < times_.size() && times_[next_output_] <= t; ++next_output_) {
      const bool last = next_output_ + 1 == times_.size();
      if (!observers_.snapshot && !(last && statistics_.energy)) continue;
      const Part part = part_at(times_[next_output_], tau);
      const VectorXd u = leg().displacement(part.series, part.sigma),
                     v = leg().velocity(part.series, part.sigma, part.length);
      double of_frame = 0.0;
      if (last && statistics_.energy)
        finish_energy(times_[next_output_], entries(u), entries(v));
      else if (statistics_.energy)
        of_frame = frame_energy(penalised_, times_[next_output_], entries(u), entries(v));
      if (!observers_.snapshot) continue;
      std::optional<EnergyState> energy;
      if (statistics_.energy) {
        const EnergyFlow flow = flow_until((times_[next_output_] - t_) / tau);
        energy = EnergyState{.dissipated = statistics_.energy->dissipated + flow.dissipated + flow.end_inertia,
                             .work = statistics_.energy->work + flow.work + of_frame,
                             .end_inertia = statistics_.energy->end_inertia + flow.end_inertia};
      }
      tell_snapshot(times_[next_output_], u, v, part, energy);
    }
  }

  void tell_snapshot(double t, const VectorXd& u, const VectorXd& v, const Part& part,
                     const std::optional<EnergyState>& energy) {
    Snapshot snapshot = snapshot_(t, entries(u), entries(v));
    if (energy) snapshot.energy = snapshot_.energy(snapshot, entries(u), *energy);
    // A node that follows its row: again by what that is judged by, which keeps the digits of the penetration.
    for (std::size_t c = 0; c < contacts().size(); ++c) {
      if (!contacts().closed(c) || contacts()[c].joint > 0 || !(distance_.follows(c) || contacts()[c].holds)) continue;
      const double depth = distance_.penetration_share(c) * value(distance_.along(c, part.series, part.p), part.sigma);
      (node(c) == 0 ? snapshot.reaction_left : snapshot.reaction_right) =
          sign(c) * contacts()[c].law.linear().reaction(depth, -sign(c) * v[node(c)]);
    }
    notifier_.snapshot(snapshot);
  }

  // True if energy flows that somebody wants to know.
  bool energy_flows() const {
    return statistics_.energy && (takes_energy(contacts()) || system_.loaded() || system_.has_end_rows());
  }

  void add(const EnergyFlow& flow) {
    statistics_.energy->dissipated += flow.dissipated + flow.end_inertia;
    statistics_.energy->work += flow.work;
    statistics_.energy->end_inertia += flow.end_inertia;
    statistics_.energy->notice(statistics_.energy->dissipated, statistics_.energy->work);
    energy_scale_ = std::max(energy_scale_, statistics_.energy->initial + std::abs(statistics_.energy->work));
  }

  std::span<const double> times_;
  const Observers& observers_;
  Statistics before_, statistics_;  // of the parts before, and with those of this one
  SnapshotBuilder snapshot_;
  Notifier notifier_;
  std::optional<ContactWatch> ends_;
  std::vector<std::size_t> end_entries_;  // that it samples
  std::vector<double> sampled_;
  Watchdog watchdog_;
  std::size_t next_output_ = 0;
  double energy_scale_ = 0.0;
};

}  // namespace viscobar::exponential
