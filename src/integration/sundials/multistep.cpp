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
  recorder_ = make_recorder(record_, context_);
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

// Those of x_k are c_0 = 1, c_k = c_{k-1} (d + a_k) / b_k, d = t - t_n: of Nordsieck's array a_k = 0 and b_k = h, of
// divided differences a_k = b_{k-1}, and the b_k follow from the factors at one time within the step.
void Multistep::find_factors(double begin, double end) {
  double now = 0.0, h = 0.0;
  call("GetCurrentTime", library_.get_current_time, &now);
  call("GetLastStep", library_.get_last_step, &h);
  const double time = now - 0.5 * h, middle = time - now;
  call("GetDky", library_.get_dky, time, 0, recorder_.get());
  // A step of one rounding of the time has no such time. At both of its ends the factors behind the first are 0.
  const bool within = -h < middle && middle < 0.0;
  const std::size_t q = order(), count = record_.count;
  const auto place = [&](std::size_t k) { return library_.divided_differences ? k : count - 1 - k; };
  PointValues d{};
  for (std::size_t j = 0; j <= q; ++j) d[j] = point_of(begin, end, q, j) - now;
  factors_[place(0)].fill(1.0);
  double a = 0.0, b = h;
  for (std::size_t k = 1; k < count; ++k) {
    if (library_.divided_differences && !within && k > 1) {
      factors_[place(k)].fill(0.0);
      continue;
    }
    if (library_.divided_differences && within) b = (middle + a) * record_.factors[k - 1] / record_.factors[k];
    for (std::size_t j = 0; j < d.size(); ++j) factors_[place(k)][j] = factors_[place(k - 1)][j] * ((d[j] + a) / b);
    if (library_.divided_differences) a = b;
  }
}

std::span<const PointValues> Multistep::form_samples(double begin, double end) {
  if (forms_.empty()) return {};
  find_factors(begin, end);
  gathered_.resize(form_entries_.size());
  for (std::size_t k = 0; k < record_.count; ++k)
    for (std::size_t i = 0; i < form_entries_.size(); ++i) gathered_[i][k] = record_.terms[k][form_entries_[i]];
  // In vectors of as many lanes as the points take.
  const auto sample = [&]<std::size_t lanes>(std::integral_constant<std::size_t, lanes>) {
    for (std::size_t i = 0; i < forms_.size(); ++i) {
      const Points<lanes> terms = forms_[i].of_points<lanes>(gathered_);
      Points<lanes> sum = Points<lanes>::Zero();
      for (std::size_t k = 0; k < record_.count; ++k)
        sum += terms[static_cast<Eigen::Index>(k)] * Points<lanes>::Map(factors_[k].data());
      Points<lanes>::Map(form_points_[i].data()) = sum;
    }
  };
  order() < 8 ? sample(std::integral_constant<std::size_t, 8>()) : sample(std::integral_constant<std::size_t, 16>());
  return form_points_;
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
