#include "viscobar/dynamics/bar_system.hpp"

#include <utility>

#include "dynamics/load/nodal_load.hpp"

namespace viscobar {

bool BarSystem::loaded() const { return (load_ && load_->acts()) || frame_->moving(); }

BarSystem BarSystem::following() const {
  BarSystem system = *this;
  system.frame_ = std::make_shared<const MovingFrame>(frame_->following(side()));
  return system;
}

void BarSystem::add_load(LoadDifference difference) {
  NodalLoad load = load_ ? *load_ : NodalLoad{};
  load.difference = std::move(difference);
  load_ = std::make_shared<const NodalLoad>(std::move(load));
}

void BarSystem::take_side(const BarSystem& of) {
  side_ = of.side_;
  frame_ = std::make_shared<const MovingFrame>(frame_->with(side()));
}

double BarSystem::holding_force(bool right, std::span<const double> u, std::span<const double> v,
                                std::span<const double> a, double load) const {
  const double force = elements_->end_force(right, u, v) + inertia_->held(right, a) - load;
  if (!side_) return force;
  return force + side_->at_end(right, side_->resistance([u](std::size_t j) { return u[j]; },
                                                        [v](std::size_t j) { return v[j]; }));
}

void BarSystem::internal_force(std::span<const double> u, std::span<const double> w, std::span<double> out) const {
  elements_->force(u, w, out);
  for (const Support& support : supports_)
    out[support.unknown] -= support.stiffness * u[support.unknown] + support.dashpot * w[support.unknown];
  if (side_)
    side_->subtract(u, w, unknowns_.first_node(), unknowns_.wall(false).value_or(0.0),
                    unknowns_.wall(true).value_or(0.0), out);
}

void BarSystem::dynamic_stiffness(double m, double c, double k, BandedMatrix& out) const {
  elements_->dynamic_stiffness(inertia_->matrix(), m, c, k, out);
  for (const Support& support : supports_) out.diagonal[support.unknown] += c * support.dashpot + k * support.stiffness;
  if (side_) side_->add_to(out, unknowns_.first_node(), c, k);
}

double BarSystem::energy(std::span<const double> u, std::span<const double> w) const {
  double sum = 0.5 * inertia_->matrix().quadratic_form(w) + 0.5 * bar().modulus * elements_->squared_strain(u);
  for (const Support& support : supports_) sum += 0.5 * support.stiffness * u[support.unknown] * u[support.unknown];
  return side_ ? sum + side_->energy(unknowns_.displacement_at_nodes(u)) : sum;
}

}  // namespace viscobar
