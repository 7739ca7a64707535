#include "integration/accounts/energy_books.hpp"

#include <algorithm>
#include <utility>

#include "integration/accounts/energy_flow.hpp"

namespace viscobar {

void EnergyBooks::open(double t) {
  const double of_frame = frame_energy(system_, t, u(), w());
  statistics_.energy = EnergyAccount{.initial = stored() + of_frame};
  if (layout_.work) y_[*layout_.work] = -of_frame;
}

// The stepper's correction is several times its error, which is a fraction of it that falls with the order. It counts
// where it is more than the step's share of what the motion's own error does.
void EnergyBooks::enter_step(double from, double to) {
  if (layout_.account() == 0) return;
  const double share = (to - from) / duration_;
  if (stepper_.account_correction() > share * stepper_.weights().promised_energy()) doubtful_since_ = from;
}

void EnergyBooks::leave_step(double at) {
  if (!doubtful_since_) return;
  shift_ = corrected(*doubtful_since_, at);
  doubtful_since_.reset();
}

void EnergyBooks::interpolate(double t) {
  const std::array<double, 3> shift = doubtful_since_ ? corrected(*doubtful_since_, t) : shift_;
  stepper_.interpolate(t, y_);
  for (std::size_t k = 0; k < layout_.account(); ++k) y_[2 * layout_.nodes + k] += shift[k];
}

// The power of a motion of frequency omega has one of 2 omega: where the formulas just resolve omega at a high order,
// their account of the power may be a thousand times worse. Gauss' formula integrates it over the step instead.
std::array<double, 3> EnergyBooks::corrected(double from, double to) {
  const std::size_t first = 2 * layout_.nodes, count = layout_.account();
  std::array<double, 3> shift = shift_;
  for (const auto& [at, sign] : {std::pair{to, -1.0}, {from, 1.0}}) {
    stepper_.interpolate(at, inner_);
    for (std::size_t k = 0; k < count; ++k) shift[k] += sign * inner_[first + k];
  }
  add_energy_flow<5>(
      system_, layout_, from, to, [&](double t, std::span<double> y) { stepper_.interpolate(t, y); },
      [&](double t) { return stepper_.accelerations(t); }, inner_, shift);
  return shift;
}

// In a frame that moves its energy is not known at the end of a step; the bar's is of that size.
void EnergyBooks::notice(double t) {
  const std::span<const double> account = stepper_.account();
  const auto entry = [&](std::optional<std::size_t> at) { return at ? account[*at - 2 * layout_.nodes] : 0.0; };
  EnergyAccount& energy = *statistics_.energy;
  energy.notice(entry(layout_.dissipated) + entry(layout_.end_inertia) + energy.end_inertia, entry(layout_.work));
  const Bar& bar = system_.bar().bar();
  if (!system_.bar().frame().moving()) return;
  const Lift rate = system_.load().lift(t, 1);
  energy.largest = std::max({energy.largest, 0.5 * bar.density * bar.length * rate.left * rate.left,
                             0.5 * bar.density * bar.length * rate.right * rate.right});
}

void EnergyBooks::take(const JumpFilter::Taken& taken) {
  if (!statistics_.energy) return;
  statistics_.energy->end_inertia += taken.energy;
  add(layout_.work, taken.work);
}

void EnergyBooks::enter_frame(double gained) {
  if (layout_.work)
    y_[*layout_.work] -= gained;
  else if (statistics_.energy)  // the other frame has a load
    y_.insert(y_.begin() + static_cast<std::ptrdiff_t>(2 * layout_.nodes + (layout_.dissipated ? 1 : 0)), -gained);
}

EnergyState EnergyBooks::at(const Snapshot& now, const SnapshotBuilder& builder) {
  EnergyState state = builder.energy(now, u());
  state.end_inertia = statistics_.energy->end_inertia + entry(layout_.end_inertia);
  state.dissipated = entry(layout_.dissipated) + state.end_inertia;
  state.work = entry(layout_.work) + frame_energy(system_, now.time, u(), w());
  return state;
}

void EnergyBooks::close(double t) {
  if (!statistics_.energy) return;
  EnergyAccount& energy = *statistics_.energy;
  const double of_frame = frame_energy(system_, t, u(), w());
  energy.final = stored() + of_frame;
  if (layout_.dissipated) energy.dissipated = y_[*layout_.dissipated];
  if (layout_.work) energy.work = y_[*layout_.work] + of_frame;
  energy.end_inertia += entry(layout_.end_inertia);
  energy.dissipated += energy.end_inertia;
}

}  // namespace viscobar
