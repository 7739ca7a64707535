#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "schemes/lane_scheme.hpp"

// The start and the run of TimeStep and of fully_discrete once more: those branch where a lane can only mask, keep the
// energy, and find their contacts in a list of any length. Shared code would be slower in one of the two.

namespace viscobar::bars {

namespace {

using std::experimental::where;
using Mask = Lanes::mask_type;

template <class Value>
Lanes gathered(std::span<const Member> bars, Value&& value) {
  std::array<double, lane_count> values;
  for (std::size_t l = 0; l < lane_count; ++l) values[l] = value(bars[std::min(l, bars.size() - 1)]);
  return load_lanes(values.data());
}

}  // namespace

void LaneScheme::load_bars(std::span<const Member> bars) {
  for (const bool right : {false, true}) {
    gap_[right] = gathered(bars, [&](const Member& one) { return one.gap[right]; });
    spring_[right] = gathered(bars, [&](const Member& one) { return one.stiffness[right]; });
    dashpot_[right] = gathered(bars, [&](const Member& one) { return one.dashpot[right]; });
    mass_[right] = gathered(bars, [&](const Member& one) { return one.mass[right]; });
    wall_[right] = gathered(bars, [&](const Member& one) { return one.wall[right]; });
  }
  restitution_ = gathered(bars, [](const Member& one) { return one.restitution; });
  rebounds_ = std::experimental::any_of(restitution_ > 0.0);
  inertia_ = gathered(bars, [](const Member& one) { return one.bar.density * one.bar.length; });
  modulus_ = gathered(bars, [](const Member& one) { return one.bar.modulus / one.bar.length; });
  viscosity_ = gathered(bars, [](const Member& one) { return one.bar.viscosity / one.bar.length; });
  for (std::size_t i = 0; i < size_; ++i) {
    u_[i] = gathered(bars, [&](const Member& one) { return one.start->u[i]; });
    p_[i] = gathered(bars, [&](const Member& one) { return one.start->v[i]; });
  }
  const std::vector<double>& stretch = pattern_.stretch;
  graded_ = !pattern_.is_of_alike();
  scale_ = graded_ ? modulus_ : stretch[1] * modulus_;
  inverse_scale_ = 1.0 / scale_;
  relaxation_ = viscosity_ / modulus_;
  own_loads_.clear();
  for (std::size_t l = 0; l < lane_count; ++l) own_loads_.push_back(bars[std::min(l, bars.size() - 1)].load);
  const bool shared = std::ranges::all_of(own_loads_, [&](const auto* one) { return one == own_loads_.front(); });
  shared_load_ = shared ? own_loads_.front() : nullptr;
  loaded_ = std::ranges::any_of(own_loads_, [](const auto* one) { return one; });
  varying_ = false;
  for (const auto* load : own_loads_)
    for (std::size_t k = 0; load && k < load->size(); ++k) varying_ |= static_cast<bool>((*load)[k].history);
}

// A massless node has no initial velocity: see TimeStep.
void LaneScheme::settle_massless(bool right) {
  const std::size_t end = right ? size_ - 1 : 0, next = right ? size_ - 2 : 1;
  const double s = pattern_.sign[right], h = 1.0 / pattern_.stretch[right ? size_ - 1 : 1];
  // All by the bar's length.
  const auto rest_stretch = [&](double t, const Lanes& relaxed, const Lanes& memory) {
    Lanes pull = 0.0;
    if (loaded_) {
      if (varying_) evaluate_load(t);
      pull = h * load_[end];
    }
    return (memory * relaxed + pull) / (memory + modulus_);
  };
  const Mask undamped = viscosity_ == 0.0;
  if (std::experimental::any_of(undamped))
    where(undamped, u_[end]) = s * larger(s * (u_[next] + rest_stretch(0.0, 0.0, 0.0)), -gap_[right]);
  const Lanes stretch = rest_stretch(dt_, u_[end] - u_[next], viscosity_ / dt_);
  p_[end] = (u_[next] + dt_ * p_[next] + stretch - u_[end]) / dt_;
}

[[gnu::flatten]] Lanes LaneScheme::largest_of(const std::vector<Lanes>& field) {
  Lanes largest = 0.0;
  for (const Lanes& value : field) largest = larger(largest, abs(value));
  return largest;
}

void LaneScheme::start_from(bool second_order) {
  const std::vector<Lanes> v = p_;
  start_impulse_ = {};
  if (loaded_) evaluate_load(0.0);
  bound();
  if (second_order) {
    factorise(dt_ / 2, dt_ * dt_ / 2, dt_ / 2);
    sweep();
    react();
    std::vector<Lanes> kick = y_;
    finish(kick);
    if (pattern_.contact[1])
      for (std::size_t i = 0; i < size_; ++i) kick[i] += reaction_[1] * column_[1][i];
    for (const bool of : {false, true}) {
      if (!pattern_.contact[of]) continue;
      where(active_[of] != 0.0, kick[of ? size_ - 1 : 0]) = pattern_.sign[of] * bound_[of];
      start_impulse_[of] = dt_ / 2 * reaction_[of];
    }
    for (std::size_t i = 0; i < size_; ++i) p_[i] += kick[i];
  }
  for (const bool right : {false, true})
    if (pattern_.massless[right]) settle_massless(right);
  project_start();
  for (std::size_t i = 0; i < size_; ++i) {
    x_[i] = 2.0 * (p_[i] - v[i]);
    u_[i] += dt_ * p_[i];
  }
  end_x_ = {x_[0], x_[size_ - 1]};
  for (const bool right : {false, true}) {
    if (!pattern_.contact[right]) continue;
    Lanes& u = u_[right ? size_ - 1 : 0];
    u = pattern_.sign[right] * larger(pattern_.sign[right] * u, lower_[right]);
  }
}

bool LaneScheme::run(std::span<const Member> bars, const Stepping& how, const LaneOutputs& outputs,
                     LaneAccounts& accounts) {
  const std::size_t n = size_, last = n - 1;
  dt_ = how.step;
  const double dt = dt_;
  const auto steps = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(how.end / dt * (1.0 - 1e-12))));
  load_bars(bars);
  fields_ = outputs.fields;
  const auto datum = [&](std::vector<double> State::*field, std::size_t i) {
    return gathered(bars, [&](const Member& one) { return (one.data->*field)[i]; });
  };
  const std::array<Lanes, 2> u_start = {u_[0], u_[last]};
  std::array<Lanes, 2> touching{};  // 1 where the start touches
  for (const bool right : {false, true})
    if (pattern_.contact[right])
      where(pattern_.sign[right] * u_start[right] + gap_[right] <= 0.0, touching[right]) = 1.0;
  start_from(how.second_order);
  if (!factorise(dt / 2, dt * dt / 2, dt)) return false;

  const auto node = [last](bool right) { return right ? last : 0; };
  std::swap(x_, x_before_);
  end_x_before_ = end_x_;
  if (varying_) evaluate_load(dt);
  was_active_ = {};
  sweep();
  bound();
  react();
  accounts = {};
  for (const bool right : {false, true}) {
    if (!pattern_.contact[right]) continue;
    reaction_before_[right] = touching[right] * reaction_[right];
    accounts.impulse[right] = pattern_.sign[right] * start_impulse_[right];
    accounts.peak[right] = reaction_before_[right];
  }

  std::array<double, lane_count> largest{};
  const auto tell = [&](std::size_t lane, double t) {
    if (t > how.end) return;
    if (accounts.changes[lane].size() < outputs.most_changes) accounts.changes[lane].push_back(t);
  };
  // See close_at_start() of fully_discrete.
  for (const double t : {0.0, dt})  // in the order of time
    for (const bool right : {false, true}) {
      if (!pattern_.contact[right]) continue;
      const double s = pattern_.sign[right];
      const Lanes moved = s * u_[node(right)] + gap_[right], came = s * datum(&State::v, node(right));
      for (std::size_t lane = 0; lane < lane_count; ++lane) {
        const bool there = t == 0.0 ? touching[right][lane] != 0.0 : moved[lane] <= 0.0;
        if (was_active_[right][lane] != 0.0 || !there || !(came[lane] < 0.0)) continue;
        was_active_[right][lane] = 1.0, changes_ = true;
        tell(lane, t);
      }
    }
  const auto find_changes = [&](double t, double next) {
    if (!changes_ || outputs.most_changes == 0) return;
    const Lanes sizes = largest_of(u_), loads = loaded_ ? largest_of(load_) : Lanes(0.0);
    const auto end_mass = [&](bool right, std::size_t lane) {
      const double h = 1.0 / pattern_.stretch[right ? last : 1];
      return inertia_[lane] * h / 2.0;  // rho L times the element's share of L
    };
    for (std::size_t lane = 0; lane < lane_count; ++lane) {
      if (active_[0][lane] == was_active_[0][lane] && active_[1][lane] == was_active_[1][lane]) continue;
      const double size = sizes[lane];
      for (const bool right : {false, true})
        if (pattern_.contact[right])
          largest[lane] =
              std::max({largest[lane], static_cast<double>(loads[lane]), static_cast<double>(reaction_[right][lane]),
                        static_cast<double>(reaction_before_[right][lane]), end_mass(right, lane) * size / (dt * dt)});
      for (const bool right : {false, true})
        if (was_active_[right][lane] != 0.0 && active_[right][lane] == 0.0) {
          was_active_[right][lane] = 0.0;
          tell(lane, t);
        }
      constexpr double rounding = 64.0 * std::numeric_limits<double>::epsilon();
      for (const bool right : {false, true}) {
        if (active_[right][lane] == 0.0 || was_active_[right][lane] != 0.0) continue;
        const double velocity = p_[node(right)][lane];
        if (!(std::max(static_cast<double>(reaction_[right][lane]), end_mass(right, lane) * std::abs(velocity) / dt) >
              rounding * largest[lane]))
          continue;
        was_active_[right][lane] = 1.0;
        tell(lane, next);
      }
    }
  };

  std::size_t told = 0;
  std::vector<Lanes> u_now, p_now, u(outputs.fields ? n : 2), v(u);
  const auto reactions = [&](double theta) {
    std::array<Lanes, 2> told_reaction{};
    for (const bool right : {false, true})
      if (pattern_.contact[right])
        told_reaction[right] =
            pattern_.sign[right] * ((1.0 - theta) * reaction_before_[right] + theta * reaction_[right]);
    return told_reaction;
  };
  const auto tell_start = [&] {
    for (std::size_t k = 0; k < u.size(); ++k) {
      const std::size_t i = outputs.fields ? k : node(k > 0);
      u[k] = datum(&State::u, i), v[k] = datum(&State::v, i);
    }
    for (const bool right : {false, true}) {
      if (!pattern_.massless[right]) continue;
      const std::size_t k = right ? u.size() - 1 : 0;
      u[k] = u_[node(right)] - dt * p_[node(right)];
      v[k] = p_[node(right)];
    }
    outputs.sample(told++, {u, v, reactions(0.0)});
  };
  const auto due = [&](std::size_t step, double t) {
    return told < outputs.times.size() && (outputs.times[told] <= t || step == steps);
  };
  while (told < outputs.times.size() && outputs.times[told] <= 0.0) tell_start();

  std::array<Lanes, 2> sum{}, u_last, u_here = u_start;
  std::array<Lanes, 2> held{};  // for so many steps
  const auto ways = [&](double theta) {
    std::array<Lanes, 2> all;
    for (const bool right : {false, true})
      all[right] = sum[right] + theta * (u_last[right] + 0.5 * theta * (u_here[right] - u_last[right]));
    return all;
  };
  for (std::size_t step = 1;; ++step) {
    const double t = static_cast<double>(step) * dt, before = static_cast<double>(step - 1) * dt;
    const double whole = step < steps ? 1.0 : std::min((how.end - before) / dt, 1.0);
    account(step == 1, whole, accounts);
    for (const bool right : {false, true}) {
      if (step > 1) sum[right] += 0.5 * (u_last[right] + u_here[right]);
      u_last[right] = std::exchange(u_here[right], u_[node(right)]);
      if (!pattern_.contact[right] || !pattern_.mounted[right]) continue;
      where(active_[right] == 0.0 && held[right] > 0.0 && held[right] <= 2.0 && mass_[right] > 0.0, accounts.brief) =
          1.0;
      held[right] = active_[right] * (held[right] + 1.0);
    }
    const bool tells = due(step, t);
    const bool fields =
        outputs.fields && told < outputs.times.size() && (outputs.times[told] <= t + dt || step + 1 >= steps);
    if (tells && fields) u_now = u_, p_now = p_;
    const auto sample_ends = [&] {
      while (due(step, t)) {
        const double theta = std::min((outputs.times[told] - before) / dt, 1.0);
        for (const bool right : {false, true}) {
          const Lanes& p = p_[node(right)];
          u[right] = u_[node(right)] - (1.0 - theta) * dt * p;
          v[right] = p + 0.5 * (theta * end_x_[right] - (1.0 - theta) * end_x_before_[right]);
        }
        outputs.sample(told++, {u, v, reactions(theta), ways(theta)});
      }
    };
    if (tells && !outputs.fields) sample_ends();
    if (step == steps && !outputs.fields) break;
    const double next = static_cast<double>(step + 1) * dt;
    find_changes(step == steps ? std::numeric_limits<double>::infinity() : t, next);
    if (varying_ && step < steps) evaluate_load(next);
    advance();
    if (tells && fields) {
      while (due(step, t)) {
        const double theta = std::min((outputs.times[told] - before) / dt, 1.0);
        for (std::size_t i = 0; i < n; ++i) {
          u[i] = u_now[i] - (1.0 - theta) * dt * p_now[i];
          v[i] = p_now[i] + 0.5 * (theta * x_[i] - (1.0 - theta) * x_before_[i]);
        }
        outputs.sample(told++, {u, v, reactions(theta), ways(theta)});
      }
    }
    if (step == steps) break;
    std::swap(x_, x_before_);
    if (rebounds_) bound();
    react();
  }
  for (std::size_t lane = 0; lane < lane_count; ++lane)
    accounts.finite[lane] =
        std::isfinite(static_cast<double>(end_x_[0][lane])) && std::isfinite(static_cast<double>(end_x_[1][lane]));
  return true;
}

}  // namespace viscobar::bars
