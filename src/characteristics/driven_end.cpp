#include "characteristics/driven_end.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "discretisation/gauss.hpp"
#include "dynamics/finite_load.hpp"

namespace viscobar::characteristics {

DrivenEnd::DrivenEnd(const EndInput& input, double impedance, double passage, double start)
    : input_(input),
      impedance_(impedance),
      passage_(passage),
      start_(start),
      factor_(1.0 + input.dashpot / impedance),
      active_(input.force || input.motion || input.dashpot != 0.0 || input.mass != 0.0) {
  for (Piecewise* none : {&force_, &velocity_}) none->append(1.0, 0.0, 1.0, Chebyshev::constant(0.0));
}

void DrivenEnd::enter(std::size_t passage) {
  now_ = passage;
  const auto per_impedance = [this](double t) { return input_.force->value(t) / impedance_; };
  if (input_.force) fit(per_impedance, input_.force->breaks, "the force at an end", force_);
  if (input_.motion) fit(input_.motion->velocity, input_.motion->breaks, "the velocity of an end", velocity_);
}

void DrivenEnd::fit(const TimeFunction& f, const NextBreak& breaks, const char* what, Piecewise& fitted) {
  const double begin = start_ + passage_ * static_cast<double>(now_), end = begin + passage_;
  breaks_.clear();
  // Two breaks within so little are one.
  const double apart = 64.0 * rounding * std::abs(end);
  if (breaks)
    for (auto at = breaks(begin, end); at && *at < end; at = breaks(*at + apart, end)) {
      const double s = (*at - begin) / passage_;
      if (s > 1e-14 && s < 1.0 - 1e-14 && (breaks_.empty() || s > breaks_.back() + 1e-14)) breaks_.push_back(s);
    }
  const auto of_s = [&](double s) {
    const double t = begin + passage_ * s;
    return finite_load(
        t, [&] { return f(t); }, [&] { return fmt::format("{} at t = {}", what, t); });
  };
  fitted = fit_.of(of_s, {.breaks = breaks_, .argument = static_cast<double>(now_) + 1.0});
  error_ += fit_.error();
}

const Piecewise& DrivenEnd::relative(const Piecewise& arriving) {
  combine(arriving, 1.0 / factor_, force_, 1.0 / factor_, scratch_);
  combine(scratch_, 1.0, velocity_, -1.0, relative_);
  return relative_;
}

// 2 v - w: with m what is answered to w_r, v = V + w_r where the end moves, m = w_r, and v = V where it is held,
// m = -w_r; either way 2 v = 2 V + w_r + m. A mass moves by m, and V = 0.
void DrivenEnd::send(const End& end, const Piecewise& moved, const Piecewise& arriving, Piecewise& sent) {
  if (input_.mass > 0.0) {
    sent.clear();
    const double until = std::min(moved.end(), arriving.end());
    return for_common_pieces(moved, arriving, until, [&](double from, double to, std::size_t i, std::size_t j) {
      Chebyshev wave = -arriving.on(j, from, to);
      if (!end.held_at(0.5 * (from + to))) wave += 2.0 * moved.on(i, from, to);
      sent.append(to, from, to, wave);
    });
  }
  Piecewise sum;
  combine(moved, 1.0, relative_, 1.0, scratch_);
  combine(scratch_, 1.0, velocity_, 2.0, sum);
  combine(sum, 1.0, arriving, -1.0, sent);
}

DrivenEnd::Flow DrivenEnd::flow(const End& end, const Piecewise& moved, double until) const {
  Flow sum;
  Cursor force(force_), velocity(velocity_);
  for_common_pieces(velocity_, moved, until, [&](double from, double to, std::size_t, std::size_t j) {
    const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
    const bool held = end.held_at(middle);
    const Chebyshev answer = moved.on(j, from, to);
    for (const auto [node, weight] : gauss(Chebyshev::most_terms)) {
      const double s = middle + half * node, frame = velocity.value(s), answered = answer(node);
      const double v = held ? frame : answered + frame;
      const double share = half * weight * passage_ * impedance_;
      sum.work += share * (force.value(s) * v + (held ? factor_ * answered * frame : 0.0));
      sum.dissipated += share * (factor_ - 1.0) * v * v;
    }
  });
  for (const Turn& turn : end.turns())
    if (turn.change == Change::closing && turn.s <= until)
      sum.dissipated += 0.5 * input_.mass * turn.velocity * turn.velocity;
  return sum;
}

void DrivenEnd::add(const End& end, const Piecewise& moved, Account& account) const {
  const Flow whole = flow(end, moved, moved.end());
  account.work += whole.work;
  account.dissipated += whole.dissipated;
  if (!moves()) return;
  Cursor along(moved), velocity(velocity_);
  for_common_pieces(velocity_, moved, moved.end(), [&](double from, double to, std::size_t, std::size_t j) {
    const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
    const bool held = end.held_at(middle);
    const Chebyshev answer = moved.on(j, from, to);
    const auto moving = Chebyshev::of(Chebyshev::fitted_terms, [&](double z) {
      return velocity.value(middle + half * z) + (held ? 0.0 : answer(z));
    });
    const double t = start_ + passage_ * (static_cast<double>(now_) + from);
    const double u = end.displacement_at(from, along) + displacement(t);
    const Chebyshev path = half * passage_ * moving.antiderivative() + u;
    const double tolerance = 64.0 * rounding * path.bound();
    account.highest = maximum(path, std::max({account.highest, path(-1.0), path(1.0)}), tolerance);
    account.lowest = std::min({account.lowest, path(-1.0), path(1.0)});
    account.lowest = -maximum(-path, -account.lowest, tolerance);
  });
}

}  // namespace viscobar::characteristics
