#include "viscobar/studies/exact/exact_solutions.hpp"

#include <algorithm>

#include "viscobar/studies/compare/difference.hpp"

namespace viscobar::exact {

Scene RigidFlight::scene() const {
  Scene scene;
  scene.bar = bar;
  scene.left = Obstacle{gap};
  scene.displacement = [](double) { return 0.0; };
  scene.velocity = [w = speed](double) { return -w; };
  return scene;
}

double ElasticImpact::u(double x, double t) const {
  const double c = wave_speed(), since = t - closing();
  if (since < 0.0) return -speed * t;
  return -gap - speed * std::min(since, x / c) + speed * std::max(0.0, since - (2 * bar.length - x) / c);
}

double ElasticImpact::v(double x, double t) const {
  const double c = wave_speed(), since = t - closing();
  if (since < x / c) return -speed;
  return since > (2 * bar.length - x) / c ? speed : 0.0;
}

Scene ElasticImpact::scene() const {
  Scene scene = RigidFlight{bar, speed, gap}.scene();
  scene.bar.viscosity = 0.0;
  return scene;
}

double PeriodThree::end_displacement(double t) {
  const double phase = std::fmod(t, period);
  return phase < closing ? (1.0 - phase) / 2 : phase < opening ? 0.0 : (phase - 2.0) / 2;
}

double PeriodThree::reaction(double t) {
  const double phase = std::fmod(t, period);
  return phase >= closing && phase < opening ? 0.5 : 0.0;
}

Scene PeriodThree::scene() {
  Scene scene;
  scene.left = Obstacle{0.0};
  scene.right = Fixed{};
  scene.displacement = [](double x) { return (1.0 - x) / 2; };
  scene.velocity = [](double) { return 0.0; };
  return scene;
}

namespace {

// g = s_+^3, r = ((-s)_+)^2 and p with their derivatives at one time.
struct Amplitudes {
  double g, g_t, g_tt, r, p, p_t, p_tt;
};

// With a = E / eta: (a / E) int_{half period}^{tau} e^{-a (tau - sigma)} sin^2(omega sigma) d sigma.
double contact_response(const Bar& bar, double omega, double tau) {
  const double a = bar.modulus / bar.viscosity, w = 2 * omega, half = std::numbers::pi / omega;
  const auto antiderivative = [&](double t) {
    return 0.5 / a - (a * std::cos(w * t) + w * std::sin(w * t)) / (2 * (a * a + w * w));
  };
  return (antiderivative(tau) - std::exp(-a * (tau - half)) * antiderivative(half)) / bar.viscosity;
}

double stress(const Bar& bar, double omega, double t) {
  const double a = bar.modulus / bar.viscosity, half = std::numbers::pi / omega, period = 2 * half;
  // Every period past has left one response, decayed since: a geometric series.
  const double past = std::floor(t / period), tau = t - past * period;
  const double left = -contact_response(bar, omega, period) * std::expm1(-a * period * past) / std::expm1(-a * period);
  return left * std::exp(-a * tau) - (tau > half ? contact_response(bar, omega, tau) : 0.0);
}

Amplitudes amplitudes(const Bar& bar, double w, double t) {
  const double s = std::sin(w * t), c = std::cos(w * t), up = std::max(0.0, s), down = std::min(0.0, s);
  Amplitudes now{};
  now.g = up * up * up;
  now.g_t = 3 * w * up * up * c;
  now.g_tt = 3 * w * w * up * (2 * c * c - s * s);
  now.r = down * down;
  now.p = stress(bar, w, t);
  now.p_t = -(now.r + bar.modulus * now.p) / bar.viscosity;
  now.p_tt = -(2 * w * c * down + bar.modulus * now.p_t) / bar.viscosity;
  return now;
}

struct Shapes {
  double A, A_xx, phi, phi_xx;
};

Shapes shapes(double length, bool both, double x) {
  if (!both) return {1.0, 0.0, x - x * x / (2 * length), -1.0 / length};
  const double y = x / length;
  return {1 - y * y * (3 - 2 * y), (12 * y - 6) / (length * length), length * y * (1 - y) * (1 - y),
          (6 * y - 4) / length};
}

// Sum of `term(end, shapes there, amplitudes now)` over the ends with an obstacle.
template <class Term>
double sum_over_ends(const ManufacturedContact& contact, double x, double t, Term term) {
  const double length = contact.bar.length;
  const bool both = contact.left && contact.right;
  double sum = 0.0;
  for (const auto& [end, from_end] : {std::pair(contact.left, x), std::pair(contact.right, length - x)})
    if (end) sum += term(*end, shapes(length, both, from_end), amplitudes(contact.bar, end->omega, t));
  return sum;
}

}  // namespace

double ManufacturedContact::End::opening(double t) const {
  const double up = std::max(0.0, std::sin(omega * t));
  return up * up * up;
}

double ManufacturedContact::End::reaction(double t) const {
  const double down = std::min(0.0, std::sin(omega * t));
  return down * down;
}

double ManufacturedContact::u(double x, double t) const {
  return sum_over_ends(*this, x, t, [](const End& end, const Shapes& at, const Amplitudes& now) {
    return (now.g - end.gap) * at.A + now.p * at.phi;
  });
}

double ManufacturedContact::v(double x, double t) const {
  return sum_over_ends(*this, x, t, [](const End&, const Shapes& at, const Amplitudes& now) {
    return now.g_t * at.A + now.p_t * at.phi;
  });
}

double ManufacturedContact::f(double x, double t) const {
  return sum_over_ends(*this, x, t, [&](const End& end, const Shapes& at, const Amplitudes& now) {
    return bar.density * (now.g_tt * at.A + now.p_tt * at.phi) -
           (bar.modulus * (now.g - end.gap) + bar.viscosity * now.g_t) * at.A_xx + now.r * at.phi_xx;
  });
}

std::vector<Event> ManufacturedContact::changes(double end) const {
  std::vector<Event> events;
  const auto add = [&](const End& contact, Where where) {
    const double half = std::numbers::pi / contact.omega;
    for (int k = 1; k * half < end; ++k)
      events.push_back({k * half, where, 0, k % 2 == 1 ? Change::closing : Change::opening, 0.0});
  };
  if (left) add(*left, Where::left);
  if (right) add(*right, Where::right);
  std::stable_sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.time < b.time; });
  return events;
}

