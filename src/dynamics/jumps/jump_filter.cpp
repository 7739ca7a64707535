#include "dynamics/jumps/jump_filter.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "dynamics/energy_terms.hpp"

namespace viscobar {

namespace {

constexpr double least_top = 8.2;   // of a spectrum
constexpr double stiffest = 100.0;  // of a spring, in E/h: the node of a stiffer one is as good as held

// g(mu), seven times differentiable: of a kink the polynomial would want more terms.
double share_of(double mu) {
  const double x = std::clamp((mu - 1.0) / 5.0, 0.0, 1.0);
  return x * x * x * x * (35.0 + x * (-84.0 + x * (70.0 - 20.0 * x)));
}

// Coefficients of G on [0, top], by interpolation at Chebyshev's points.
std::vector<double> chebyshev(double top) {
  // Points lie as densely at mu = 1 whatever the top. They leave 1e-6 of G; half as many, 1e-5, show in reactions.
  const auto count = static_cast<std::size_t>(50.0 * std::sqrt(top / 8.2));
  std::vector<double> values(count), coefficients(count);
  const double angle = std::numbers::pi / static_cast<double>(count);
  for (std::size_t j = 0; j < count; ++j) {
    const double mu = 0.5 * top * (1.0 + std::cos((static_cast<double>(j) + 0.5) * angle));
    values[j] = share_of(mu) / mu;
  }
  for (std::size_t k = 0; k < count; ++k) {
    double sum = 0.0;
    for (std::size_t j = 0; j < count; ++j)
      sum += values[j] * std::cos(static_cast<double>(k) * (static_cast<double>(j) + 0.5) * angle);
    coefficients[k] = (k == 0 ? 1.0 : 2.0) * sum / static_cast<double>(count);
  }
  // A bar that moves as a whole has mu = 0, and no jump may move it: what interpolation leaves there is taken off by a
  // multiple of the polynomial whose coefficients are Hann's window, 1 at mu = 0 and next to nothing from mu = top / 50
  // on.
  double whole = 0.0, sum_of_window = 0.0;
  const auto window = [&](std::size_t k) {
    const double c = std::cos(0.5 * static_cast<double>(k) * angle);
    return (k == 0 ? 0.5 : 1.0) * c * c;
  };
  for (std::size_t k = 0; k < count; ++k) {
    whole += k % 2 == 0 ? coefficients[k] : -coefficients[k];
    sum_of_window += window(k);
  }
  for (std::size_t k = 0; k < count; ++k) coefficients[k] -= (k % 2 == 0 ? whole : -whole) * window(k) / sum_of_window;
  return coefficients;
}

// The largest mu of an end with a spring of that many times E/h: the mode q^j that dies out from it, mu (7 + 6 q - q^2)
// / 24 = 1 - q + kappa in its row, mu = 12 (1 - c) / (5 + c) inside, c = (q + 1/q) / 2.
double end_mode(double kappa) {
  double low = -0.4227, high = 2.0 * std::sqrt(6.0) - 5.0;  // where c = -5
  const auto mu = [](double q) {
    const double c = 0.5 * (q + 1.0 / q);
    return 12.0 * (1.0 - c) / (5.0 + c);
  };
  for (int k = 0; k < 60; ++k) {
    const double q = 0.5 * (low + high);
    (mu(q) * (7.0 + q * (6.0 - q)) / 24.0 < 1.0 - q + kappa ? low : high) = q;
  }
  return mu(low);
}

}  // namespace

JumpFilter::JumpFilter(const BarSystem& bar) : bar_(bar) {
  const Bar& material = bar.bar();
  const double h = bar.mesh().spacing(), impedance = material.impedance();
  const double viscous = material.viscosity / (h * impedance);
  const auto spans = [](const Contact& contact) { return contact.where == Where::span; };
  // Its polynomials are for the spectrum of rows that are all alike.
  if (bar.mass() != Mass::fourth_order || !bar.elements().rows_alike() || bar.mesh().elements < fewest_elements ||
      std::ranges::any_of(bar.contacts(), spans))
    return;
  // Springs along the bar that the mesh does not resolve give its long waves the frequencies of short ones.
  if (bar.side() && h * h * bar.side()->largest_stiffness() > 0.1 * material.modulus) return;
  for (const Support& support : bar.supports())
    if (support.dashpot >= 0.5 * impedance) deaf_[bar.unknowns().is_right(support.unknown)] = true;
  if (!(deaf_[0] && deaf_[1])) share_ = std::pow(std::max(0.0, 1.0 - 2.0 * viscous * viscous), 4);
  scale_ = h * h * material.density / material.modulus;
}

// For the contacts that are closed.
void JumpFilter::prepare(const PenalisedSystem& system) {
  const std::size_t n = bar_.size();
  std::array<bool, 2> held{};
  double stiffness = 0.0;
  for (const Support& support : bar_.supports()) {
    const double kappa = support.stiffness * bar_.mesh().spacing() / bar_.bar().modulus;
    const bool is_stiff = kappa > stiffest;
    held[bar_.unknowns().is_right(support.unknown)] |= is_stiff;
    if (!is_stiff) stiffness = std::max(stiffness, kappa);
  }
  for (std::size_t i = 0; i < system.contacts().size(); ++i)
    if (system.contacts().closed(i)) held[bar_.unknowns().is_right(system.contacts()[i].unknown)] = true;
  if (held_ == held) return;
  if (!held_) {
    stiffness_ = {bar_.unknowns(), std::vector(bar_.mesh().elements, 1.0 / bar_.elements().stretch(0))};
    top_ = stiffness > 0.0 ? std::max(least_top, 1.02 * end_mode(stiffness)) : least_top;
    static const std::vector<double> without_springs = chebyshev(least_top);
    coefficients_ = top_ == least_top ? without_springs : chebyshev(top_);
    for (std::vector<double>* one : {&first_, &second_, &next_, &start_, &force_, &rate_}) one->resize(n);
  }
  held_ = held;
  factorise();
}

void JumpFilter::factorise() {
  BandedMatrix inertia = bar_.inertia().matrix();
  for (const bool right : {false, true}) {
    double& end = inertia.diagonal[bar_.unknowns().end(right)];
    end = (*held_)[right] ? std::numeric_limits<double>::infinity() : end + added_.mass[right];
  }
  factor_.factorise(inertia);
}

void JumpFilter::stiffness(std::span<const double> x, std::span<double> out) const {
  forces(
      x, bar_.bar().modulus,
      [this](const Support& end) { return end.stiffness + added_.stiffness[bar_.unknowns().is_right(end.unknown)]; },
      &SideRows::stiffness, out);
  const auto add = [&](const SideRows& side, double times) {
    const auto at = bar_.unknowns().at_nodes(x);
    side.subtract([&](std::size_t j) { return -times * side.stiffness(j) * at(j); }, bar_.unknowns().first_node(),
                  bar_.size(), out);
  };
  if (added_.of_own != 0.0) add(*bar_.side(), added_.of_own);
  if (added_.of_sides != 0.0)
    for (const SideRows& side : added_.sides) add(side, added_.of_sides);
}

void JumpFilter::damping(std::span<const double> x, std::span<double> out) const {
  forces(x, bar_.bar().viscosity, std::mem_fn(&Support::dashpot), &SideRows::drag, out);
}

// out = factor K x, with what ends and a side have of it.
void JumpFilter::forces(std::span<const double> x, double factor, auto&& of_end,
                        double (SideRows::*of_side)(std::size_t) const, std::span<double> out) const {
  const auto at = bar_.unknowns().at_nodes(x);
  stiffness_.multiply(at, out);
  for (double& force : out) force *= factor;
  for (const Support& support : bar_.supports()) out[support.unknown] += of_end(support) * x[support.unknown];
  if (const SideRows* side = bar_.side())
    side->subtract([&](std::size_t j) { return -(side->*of_side)(j)*at(j); }, bar_.unknowns().first_node(), bar_.size(),
                   out);
}

// True if what a force would be answered with is negligible. Fourth differences of the acceleration, 16 sin^4 of half
// the phase, are large for high modes alone, and what they leave of G is 1/2 at most.
bool JumpFilter::is_smooth(std::span<const double> force, double negligible) {
  std::ranges::copy(force, next_.begin());
  factor_.solve(next_);
  const auto n = static_cast<std::ptrdiff_t>(next_.size());
  const std::ptrdiff_t first = bar_.unknowns().left_fixed() ? -1 : 0, last = bar_.unknowns().right_fixed() ? n : n - 1;
  const auto value = [&](std::ptrdiff_t i) { return i < 0 || i >= n ? 0.0 : next_[static_cast<std::size_t>(i)]; };
  double largest = 0.0;
  for (std::ptrdiff_t i = first + 2; i <= last - 2; ++i)
    largest =
        std::max(largest, std::abs(value(i - 2) + value(i + 2) - 4.0 * (value(i - 1) + value(i + 1)) + 6.0 * value(i)));
  return share_ * scale_ * largest / 32.0 <= negligible;
}

// force <- theta (h^2 rho / E) G(A) (rho M)^{-1} force, by Clenshaw's recurrence.
void JumpFilter::apply(std::span<double> force) {
  const std::size_t n = force.size();
  factor_.solve(force);
  for (std::size_t i = 0; i < n; ++i) {
    start_[i] = share_ * scale_ * force[i];
    first_[i] = second_[i] = 0.0;
  }
  const double shrink = 2.0 / top_ * scale_;
  for (std::size_t k = coefficients_.size(); k-- > 0;) {
    const double twice = k > 0 ? 2.0 : 1.0;
    stiffness(first_, next_);
    factor_.solve(next_);
    for (std::size_t i = 0; i < n; ++i)
      next_[i] = twice * (shrink * next_[i] - first_[i]) - second_[i] + coefficients_[k] * start_[i];
    second_.swap(first_);
    first_.swap(next_);
  }
  std::ranges::copy(first_, force.begin());
  quieten(force);
}

void JumpFilter::quieten(std::span<double> x) const {
  if (deaf_[0]) std::ranges::fill(x.first(x.size() / 2), 0.0);
  if (deaf_[1]) std::ranges::fill(x.last(x.size() / 2), 0.0);
}

// The dashpot of an end answers its step with an impulse on the node, the high modes apart.
void JumpFilter::answer_with_dashpots(std::span<const double> step, std::span<double> w) {
  impulse_.assign(w.size(), 0.0);
  for (const Support& support : bar_.supports()) impulse_[support.unknown] = -support.dashpot * step[support.unknown];
  factor_.solve(impulse_);
  std::vector<double> high(w.size());
  take_high_part(impulse_, high);
  for (std::size_t i = 0; i < w.size(); ++i) w[i] += impulse_[i] - high[i];
}

// theta g(A) x
void JumpFilter::take_high_part(std::span<const double> x, std::span<double> high) {
  stiffness(x, high);
  apply(high);
}

// The shifts that a force and its rate, jumps both, ask for; both are overwritten.
JumpFilter::Taken JumpFilter::put(PenalisedSystem& system, double t, std::span<double> force, std::span<double> rate,
                                  std::span<double> u, std::span<double> w) {
  const std::size_t n = u.size();
  const double before = energy(system.contacts(), u, w);
  jump_rate_.assign(rate.begin(), rate.end());
  apply(rate);
  std::vector<double> opposed(n);
  damping(rate, opposed);
  for (std::size_t i = 0; i < n; ++i) force[i] -= opposed[i];
  jump_force_.assign(force.begin(), force.end());
  apply(force);
  // No node is put through an obstacle.
  part_ = 1.0;
  bound_.reset();
  for (std::size_t i = 0; i < system.contacts().size(); ++i) {
    const double down = -system.contacts()[i].sign * force[system.contacts()[i].unknown];
    if (system.contacts().closed(i) || down <= 0.0) continue;
    if (const double share = system.contacts().clearance(i, u) / down; share < part_)
      part_ = std::max(share, 0.0), bound_ = i;
  }
  Taken taken;
  for (std::size_t i = 0; i < n; ++i) {
    u[i] += force[i] *= part_;
    w[i] += rate[i];
    if (system.load().acts()) taken.work += system.load().at(i, t) * force[i];
  }
  shift_u_.assign(force.begin(), force.end());
  shift_w_.assign(rate.begin(), rate.end());
  shifted_ = true;
  if (has_dashpots(bar_.supports())) answer_with_dashpots(force, w);
  taken.energy = before + taken.work - energy(system.contacts(), u, w);
  return taken;
}

JumpFilter::Taken JumpFilter::begin(PenalisedSystem& system, double t, const Negligible& negligible,
                                    std::span<double> u, std::span<double> w) {
  prepare(system);
  shifted_ = false;
  stiffness(w, rate_);
  for (double& rate : rate_) rate = -rate;
  system.load().add_rate(t, rate_);
  system.force(t, u, w, force_);
  if (is_smooth(force_, negligible.displacement) && is_smooth(rate_, negligible.velocity)) return {};
  return put(system, t, force_, rate_, u, w);
}

// There the load of the frame jumps, and the bar does not; or its velocities do as well, which are left as they are.
bool JumpFilter::jumps_with_frame(double t, double end) const {
  if (!bar_.frame().moving()) return false;
  for (const bool right : {false, true})
    if (bar_.inputs()[right].motion && !bar_.unknowns().wall(right)) return true;
  return bar_.frame().kink(t, end).has_value();
}

JumpFilter::Taken JumpFilter::pass_break(PenalisedSystem& system, double t, double end, std::span<double> u,
                                         std::span<double> w) {
  std::vector<double> force(u.size()), rate(u.size());
  shifted_ = false;
  if (jumps_with_frame(t, end) || !system.load().jump(t, end, force, rate)) return {};
  prepare(system);
  return put(system, t, force, rate, u, w);
}

}  // namespace viscobar
