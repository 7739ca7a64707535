#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/energy_terms.hpp"
#include "dynamics/jumps/jump_filter.hpp"
#include "integration/layout.hpp"
#include "integration/snapshot.hpp"
#include "integration/stepper.hpp"

namespace viscobar {

/// Energy account of a run by steps,
///
///     E(end) - E(begin) = work - dissipation,
///
/// whose entries are those of the layout in the state y where the run is, with what frames, jumps and impacts add.
/// Where no energy is asked for, nothing is kept.
class EnergyBooks {
 public:
  /// All outlive it; `duration` is that of the whole run.
  EnergyBooks(PenalisedSystem& system, const Layout& layout, LegStepper& stepper, Statistics& statistics,
              std::vector<double>& y, double duration)
      : system_(system),
        layout_(layout),
        stepper_(stepper),
        statistics_(statistics),
        y_(y),
        duration_(duration),
        inner_(layout.size) {}

  /// Begins the account of a run, at t.
  void open(double t);
  /// A leg begins: its account is the stepper's own.
  void begin_leg() { shift_ = {}; }
  /// The step from `from` to `to` is made: its account is that of Gauss' formula where the stepper's may be spoilt.
  void enter_step(double from, double to);
  /// The step counts up to `at`.
  void leave_step(double at);
  /// Makes y the state at a time within the last step.
  void interpolate(double t);
  /// Looks for the largest energies on the way, at the end of the last step.
  void notice(double t);

  /// Energy that an impact or a stop takes.
  void dissipate(double energy) { add(layout_.dissipated, energy); }
  /// Energy that an impact loses in the end rows of the mass.
  void lose_in_end_rows(double energy) { add(layout_.end_inertia, energy); }
  /// Energy of the high modes of the mesh that a jump has lost.
  void take(const JumpFilter::Taken& taken);
  /// Books the energy that a change of the state brings as work.
  void as_work(auto&& change) {
    const double before = layout_.work ? stored() : 0.0;
    change();
    if (layout_.work) y_[*layout_.work] += stored() - before;
  }
  /// The frame of y becomes another one, whose energy is larger by that: y may get an entry for its work.
  void enter_frame(double gained);

  /// The account as it is in a snapshot of y.
  EnergyState at(const Snapshot& now, const SnapshotBuilder& builder);
  /// Closes the account, where the run ends or stops.
  void close(double t);

 private:
  std::span<double> u() const { return layout_.u(y_); }
  std::span<double> w() const { return layout_.w(y_); }
  double entry(std::optional<std::size_t> of) const { return of ? y_[*of] : 0.0; }
  void add(std::optional<std::size_t> to, double energy) {
    if (to) y_[*to] += energy;
  }
  double stored() const { return energy(system_.contacts(), u(), w()); }
  std::array<double, 3> corrected(double from, double to);

  PenalisedSystem& system_;
  const Layout& layout_;
  LegStepper& stepper_;
  Statistics& statistics_;
  std::vector<double>& y_;
  double duration_;
  std::vector<double> inner_;             // a state within a step
  std::array<double, 3> shift_{};         // of the leg's account
  std::optional<double> doubtful_since_;  // begin of a step whose account may be spoilt
};

}  // namespace viscobar
