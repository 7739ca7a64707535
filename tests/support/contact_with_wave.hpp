#pragma once

#include <cmath>
#include <numbers>

#include "viscobar/studies/exact/exact_solutions.hpp"

namespace viscobar::exact {

/// A manufactured contact with a wave on top,
///
///     u + b cos(omega t) psi,    f + b ((E cos(omega t) - eta omega sin(omega t)) (-psi'') - rho omega^2 cos(omega t)
///     psi),
///
/// psi = e^{skew x / L} sin^2(pi x / L): it vanishes at both ends with its slope, so gaps, reactions and contact times
/// stay. With a skew its third derivative does not vanish at the ends. The manufactured contact alone is a polynomial
/// of degree 2 (one end) or 3 in x, for which three-point differences are exact: measured with it, a mesh error would
/// be missing.
///
/// It begins at t0: at t0 = 0 the ends touch at rest and the wave alone accelerates, at 0.1 they are on their way.
inline Solution contact_with_wave(const ManufacturedContact& contact, double t0, double skew = 0.0) {
  constexpr double b = 0.1, omega = 3.0;
  const Bar bar = contact.bar;
  const double k = 2 * std::numbers::pi / bar.length;
  const double a = skew / bar.length;
  const auto psi = [k, a](double x) { return 0.5 * std::exp(a * x) * (1 - std::cos(k * x)); };
  const auto psi_xx = [k, a](double x) {
    return 0.5 * std::exp(a * x) *
           (a * a * (1 - std::cos(k * x)) + 2 * a * k * std::sin(k * x) + k * k * std::cos(k * x));
  };
  Solution sum = solution(contact);
  sum.u = [=](double x, double t) { return contact.u(x, t) + b * std::cos(omega * t) * psi(x); };
  sum.v = [=](double x, double t) { return contact.v(x, t) - b * omega * std::sin(omega * t) * psi(x); };
  sum.scene.load = GeneralLoad{[=](double x, double t) {
    const double c = b * std::cos(omega * t), s = b * std::sin(omega * t);
    return contact.f(x, t) - (bar.modulus * c - bar.viscosity * omega * s) * psi_xx(x) -
           bar.density * omega * omega * c * psi(x);
  }};
  return later(std::move(sum), t0);
}

}  // namespace viscobar::exact
