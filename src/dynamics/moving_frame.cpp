#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "dynamics/finite_load.hpp"
#include "scene/times.hpp"
#include "viscobar/dynamics/bar_system.hpp"

// BarSystem in a frame that moves with the walls of its ends, or with the obstacles that they have met.

namespace viscobar {

namespace {

double motion_at(const EndMotion& motion, double t, int derivative, bool right) {
  constexpr std::array<std::string_view, 3> words = {"displacement", "velocity", "acceleration"};
  const TimeFunction& f = derivative == 0   ? motion.displacement
                          : derivative == 1 ? motion.velocity
                                            : motion.acceleration;
  return finite_load(
      t, [&] { return f(t); },
      [&] {
        return fmt::format("the {} of the motion at the {} end at t = {}", words[static_cast<std::size_t>(derivative)],
                           right ? "right" : "left", t);
      });
}

}  // namespace

BarSystem BarSystem::following() const {
  BarSystem system = *this;
  system.following_ = true;
  if (system.moving()) system.enter_frame();
  return system;
}

double BarSystem::gap(const Contact& contact, double t, int derivative) const {
  if (!moves(contact)) return derivative == 0 ? contact.gap : 0.0;
  const bool right = contact.where == Where::right;
  return (derivative == 0 ? contact.gap : 0.0) - contact.sign * motion_at(*inputs_[right].motion, t, derivative, right);
}

void BarSystem::change_frame(const BarSystem& to, double t, std::span<double> u, std::span<double> w) const {
  for (const auto& [derivative, field] : {std::pair{0, u}, {1, w}}) {
    const Lift from = lift(t, derivative), into = to.lift(t, derivative);
    for (std::size_t i = 0; i < field.size(); ++i) field[i] += from.at(share(i)) - into.at(share(i));
  }
}

void BarSystem::enter_frame() {
  rigid_frame_ = free_[moves_frame(false)];
  std::vector<double> share(mesh_.nodes()), product(mesh_.nodes());
  for (const bool right : {false, true}) {
    for (std::size_t j = 0; j < share.size(); ++j) share[j] = right ? node_share(j) : 1.0 - node_share(j);
    whole_inertia_.multiply(share, product);
    const auto of_unknowns = std::span(product).subspan(first_node(), size());
    lift_inertia_[right].assign(of_unknowns.begin(), of_unknowns.end());
    if (!has_lift_force()) continue;
    auto& [of_stiffness, of_drag] = lift_rows_;
    of_stiffness[right].assign(size(), 0.0), of_drag[right].assign(size(), 0.0);
    for (std::size_t e = 0; chain_ && e < mesh_.elements; ++e) {
      const double stretched = share[e + 1] - share[e];
      const std::size_t i = e - first_node();  // beyond all of a fixed end
      const auto pull = [&](std::vector<double>& row, double force) {
        if (i < size()) row[i] += force;
        if (i + 1 < size()) row[i + 1] -= force;
      };
      pull(of_stiffness[right], bar_.modulus * inverse_spacing_[e] * stretched);
      if (damped()) pull(of_drag[right], bar_.viscosity * rate_weights()[e] * stretched);
    }
    if (!side_) continue;
    side_->subtract([&](std::size_t j) { return side_->stiffness(j) * share[j]; }, first_node(), size(),
                    of_stiffness[right]);
    side_->subtract([&](std::size_t j) { return side_->drag(j) * share[j]; }, first_node(), size(), of_drag[right]);
  }
}

void BarSystem::take_side(const BarSystem& of) {
  side_ = of.side_;
  if (moving()) enter_frame();
}

double BarSystem::lift_force(const Lift& lift, const Lift& rate, std::size_t unknown) const {
  const auto& [of_stiffness, of_drag] = lift_rows_;
  return lift.left * of_stiffness[0][unknown] + lift.right * of_stiffness[1][unknown] +
         rate.left * of_drag[0][unknown] + rate.right * of_drag[1][unknown];
}

Lift BarSystem::lift(double t, int derivative) const {
  Lift lift;
  for (const bool right : {false, true})
    if (moves_frame(right)) lift.of(right) = motion_at(*inputs_[right].motion, t, derivative, right);
  if (rigid_frame_) lift.left = lift.right = moves_frame(false) ? lift.left : lift.right;
  return lift;
}

Lift BarSystem::lift(double t, int derivative, double step) const {
  const Lift before = lift(t - step, 0), after = lift(t + step, 0), now = derivative > 1 ? lift(t, 0) : Lift{};
  const auto of = [&](bool right) {
    const double a = before.of(right), b = now.of(right), c = after.of(right);
    if (derivative == 0) return (a + c) / 2;
    return derivative == 1 ? (c - a) / (2 * step) : ((c - b) - (b - a)) / (step * step);
  };
  return {of(false), of(true)};
}

namespace {

// The nearest times on both sides at which a function has its one-sided limits.
std::pair<double, double> sides_of(double t, double end) {
  const double rounding = rounding_of_times(t, end);
  return {t > 0.0 ? std::max(t - rounding, 0.0) : 0.0, t + rounding};
}

// The jump of the n-th derivative f(., n) of a function at t; 0 where the function with the next one on both sides
// changes as much between them, or by the rounding of its values: those beside t count, for a series may come back to 0
// there.
double jump_of(auto&& f, int n, double t, double end) {
  const auto [before, after] = sides_of(t, end);
  const double early = f(before, n), late = f(after, n), change = std::abs(late - early);
  const double smooth = 8.0 * (std::abs(f(before, n + 1)) + std::abs(f(after, n + 1))) * (after - before);
  if (change <= smooth + 1e-12 * (std::abs(early) + std::abs(late))) return 0.0;
  double largest = 0.0;
  for (double apart = end; apart > after - before; apart *= 0.5)
    for (const double at : {std::max(t - apart, 0.0), std::min(t + apart, end)})
      if (const double value = std::abs(f(at, n)); std::isfinite(value)) largest = std::max(largest, value);
  return change > 1e-14 * largest ? late - early : 0.0;
}

}  // namespace

std::optional<FrameJump> BarSystem::kink(double t, double end) const {
  if (!moving()) return std::nullopt;
  const auto jump = [&](bool right, int derivative) {
    return jump_of([&](double at, int n) { return lift(at, n).of(right); }, derivative, t, end);
  };
  FrameJump found;
  for (const bool right : {false, true}) {
    found.displacement.of(right) = jump(right, 0);
    const bool own = rigid_frame_ ? !moves_frame(right) : false;  // moved by the other end
    if (found.displacement.of(right) != 0.0 && walls_[own ? !right : right])
      throw LoadError(
          t, fmt::format("the motion at the {} end jumps at t = {}", (own ? !right : right) ? "right" : "left", t));
  }
  const bool kinks = jump(false, 1) != 0.0 || jump(true, 1) != 0.0;
  if (!kinks && !found.displaces()) return std::nullopt;
  if (kinks) {
    const auto [before, after] = sides_of(t, end);
    const Lift early = lift(before, 1), late = lift(after, 1);
    found.velocity = {late.left - early.left, late.right - early.right};
  }
  return found;
}

void BarSystem::pass_kink(const FrameJump& jump, std::span<double> u, std::span<double> w) const {
  if (jump.displaces())
    for (std::size_t i = 0; i < size(); ++i) u[i] -= jump.displacement.at(share(i));
  std::vector<double> change(size());
  for (std::size_t i = 0; i < change.size(); ++i)
    change[i] = jump.velocity.left * lift_inertia_[0][i] + jump.velocity.right * lift_inertia_[1][i];
  accelerate(change);
  for (std::size_t i = 0; i < change.size(); ++i) w[i] -= change[i];
}

double BarSystem::gap_jump(const Contact& contact, double t, double end, int derivative) const {
  const bool right = contact.where == Where::right;
  if (!contact.at_end() || !inputs_[right].motion) return 0.0;
  const EndMotion& motion = *inputs_[right].motion;
  return -contact.sign * jump_of([&](double at, int n) { return motion_at(motion, at, n, right); }, derivative, t, end);
}

void BarSystem::add_lift(const Lift& lift, std::span<double> nodal) const {
  for (std::size_t j = 0; j < nodal.size(); ++j) nodal[j] += lift.at(node_share(j));
}

BarEnergy BarSystem::nodal_energy(std::span<const double> u, std::span<const double> v) const {
  BarEnergy energy;
  if (moving()) {
    energy.kinetic = 0.5 * whole_inertia_.quadratic_form(v);
    for (std::size_t j = 0; j < mesh_.elements; ++j) {
      const double strain = u[j + 1] - u[j];
      energy.elastic += 0.5 * bar_.modulus * strain * strain / stretch(j);
    }
  } else {
    energy.kinetic = 0.5 * inertia_.quadratic_form(v.subspan(first_node(), size()));
    energy.elastic = 0.5 * bar_.modulus * squared_strain(u.subspan(first_node(), size()));
  }
  for (const Support& support : supports_) {
    const double at = u[support.unknown + first_node()];
    energy.elastic += 0.5 * support.stiffness * at * at;
  }
  if (side_) energy.elastic += side_->energy([u](std::size_t j) { return u[j]; });
  return energy;
}

BarEnergy BarSystem::lifted_energy(const Lift& lift, const Lift& rate, std::span<const double> u,
                                   std::span<const double> w) const {
  std::vector<double> displacement(mesh_.nodes()), velocity(mesh_.nodes());
  expand_displacement(u, displacement);
  expand_velocity(w, velocity);
  if (moving()) {
    add_lift(lift, displacement);
    add_lift(rate, velocity);
  }
  return nodal_energy(displacement, velocity);
}

double BarSystem::end_lift_loss(const Lift& rate, double left, double right) const {
  const double strain_rate = chain_ ? 0.0 : (rate.right - rate.left) / whole_stretch();
  double sum = bar_.viscosity * strain_rate * (2.0 * (right - left) + strain_rate * whole_stretch());
  for (const Support& support : supports_) {
    const bool at_right = is_right(support.unknown);
    const double frame = rate.of(at_right);
    sum += support.dashpot * frame * (2.0 * (at_right ? right : left) + frame);
  }
  return sum;
}

}  // namespace viscobar
