#include "dynamics/derivative.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "dynamics/natural_scales.hpp"

namespace viscobar {

namespace {

// d zeta / d restitution of damping_ratio(); infinite at 0.
double damping_ratio_rate(double restitution) {
  if (restitution <= 0.0) return -std::numeric_limits<double>::infinity();
  const double logarithm = std::log(restitution), square = std::numbers::pi * std::numbers::pi;
  return -square / (restitution * std::pow(square + logarithm * logarithm, 1.5));
}

}  // namespace

Derivative::Derivative(PenalisedSystem& system, const Penalty& penalty, const Direction& direction)
    : system_(system),
      data_(direction.data, system.bar().mesh(), system.bar().mass()),
      motion_(data_, penalty),
      added_(system.size(), 0.0),
      stress_(system.size()) {
  const Bar& bar = system.bar().bar();
  const double stretched = direction.bar.length / bar.length;
  modulus_ = direction.bar.modulus - bar.modulus * stretched;
  viscosity_ = direction.bar.viscosity - bar.viscosity * stretched;
  inertia_ = direction.bar.density / bar.density + stretched;
  const double crossing = bar.length * std::sqrt(bar.density / bar.modulus);
  relative_change_ = std::abs(direction.bar.density) / bar.density + std::abs(direction.bar.modulus) / bar.modulus +
                     std::abs(direction.bar.viscosity) / (bar.modulus * crossing) + std::abs(stretched) +
                     std::abs(direction.restitution);
  if (direction.epsilon != 0.0) relative_change_ += std::abs(direction.epsilon / *penalty.epsilon);
  for (std::size_t i = 0; i < system.contact_count(); ++i) {
    LawRates rates{0.0, 0.0};
    if (!system.rigid()) {
      const PenaltyLaw& law = system.law(i);
      const Contact& contact = system.contact(i);
      // k = weight / epsilon, b = 2 zeta (k m)^(1/2)
      const double stiffer = (contact.where == Where::span ? stretched : 0.0) - direction.epsilon / *penalty.epsilon;
      rates.stiffness = law.stiffness * stiffer;
      rates.damping = 0.5 * law.damping * (stiffer + inertia_);
      const bool massless =
          contact.unknown < system.bar().massive_begin() || contact.unknown >= system.bar().massive_end();
      if (direction.restitution != 0.0 && !massless)
        rates.damping += 2.0 * damping_ratio_rate(penalty.restitution) * direction.restitution *
                         std::sqrt(law.stiffness * system.bar().contact_mass(contact));
    }
    laws_.push_back(rates);
  }
  driven_ = modulus_ != 0.0 || viscosity_ != 0.0 || inertia_ != 0.0 ||
            std::ranges::any_of(laws_, [](const LawRates& law) { return law.stiffness != 0.0 || law.damping != 0.0; });
  if (driven_) motion_.add_force(added_, {});
}

double Derivative::relative_scale(double end) const {
  double most = displacement_of_data(data_, end);
  for (const Contact& contact : data_.contacts()) most = std::max(most, std::abs(contact.gap));
  return most / natural_scales(system_.bar(), end).displacement + relative_change_;
}

void Derivative::take_contacts() {
  for (std::size_t i = 0; i < system_.contact_count(); ++i)
    if (motion_.closed(i) != system_.closed(i)) motion_.set_closed(i, system_.closed(i));
}

// The strain of the element beside an end, times its length, outwards.
double Derivative::stretch(std::size_t end, std::span<const double> x, std::span<const double> origin,
                           const BarSystem& walls) const {
  const auto at = [&](std::size_t i) { return x[i] + (origin.empty() ? 0.0 : origin[i]); };
  if (end == 0 && x.size() > 1) return at(0) - at(1);
  if (end > 0) return at(end) - at(end - 1);
  return at(0) - (walls.left_fixed() ? *walls.left_displacement() : *walls.right_displacement());
}

void Derivative::drive(const Moment& at) {
  if (!driven_) return;
  const std::size_t n = added_.size();
  const BarSystem& bar = system_.bar();
  if (inertia_ == 0.0)
    std::ranges::fill(added_, 0.0);
  else
    for (std::size_t i = 0; i < n; ++i) added_[i] = -inertia_ * at.inertia[i];
  std::array<double, 2> rates{};
  if (modulus_ != 0.0 || viscosity_ != 0.0) {
    add_stress(at);
    if (n > 1 && bar.has_massless() && !bar.damped())
      rates = {modulus_ * (at.w[1] - at.w[0]) / bar.spacing_at(0),
               modulus_ * (at.w[n - 2] - at.w[n - 1]) / bar.spacing_at(n - 1)};
  }
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    if (!system_.closed(i) || system_.holds(i)) continue;
    const std::size_t node = system_.contact(i).unknown;
    added_[node] -= system_.contact(i).sign * laws_[i].stiffness * system_.clearance(i, at.u);
    added_[node] -= laws_[i].damping * at.w[node];
    if (node == 0) rates[0] -= laws_[i].stiffness * at.w[node];
    if (node + 1 == n) rates[1] -= laws_[i].stiffness * at.w[node];
  }
  motion_.add_force(added_, rates);
}

