#include "viscobar/dynamics/moving_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <variant>

#include "dynamics/finite_load.hpp"
#include "scene/times.hpp"
#include "viscobar/dynamics/side_rows.hpp"

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

MovingFrame::MovingFrame(const Scene& scene, const Unknowns& unknowns, std::shared_ptr<const Elements> elements,
                         std::shared_ptr<const Inertia> inertia, const SideRows* side)
    : elements_(std::move(elements)),
      inertia_(std::move(inertia)),
      unknowns_(unknowns),
      motions_{scene.left_input.motion, scene.right_input.motion},
      free_{std::holds_alternative<Free>(scene.left), std::holds_alternative<Free>(scene.right)} {
  enter(side);
}

MovingFrame MovingFrame::following(const SideRows* side) const {
  MovingFrame frame = *this;
  frame.following_ = true;
  frame.enter(side);
  return frame;
}

MovingFrame MovingFrame::resting(const SideRows* side) const {
  MovingFrame frame = *this;
  frame.following_ = false;
  frame.enter(side);
  return frame;
}

MovingFrame MovingFrame::with(const SideRows* side) const {
  MovingFrame frame = *this;
  frame.enter(side);
  return frame;
}

void MovingFrame::enter(const SideRows* side) {
  if (!moving()) return;
  rigid_ = free_[moves(false)];
  inner_ = {};
  const Mesh& mesh = elements_->mesh();
  const Bar& bar = elements_->bar();
  const std::size_t first = unknowns_.first_node(), n = unknowns_.size();
  std::vector<double> share(mesh.nodes()), product(mesh.nodes());
  for (const bool right : {false, true}) {
    for (std::size_t j = 0; j < share.size(); ++j) share[j] = right ? elements_->share(j) : 1.0 - elements_->share(j);
    inertia_->whole().multiply(share, product);
    const auto of_unknowns = unknowns_.part(std::span(product));
    inertial_[right].assign(of_unknowns.begin(), of_unknowns.end());
    if (!side && !elements_->is_chain()) continue;
    auto& [of_stiffness, of_drag] = inner_;
    of_stiffness[right].assign(n, 0.0), of_drag[right].assign(n, 0.0);
    for (std::size_t e = 0; elements_->is_chain() && e < mesh.elements; ++e) {
      const double stretched = share[e + 1] - share[e];
      const std::size_t i = e - first;  // beyond all of a fixed end
      const auto pull = [&](std::vector<double>& row, double force) {
        if (i < n) row[i] += force;
        if (i + 1 < n) row[i + 1] -= force;
      };
      pull(of_stiffness[right], bar.modulus * elements_->stretch_weight(e) * stretched);
      if (bar.damped()) pull(of_drag[right], bar.viscosity * elements_->rate_weights()[e] * stretched);
    }
    if (!side) continue;
    side->subtract([&](std::size_t j) { return side->stiffness(j) * share[j]; }, first, n, of_stiffness[right]);
    side->subtract([&](std::size_t j) { return side->drag(j) * share[j]; }, first, n, of_drag[right]);
  }
}

double MovingFrame::gap(const Contact& contact, double t, int derivative) const {
  if (!moves(contact)) return derivative == 0 ? contact.gap : 0.0;
  const bool right = contact.where == Where::right;
  return (derivative == 0 ? contact.gap : 0.0) - contact.sign * motion_at(*motions_[right], t, derivative, right);
}

void MovingFrame::change(const MovingFrame& to, double t, std::span<double> u, std::span<double> w) const {
  for (const auto& [derivative, field] : {std::pair{0, u}, {1, w}}) {
    const Lift from = lift(t, derivative), into = to.lift(t, derivative);
    for (std::size_t i = 0; i < field.size(); ++i) field[i] += from.at(share(i)) - into.at(share(i));
  }
}

double MovingFrame::inner_force(const Lift& lift, const Lift& rate, std::size_t unknown) const {
  const auto& [of_stiffness, of_drag] = inner_;
  return lift.left * of_stiffness[0][unknown] + lift.right * of_stiffness[1][unknown] +
         rate.left * of_drag[0][unknown] + rate.right * of_drag[1][unknown];
}

Lift MovingFrame::lift(double t, int derivative) const {
  Lift lift;
  for (const bool right : {false, true})
    if (moves(right)) lift.of(right) = motion_at(*motions_[right], t, derivative, right);
  if (rigid_) lift.left = lift.right = moves(false) ? lift.left : lift.right;
  return lift;
}

Lift MovingFrame::lift(double t, int derivative, double step) const {
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

std::optional<FrameJump> MovingFrame::kink(double t, double end) const {
  if (!moving()) return std::nullopt;
  const auto jump = [&](bool right, int derivative) {
    return jump_of([&](double at, int n) { return lift(at, n).of(right); }, derivative, t, end);
  };
  FrameJump found;
  for (const bool right : {false, true}) {
    found.displacement.of(right) = jump(right, 0);
    const bool own = rigid_ ? !moves(right) : false;  // moved by the other end
    if (found.displacement.of(right) != 0.0 && unknowns_.wall(own ? !right : right))
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

void MovingFrame::pass_kink(const FrameJump& jump, std::span<double> u, std::span<double> w) const {
  if (jump.displaces())
    for (std::size_t i = 0; i < unknowns_.size(); ++i) u[i] -= jump.displacement.at(share(i));
  std::vector<double> change(unknowns_.size());
  for (std::size_t i = 0; i < change.size(); ++i) change[i] = inertial_force(jump.velocity, i);
  inertia_->accelerate(change);
  for (std::size_t i = 0; i < change.size(); ++i) w[i] -= change[i];
}

double MovingFrame::gap_jump(const Contact& contact, double t, double end, int derivative) const {
  const bool right = contact.where == Where::right;
  if (!contact.at_end() || !motions_[right]) return 0.0;
  const EndMotion& motion = *motions_[right];
  return -contact.sign * jump_of([&](double at, int n) { return motion_at(motion, at, n, right); }, derivative, t, end);
}

void MovingFrame::add_lift(const Lift& lift, std::span<double> nodal) const {
  for (std::size_t j = 0; j < nodal.size(); ++j) nodal[j] += lift.at(elements_->share(j));
}

}  // namespace viscobar
