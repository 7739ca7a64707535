#include <algorithm>
#include <complex>

#include "viscobar/studies/exact/exact_solutions.hpp"

namespace viscobar::exact {

namespace {

using Complex = std::complex<double>;

// The roots s_k of s^2 (s + a) = b, a = E / eta, b = 1 / (epsilon^2 rho eta), but for the positive one.
struct Roots {
  Complex first, second;
};

Roots decaying_roots(double a, double b) {
  // Newton from above on a convex increasing function descends to the positive root.
  double positive = std::cbrt(b);
  for (int k = 0; k < 100; ++k) {
    const double step = (positive * positive * (positive + a) - b) / (positive * (3 * positive + 2 * a));
    positive -= step;
    if (std::abs(step) <= 1e-16 * positive) break;
  }
  // The remaining factor is s^2 + (a + positive) s + (a + positive) positive.
  const double sum = a + positive;
  const Complex root = std::sqrt(Complex(sum * (a - 3 * positive)));
  const Complex larger = -0.5 * (sum + root);
  return {larger, sum * positive / larger};
}

// The `order`-th derivative of d in time: each term multiplied by (its exponent)^order.
double inverse(const ImpactLaw& law, double t, int order) {
  const double rho = law.bar.density, E = law.bar.modulus, eta = law.bar.viscosity, epsilon = law.epsilon;
  const double rest = epsilon * std::sqrt(rho * E);
  if (eta == 0.0) return law.speed * (order == 0 ? -rest * std::expm1(-t / rest) : std::exp(-t / rest));

  const double a = E / eta, b = 1 / (epsilon * epsilon * rho * eta);
  double sum = order == 0 ? rest : 0.0;
  const Roots roots = decaying_roots(a, b);
  for (const Complex s : {roots.first, roots.second})
    sum += (std::pow(s, order) * std::exp(s * t) / (s + s * s * s * s / (2 * b))).real();

  // x = a + y^2, y = e^w makes the integrand analytic in a strip of half-width pi/6 about the real w, where the
  // trapezoidal rule converges like exp(-2 pi (pi/6) / step).
  constexpr double step = 0.08;
  const double low = 0.5 * std::log(std::min(a, std::cbrt(b))) - 14.0;
  const double high = 0.5 * std::log(std::max(a, std::cbrt(b))) + 10.0;
  double integral = 0.0;
  for (double w = low; w < high; w += step) {
    const double y = std::exp(w), x = a + y * y, z2 = rho * eta * y * y;
    const double decay = std::exp(-x * t);
    if (decay == 0.0) break;
    const double power = order == 0 ? 1.0 : -x;
    integral += power * decay * 2 * y * y * std::sqrt(z2) / (x * (1 + epsilon * epsilon * x * x * z2));
  }
  return law.speed * (sum + epsilon / std::numbers::pi * integral * step);
}

}  // namespace

double ImpactLaw::penetration(double t) const { return t <= 0.0 ? 0.0 : inverse(*this, t, 0); }

double ImpactLaw::rate(double t) const { return t < 0.0 ? 0.0 : t == 0.0 ? speed : inverse(*this, t, 1); }

std::optional<ImpactLaw::Peak> ImpactLaw::peak() const {
  if (bar.viscosity == 0.0) return {};
  // Before the peak the bar is all viscosity or all elasticity, whichever stops it sooner.
  const double tau = std::cbrt(epsilon * epsilon * bar.density * bar.viscosity);
  const double rest = epsilon * bar.impedance();
  double before = 0.0;
  for (double after = 0.25 * std::min(tau, rest); after < 40.0 * std::max(tau, rest); after *= 1.25) {
    if (rate(after) > 0.0) {
      before = after;
      continue;
    }
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (before + after);
      (rate(middle) > 0.0 ? before : after) = middle;
    }
    return Peak{before, penetration(before)};
  }
  return {};
}

}  // namespace viscobar::exact
