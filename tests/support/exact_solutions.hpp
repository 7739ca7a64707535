#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "viscobar/scene/scene.hpp"

/// Closed solutions of rho u_tt - E u_xx - eta u_xxt = f to measure methods against; each comes with its scene.
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

/// Undamped bar that flies unstrained at -speed, meets the obstacle at its left end at gap / speed, is pressed against
/// it with E speed / c for 2 L / c, c = sqrt(E / rho), and leaves unstrained at +speed. Before the impact it is the
/// rigid flight of any bar.
struct ElasticImpact {
  Bar bar;
  double speed = 1.0;
  double gap = 0.1;

  double wave_speed() const { return std::sqrt(bar.modulus / bar.density); }
  double closing() const { return gap / speed; }
  double opening() const { return closing() + 2 * bar.length / wave_speed(); }
  double reaction(double t) const { return t > closing() && t < opening() ? bar.modulus * speed / wave_speed() : 0.0; }
  double u(double x, double t) const {
    const double c = wave_speed(), since = t - closing();
    if (since < 0.0) return -speed * t;
    return -gap - speed * std::min(since, x / c) + speed * std::max(0.0, since - (2 * bar.length - x) / c);
  }
  double energy() const { return 0.5 * bar.density * bar.length * speed * speed; }

  Scene scene() const {
    Scene scene;
    scene.bar = bar;
    scene.left = Obstacle{gap};
    scene.displacement = [](double) { return 0.0; };
    scene.velocity = [w = speed](double) { return -w; };
    return scene;
  }
};

/// Undamped bar of length, density and modulus 1, right end fixed, on the obstacle with gap 0 from a uniform stretch:
/// period 3, in contact on [1, 2) with reaction 1/2, energy 1/8 [Dabaghi, Petrov, Pousin, Renard 2014].
struct PeriodThree {
  static constexpr double period = 3.0, closing = 1.0, opening = 2.0, energy = 0.125;

  static double end_displacement(double t) {
    const double phase = std::fmod(t, period);
    return phase < closing ? (1.0 - phase) / 2 : phase < opening ? 0.0 : (phase - 2.0) / 2;
  }
  static double reaction(double t) {
    const double phase = std::fmod(t, period);
    return phase >= closing && phase < opening ? 0.5 : 0.0;
  }
  static Scene scene() {
    Scene scene;
    scene.left = Obstacle{0.0};
    scene.right = Fixed{};
    scene.displacement = [](double x) { return (1.0 - x) / 2; };
    scene.velocity = [](double) { return 0.0; };
    return scene;
  }
};

/// Contact of a viscous bar with given opening g = s_+^3 and reaction r = (-s)_+^2, s = sin(omega t), complementary by
/// construction; rho = E = 1, obstacle on the left, right end free:
///
///     u = -gap + g + p phi,   phi = x - x^2 / (2 L),   alpha p' + p = -r, p(0) = 0,   f = g'' + p'' phi - r / L.
///
/// Open on the even half periods, closed on the odd ones.
struct ManufacturedContact {
  double length = 1.0, alpha = 0.5, omega = 2 * pi, gap = 0.25;

  double phi(double x) const { return x - x * x / (2 * length); }
  double half_period() const { return pi / omega; }
  double reaction(double t) const {
    const double s = std::min(0.0, std::sin(omega * t));
    return s * s;
  }
  double p(double t) const {
    double value = 0.0;
    for (int k = 0; k * half_period() < t; ++k) {
      const double begin = k * half_period(), end = std::min(t, begin + half_period());
      value *= std::exp((begin - end) / alpha);
      if (k % 2 == 1) value -= weighted_sine(end) - std::exp((begin - end) / alpha) * weighted_sine(begin);
    }
    return value;
  }
  double p_t(double t) const { return -(reaction(t) + p(t)) / alpha; }
  double p_tt(double t) const {
    const double reaction_t = 2 * omega * std::cos(omega * t) * std::min(0.0, std::sin(omega * t));
    return -(reaction_t + p_t(t)) / alpha;
  }
  double u(double x, double t) const {
    const double s = std::max(0.0, std::sin(omega * t));
    return -gap + s * s * s + p(t) * phi(x);
  }
  double v(double x, double t) const {
    const double s = std::max(0.0, std::sin(omega * t));
    return 3 * s * s * omega * std::cos(omega * t) + p_t(t) * phi(x);
  }
  double f(double x, double t) const {
    const double s = std::max(0.0, std::sin(omega * t)), c = std::cos(omega * t);
    return 3 * omega * omega * s * (2 * c * c - s * s) + p_tt(t) * phi(x) - reaction(t) / length;
  }

  Scene scene() const {
    Scene scene;
    scene.bar = {length, 1.0, 1.0, alpha};
    scene.left = Obstacle{gap};
    scene.displacement = [g = gap](double) { return -g; };
    scene.velocity = [](double) { return 0.0; };
    scene.load = GeneralLoad{[self = *this](double x, double t) { return self.f(x, t); }};
    return scene;
  }

 private:
  // (1 / alpha) e^{-t/alpha} times the antiderivative of e^{t/alpha} sin^2(omega t).
  double weighted_sine(double t) const {
    const double rate = 1 / alpha, w = 2 * omega;
    return 0.5 - rate * (rate * std::cos(w * t) + w * std::sin(w * t)) / (2 * (rate * rate + w * w));
  }
};

}  // namespace viscobar::exact