Scene ManufacturedContact::scene() const {
  Scene scene;
  scene.bar = bar;
  if (left) scene.left = Obstacle{left->gap};
  if (right) scene.right = Obstacle{right->gap};
  scene.displacement = [self = *this](double x) { return self.u(x, 0.0); };
  scene.velocity = [](double) { return 0.0; };
  scene.load = GeneralLoad{[self = *this](double x, double t) { return self.f(x, t); }};
  return scene;
}

Solution solution(const ElasticImpact& impact) {
  return {impact.scene(),
          [impact](double x, double t) { return impact.u(x, t); },
          [impact](double x, double t) { return impact.v(x, t); },
          [impact](double t) { return impact.reaction(t); },
          {}};
}

Solution solution(const ManufacturedContact& contact) {
  return {contact.scene(), [contact](double x, double t) { return contact.u(x, t); },
          [contact](double x, double t) { return contact.v(x, t); },
          [contact](double t) { return contact.reaction_left(t); },
          [contact](double t) { return contact.reaction_right(t); }};
}

Solution later(Solution solution, double t0) {
  const auto shifted = [t0](const SpaceTimeFunction& f) -> SpaceTimeFunction {
    return [f, t0](double x, double t) { return f(x, t0 + t); };
  };
  const auto shifted_end = [t0](const TimeFunction& f) -> TimeFunction {
    if (!f) return {};
    return [f, t0](double t) { return f(t0 + t); };
  };
  solution.u = shifted(solution.u);
  solution.v = shifted(solution.v);
  solution.reaction_left = shifted_end(solution.reaction_left);
  solution.reaction_right = shifted_end(solution.reaction_right);
  solution.scene.displacement = [u = solution.u](double x) { return u(x, 0.0); };
  solution.scene.velocity = [v = solution.v](double x) { return v(x, 0.0); };
  if (solution.scene.load) {
    GeneralLoad& load = std::get<GeneralLoad>(*solution.scene.load);
    const auto since_then = [t0](std::optional<double> t) { return t ? std::optional(*t - t0) : t; };
    load.density = shifted(load.density);
    if (load.breaks)
      load.breaks = [f = load.breaks, t0, since_then](double after, double until) {
        return since_then(f(t0 + after, t0 + until));
      };
    if (load.breaks_at)
      load.breaks_at = [f = load.breaks_at, t0, since_then](double x, double after, double until) {
        return since_then(f(x, t0 + after, t0 + until));
      };
  }
  return solution;
}

namespace {

Recording sampled(const Solution& solution, const Mesh& mesh, std::vector<double> times) {
  Recording recording;
  recording.label = "exact";
  recording.mesh = mesh;
  recording.times = std::move(times);
  for (const double t : recording.times) {
    for (std::size_t j = 0; j < mesh.nodes(); ++j) {
      recording.u.push_back(solution.u(mesh.node(j), t));
      if (solution.v) recording.v.push_back(solution.v(mesh.node(j), t));
    }
    recording.reaction_left.push_back(solution.reaction_left ? solution.reaction_left(t) : 0.0);
    recording.reaction_right.push_back(solution.reaction_right ? solution.reaction_right(t) : 0.0);
  }
  return recording;
}

// L1 norm in time, by the trapezoidal rule; 0 of what is not known.
double distance(const std::vector<double>& a, const std::vector<double>& b, const std::vector<double>& times) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const double before = k > 0 ? times[k] - times[k - 1] : 0.0;
    const double after = k + 1 < times.size() ? times[k + 1] - times[k] : 0.0;
    sum += 0.5 * (before + after) * std::abs(a[k] - b[k]);
  }
  return sum;
}

}  // namespace

Solver solver(Solution solution) {
  return
      [solution = std::move(solution)](const Case& run) { return sampled(solution, run.mesh(), run.output_times()); };
}

Error error(const Recording& recording, const Solution& solution) {
  const Recording exact = sampled(solution, recording.mesh, recording.times);
  const Difference off = compare(recording, exact);
  return {off.displacement_l2.value_or(0.0), off.velocity_l2.value_or(0.0), off.end_trace,
          std::max(distance(recording.reaction_left, exact.reaction_left, recording.times),
                   distance(recording.reaction_right, exact.reaction_right, recording.times))};
}

}  // namespace viscobar::exact