// -(E' - E L'/L) K u - (eta' - eta L'/L) K v
void Derivative::add_stress(const Moment& at) {
  const std::size_t n = added_.size();
  const BarSystem& bar = system_.bar();
  const Mesh& mesh = bar.mesh();
  const std::span<const double> origin = system_.origin();
  for (std::size_t i = 0; i < n; ++i) stress_[i] = modulus_ * at.u[i] + viscosity_ * at.w[i];
  for (std::size_t i = 0; i < origin.size(); ++i) stress_[i] += modulus_ * origin[i];
  const auto wall = [&](const std::optional<double>& u) { return modulus_ * *u; };
  const double* stress = stress_.data();
  const double left = bar.left_fixed() ? (stress[0] - wall(bar.left_displacement())) / mesh.element(0) : 0.0;
  const double right =
      bar.right_fixed() ? (wall(bar.right_displacement()) - stress[n - 1]) / mesh.element(mesh.elements - 1) : 0.0;
  added_[0] -= left;
  added_[n - 1] += right;
  if (mesh.uniform()) {
    const double scale = 1.0 / mesh.spacing();
    if (n > 1) {
      added_[0] += scale * (stress[1] - stress[0]);
      added_[n - 1] -= scale * (stress[n - 1] - stress[n - 2]);
    }
    for (std::size_t i = 1; i + 1 < n; ++i)
      added_[i] += scale * ((stress[i + 1] - stress[i]) - (stress[i] - stress[i - 1]));
    return;
  }
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double between = (stress[i + 1] - stress[i]) / mesh.element(bar.first_node() + i);
    added_[i] += between;
    added_[i + 1] -= between;
  }
}

double Derivative::drive_row(std::size_t end, double u, double u_next, double w, double w_next) const {
  const std::span<const double> origin = system_.origin();
  const std::size_t next = end == 0 ? 1 : end - 1;
  const double apart = origin.empty() ? 0.0 : origin[next] - origin[end];
  double sum = (modulus_ * (u_next - u + apart) + viscosity_ * (w_next - w)) / system_.bar().spacing_at(end);
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    const Contact& contact = system_.contact(i);
    if (contact.unknown != end || !system_.closed(i) || system_.holds(i)) continue;
    sum -=
        contact.sign * laws_[i].stiffness * (contact.sign * u + contact.clearance(origin.empty() ? 0.0 : origin[end]));
  }
  return sum;
}

double Derivative::reaction(std::size_t i, const Moment& at, std::span<const double> s, std::span<const double> rate) {
  if (!system_.closed(i)) return 0.0;
  if (system_.holds(i)) {
    // What its row lacks; the inertia of the neighbours, of the bar itself, is in the added force.
    return motion_.holding_force(i, at.t, s, rate);
  }
  const std::size_t node = system_.contact(i).unknown;
  const PenaltyLaw& law = system_.law(i);
  const double sign = system_.contact(i).sign;
  return -sign * (law.stiffness * motion_.clearance(i, s) + laws_[i].stiffness * system_.clearance(i, at.u)) -
         law.damping * rate[node] - laws_[i].damping * at.w[node];
}

