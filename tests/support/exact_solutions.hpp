#pragma once

#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "viscobar/studies/exact/exact_solutions.hpp"

/// Modes of a bar without contact, each with its scene; those with contact are in the library.
namespace viscobar::exact {

inline constexpr double pi = std::numbers::pi;

/// Shape phi(x) with phi'' = -kappa^2 phi of a bar whose ends are free or fixed; order 0 is the first one.
struct Shape {
  double length = 1.0;
  bool left_fixed = false, right_fixed = false;
  int order = 0;

  double kappa() const {
    const double half_waves = left_fixed == right_fixed ? order + 1.0 : order + 0.5;
    return half_waves * pi / length;
  }
  double operator()(double x) const { return left_fixed ? std::sin(kappa() * x) : std::cos(kappa() * x); }
  double slope(double x) const {
    return left_fixed ? kappa() * std::cos(kappa() * x) : -kappa() * std::sin(kappa() * x);
  }

  Scene scene(const Bar& bar) const {
    Scene scene;
    scene.bar = bar;
    scene.bar.length = length;
    if (left_fixed) scene.left = Fixed{};
    if (right_fixed) scene.right = Fixed{};
    return scene;
  }
};

/// {q, q'} of rho q'' + eta k2 q' + E k2 q = 0, q(0) = 1, q'(0) = speed: every damping but the critical one (a double
/// root). With the eigenvalue k2 of a mesh it is the exact motion of the semi-discrete system.
inline std::pair<double, double> damped_amplitude(const Bar& bar, double k2, double speed, double t) {
  using Complex = std::complex<double>;
  const double decay = bar.viscosity * k2 / (2 * bar.density);
  const Complex root = std::sqrt(Complex(decay * decay - bar.modulus * k2 / bar.density));
  const Complex s1 = -decay + root, s2 = -decay - root;
  const Complex a1 = (speed - s2) / (s1 - s2), a2 = (s1 - speed) / (s1 - s2);
  const Complex e1 = a1 * std::exp(s1 * t), e2 = a2 * std::exp(s2 * t);
  return {(e1 + e2).real(), (s1 * e1 + s2 * e2).real()};
}

/// u = q(t) phi(x), no load, q(0) = 1, q'(0) = speed.
struct DampedMode {
  Bar bar;
  Shape shape;
  double speed = 0.0;

  std::pair<double, double> amplitude(double t) const {
    return damped_amplitude(bar, shape.kappa() * shape.kappa(), speed, t);
  }
  double u(double x, double t) const { return amplitude(t).first * shape(x); }
  double v(double x, double t) const { return amplitude(t).second * shape(x); }
  double u_x(double x, double t) const { return amplitude(t).first * shape.slope(x); }

  Scene scene() const {
    Scene scene = shape.scene(bar);
    scene.displacement = [s = shape](double x) { return s(x); };
    scene.velocity = [s = shape, w = speed](double x) { return w * s(x); };
    return scene;
  }
};

/// u = sin(omega t) phi(x), driven by f = ((E kappa^2 - rho omega^2) sin(omega t) + eta kappa^2 omega cos(omega t))
/// phi.
struct DrivenMode {
  Bar bar;
  Shape shape;
  double omega = 1.0;

  double u(double x, double t) const { return std::sin(omega * t) * shape(x); }
  double v(double x, double t) const { return omega * std::cos(omega * t) * shape(x); }
  double u_x(double x, double t) const { return std::sin(omega * t) * shape.slope(x); }
  double f(double x, double t) const {
    const double k2 = shape.kappa() * shape.kappa();
    return ((bar.modulus * k2 - bar.density * omega * omega) * std::sin(omega * t) +
            bar.viscosity * k2 * omega * std::cos(omega * t)) *
           shape(x);
  }

  Scene scene() const {
    Scene scene = shape.scene(bar);
    scene.displacement = [](double) { return 0.0; };
    scene.velocity = [s = shape, w = omega](double x) { return w * s(x); };
    scene.load = GeneralLoad{[self = *this](double x, double t) { return self.f(x, t); }};
    return scene;
  }
};

}  // namespace viscobar::exact
