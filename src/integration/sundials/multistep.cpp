#include "integration/sundials/multistep.hpp"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

namespace viscobar::sundials {

Multistep::Multistep(const MultistepLibrary& library, const StepperParts& parts, const Tolerance& tolerance,
                     void (*solve_step)(Leg&, std::span<double>), bool passes_over_rest)
    : leg_(parts.system, parts.layout, parts.statistics, parts.derivatives, solve_step),
      weights_(parts.system, parts.layout, tolerance, parts.times.back(), multistep_accumulation, parts.derivatives),
      end_(parts.times.back()),
      state_(make_vector(parts.layout.size, context_)),
      library_(library),
      passes_over_rest_(passes_over_rest),
      interpolated_(make_vector(parts.layout.size, context_)),
      solver_(make_step_solver(leg_, context_)) {}

void Multistep::begin_run(std::vector<std::size_t> sampled_entries) {
  probed_.emplace(std::move(sampled_entries));
  probe_ = make_probe(*probed_, context_);
  hull_ = make_hull(*probed_, context_);
}

void Multistep::restart(double t, double stop, std::span<const double> y) {
  stop_ = stop;
  weights_.tighten(leg_.statistics.events);
  std::ranges::copy(y, values(state_).begin());
  rest_.begin_leg(leg_.system.contacts(), t);
  begin_leg(t);
}

double Multistep::advance() {
  const auto [name, flag] = step();
  require_memory();
  if (flag < 0) fail(leg_, library_.prefix + name, flag, flag_name(library_.flag_name(flag)), library_.flags);
  if (passes_over_rest_) advice_ = rest_.stepped(t_, leg_.layout.w(values(state_)), weights_.promised_velocity());
  return t_;
}

void Multistep::before_step() {
  switch (std::exchange(advice_, RestWatch::Advice::go_on)) {
    case RestWatch::Advice::go_on: return;
    case RestWatch::Advice::damp: begin_bdf(2, t_); return weights_.pass_over(rest_.oscillation());
    case RestWatch::Advice::release:
      weights_.pass_over(0.0);
      return call("SetMaxOrd", library_.set_max_order, highest_bdf);
    case RestWatch::Advice::give_back: return begin_bdf(highest_bdf, t_);
  }
}

std::size_t Multistep::order() const {
  int order = 1;
  library_.get_last_order(leg_.memory, &order);
  return static_cast<std::size_t>(order);
}

void Multistep::interpolate(double t, std::span<double> y) {
  call("GetDky", library_.get_dky, t, 0, interpolated_.get());
  std::ranges::copy(values(interpolated_), y.begin());
}

std::span<const double> Multistep::accelerations(double t) {
  call("GetDky", library_.get_dky, t, 1, interpolated_.get());
  return leg_.layout.w(values(interpolated_));
}

std::span<const double> Multistep::sample(double t, int derivative) {
  call("GetDky", library_.get_dky, t, derivative, probe_.get());
  return values(probe_);
}

bool Multistep::hull(std::span<double> lowest, std::span<double> highest, std::span<double> last) {
  double end = 0.0;
  call("GetCurrentTime", library_.get_current_time, &end);
  call("GetDky", library_.get_dky, end, 0, hull_.get());
  const double* bounds = values(hull_).data();
  for (const std::span<double> out : {lowest, highest, last})
    bounds = std::ranges::copy_n(bounds, static_cast<std::ptrdiff_t>(out.size()), out.begin()).in;
  return true;
}

void Multistep::configure(void* memory, double t) {
  leg_.memory = memory;
  const auto fill_weights = [](N_Vector y, N_Vector weights, void* user) noexcept {
    static_cast<Multistep*>(user)->weights_.fill(values(y), values(weights));
    return 0;
  };
  call("SetUserData", library_.set_user_data, static_cast<void*>(this));
  call("WFtolerances", library_.set_weights, fill_weights);
  call("SetNonlinearSolver", library_.set_solver, solver_.get());
  if (leg_.system.load().varies()) call("SetMaxStep", library_.set_max_step, longest_step(leg_.system, end_ - t));
}

void Multistep::begin_stretch(void* memory, int max_order) {
  leg_.memory = memory;
  call("SetMaxOrd", library_.set_max_order, max_order);
  call("SetStopTime", library_.set_stop_time, stop_);
  advice_ = RestWatch::Advice::go_on;
  weights_.pass_over(0.0);
}

void Multistep::check(const char* name, int flag) {
  require_memory();
  if (flag != 0) fail(leg_, library_.prefix + name, flag, flag_name(library_.flag_name(flag)), library_.flags);
}

}  // namespace viscobar::sundials