double Derivative::stress(std::size_t element, std::span<const double> u, std::span<const double> v,
                          std::span<const double> s, std::span<const double> rate) const {
  const Bar& bar = system_.bar().bar();
  const auto difference = [element](std::span<const double> x) { return x[element + 1] - x[element]; };
  return (bar.modulus * difference(s) + bar.viscosity * difference(rate) + modulus_ * difference(u) +
          viscosity_ * difference(v)) /
         system_.bar().mesh().element(element);
}

double Derivative::momentum(std::size_t end, const Moment& at, std::span<const double> s,
                            std::span<const double> rate) const {
  const SymmetricTridiagonal& inertia = system_.bar().inertia();
  const std::size_t n = s.size();
  const auto row = [&](std::span<const double> x) {
    double sum = inertia.diagonal[end] * x[end];
    if (!inertia.off_diagonal.empty() && n > 1)
      sum += inertia.off_diagonal[end == 0 ? 0 : end - 1] * x[end == 0 ? 1 : end - 1];
    if (inertia.end_rows) sum += end == 0 ? inertia.end_rows->first_times(x) : inertia.end_rows->last_times(x);
    return sum;
  };
  const double h = system_.bar().spacing_at(end);
  return row(rate) + inertia_ * row(at.w) +
         (system_.bar().bar().viscosity * stretch(end, s, {}, data_) +
          viscosity_ * stretch(end, at.u, system_.origin(), system_.bar())) /
             h;
}

double Derivative::momentum_loss(std::size_t end, const Moment& at, std::span<const double> s) {
  const double strain = system_.bar().bar().modulus * stretch(end, s, {}, data_) +
                        modulus_ * stretch(end, at.u, system_.origin(), system_.bar());
  return strain / system_.bar().spacing_at(end) - (motion_.load(end, at.t) - added_[end]);
}

double Derivative::energy(const Moment& at, std::span<const double> s, std::span<const double> rate) const {
  const BarSystem& bar = system_.bar();
  const std::size_t n = s.size();
  const std::span<const double> origin = system_.origin();
  const SymmetricTridiagonal& inertia = bar.inertia();
  double sum = 0.5 * inertia_ * inertia.quadratic_form(at.w);
  for (std::size_t i = 0; i < n; ++i) sum += inertia.diagonal[i] * at.w[i] * rate[i];
  for (std::size_t i = 0; i + 1 < n && !inertia.off_diagonal.empty(); ++i)
    sum += inertia.off_diagonal[i] * (at.w[i] * rate[i + 1] + at.w[i + 1] * rate[i]);
  const auto add = [&](std::size_t element, double u, double of_s) {
    sum += (bar.bar().modulus * u * of_s + 0.5 * modulus_ * u * u) / bar.mesh().element(element);
  };
  const auto displacement = [&](std::size_t i) { return at.u[i] + (origin.empty() ? 0.0 : origin[i]); };
  if (bar.left_fixed()) add(0, displacement(0) - *bar.left_displacement(), s[0] - *data_.left_displacement());
  for (std::size_t i = 0; i + 1 < n; ++i)
    add(bar.first_node() + i, displacement(i + 1) - displacement(i), s[i + 1] - s[i]);
  if (bar.right_fixed())
    add(bar.mesh().elements - 1, *bar.right_displacement() - displacement(n - 1),
        *data_.right_displacement() - s[n - 1]);
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    const double clearance = system_.clearance(i, at.u);
    if (system_.holds(i) || clearance >= 0.0) continue;
    sum += clearance * (system_.law(i).stiffness * motion_.clearance(i, s) + 0.5 * laws_[i].stiffness * clearance);
  }
  return sum;
}

}  // namespace viscobar
