#include "hard/oracle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "hard/reference.hpp"
#include "support/absolute_tolerance.hpp"
#include "viscobar/case/recorder.hpp"
#include "viscobar/studies/exact/exact_solutions.hpp"

namespace viscobar::hard {

namespace {

constexpr double rounding = std::numeric_limits<double>::epsilon();
constexpr double infinite = std::numeric_limits<double>::infinity();

double step_of(const Trial& trial) { return is_scheme(trial.run.method) ? *trial.run.step : 0.0; }

// Contacts whose changes do not take turns, beginning with a closing.
double out_of_turn(const Recording& result) {
  std::map<std::pair<Where, std::size_t>, bool> closed;
  std::size_t faults = 0;
  for (const Event& event : result.events) {
    bool& now = closed[{event.where, event.node}];
    faults += now == (event.change == Change::closing);
    now = event.change == Change::closing;
  }
  return static_cast<double>(faults);
}

double deepest(const Trial& trial) {
  const BarSystem system = resolve(trial.run).system();
  double deepest = 0.0;
  for (std::size_t k = 0; k < trial.result.times.size(); ++k)
    for (const Contact& contact : system.contacts())
      deepest = std::max(
          deepest, -(trial.result.displacement(k)[contact.unknown + system.unknowns().first_node()] + contact.gap));
  return deepest;
}

double largest_gap(const Scene& scene) {
  double gap = scene.span ? scene.span->gap : 0.0;
  for (const EndCondition* end : {&scene.left, &scene.right})
    if (const auto* obstacle = std::get_if<Obstacle>(end)) gap = std::max(gap, obstacle->gap);
  return gap;
}

// Energy is quadratic: a relative error of displacement and velocity counts twice. A scheme's account closes but for
// the rounding of its terms, a strain having that of two displacements.
Judgement energy_balance(const Trial& trial) {
  const EnergyAccount& energy = *trial.result.statistics.energy;
  const Bar& bar = trial.run.scene.bar;
  const double v = largest(trial.result.v);  // the kinetic energy on the way counts, too
  const double flow = energy.initial + std::abs(energy.work) + energy.dissipated + bar.density * bar.length * v * v / 2;
  const double u = largest(trial.result.u), strain = 2 * u / trial.run.mesh().smallest();
  double of_strains = rounding * bar.modulus * bar.length * strain * strain;
  if (is_penalised(trial.run.method) && trial.run.epsilon)
    of_strains += rounding * largest_gap(trial.run.scene) / *trial.run.epsilon / std::sqrt(bar.modulus * bar.density) *
                  flow / std::max(v, 1e-300);
  double tolerance = 1e-10 * flow + of_strains;
  if (is_adaptive(trial.run.method)) {
    const double absolute = allowance(trial.run.tolerance, resolve(trial.run).system(), trial.run.end).velocity;
    tolerance = 200 * (trial.run.tolerance.relative * flow + absolute * bar.density * bar.length * v) + of_strains;
  }
  if (is_scheme(trial.run.method))
    tolerance = 64 * rounding * static_cast<double>(trial.result.statistics.steps) * flow + of_strains;
  return {"energy balance", std::abs(energy.balance_error()), tolerance};
}

}  // namespace

double Judgement::ratio() const {
  if (std::isnan(error)) return infinite;
  return error == 0.0 ? 0.0 : error / tolerance;
}

double promised(const Trial& trial, double largest) {
  const Case& run = trial.run;
  if (is_adaptive(run.method)) return 100 * (run.tolerance.relative * largest + absolute_tolerance(run));
  if (is_scheme(run.method)) return 8 * rounding * largest * static_cast<double>(trial.result.statistics.steps);
  return 1e-11 * largest;
}

std::vector<Judgement> invariants(const Trial& trial) {
  const Case& run = trial.run;
  const Recording& result = trial.result;
  std::vector<Judgement> judgements;
  if (const auto wrong = fault(result, run)) judgements.push_back({*wrong, 1.0, 0.0});
  judgements.push_back({"completed", result.statistics.completed ? 0.0 : 1.0, 0.0});
  judgements.push_back({"changes in turn", out_of_turn(result), 0.0});
  const bool dashpot = run.restitution.value_or(1.0) < 1.0 && is_penalised(run.method);
  if (!dashpot) {
    double pull = 0.0;
    if (is_obstacle(run.scene.left)) pull = std::max(pull, -*std::ranges::min_element(result.reaction_left));
    if (is_obstacle(run.scene.right)) pull = std::max(pull, -*std::ranges::min_element(result.reaction_right));
    judgements.push_back({"no pull", pull, 0.0});
  }
  const bool relaxed = is_scheme(run.method) && run.restitution.value_or(0.0) > 0.0;
  if (!is_penalised(run.method) && !relaxed)
    judgements.push_back({"penetration", deepest(trial), promised(trial, largest(result.u))});
  judgements.push_back(energy_balance(trial));
  return judgements;
}

Oracle agreement(Sensitivity sensitivity) {
  return [sensitivity](const Trial& trial) -> std::vector<Judgement> {
    const Reference reference = make_reference(trial, sensitivity == Sensitivity::measured);
    return {{"u by " + reference.label, distance(trial.result.u, reference.recording.u), reference.tolerance}};
  };
}

Oracle exact(SpaceTimeFunction u, double largest_acceleration) {
  return [=](const Trial& trial) -> std::vector<Judgement> {
    const Recording& result = trial.result;
    double error = 0.0, reach = 0.0;
    for (std::size_t k = 0; k < result.times.size(); ++k)
      for (std::size_t j = 0; j < result.mesh.nodes(); ++j) {
        const double expected = u(result.mesh.node(j), result.times[k]);
        reach = std::max(reach, std::abs(expected));
        error = std::max(error, std::abs(result.displacement(k)[j] - expected));
      }
    const double first_order = step_of(trial) * trial.run.end * largest_acceleration;
    return {{"u in closed form", error, promised(trial, reach) + first_order}};
  };
}

Oracle first_contact(double time) {
  return [time](const Trial& trial) -> std::vector<Judgement> {
    const auto& events = trial.result.events;
    const bool closes = !events.empty() && events.front().change == Change::closing;
    // An unstrained bar: some roundings a step, of every step; and stiff rows turn roundings of the velocity into
    // strains, 12 eta / (rho h^2) of them a unit of time in an explicit or dense form.
    const Bar& bar = trial.run.scene.bar;
    const double h = trial.run.mesh().smallest();
    const double rows = trial.run.method == MethodName::odeint ? 12 * bar.viscosity / (bar.density * h * h) : 0.0;
    const double steps = std::max(1000.0, static_cast<double>(trial.result.statistics.steps));
    // A rigid contact closes once its clearance is below zero by half of the tolerance, at speeds of 1 here; if that is
    // not in the step of the zero, then at the beginning of a later one.
    const bool rigid = trial.run.method == MethodName::rigid && time < *trial.run.tolerance.absolute;
    return {{"first contact", closes ? std::abs(events.front().time - time) : infinite,
             rounding * std::max(steps, rows) * std::max(time, trial.run.end) + 2.001 * step_of(trial) +
                 (rigid ? 0.5 * *trial.run.tolerance.absolute : 0.0)}};
  };
}

Oracle changes(std::vector<Crossing> crossings) {
  return [=](const Trial& trial) -> std::vector<Judgement> {
    const auto& events = trial.result.events;
    if (events.size() != crossings.size())
      return {{fmt::format("{} contact changes instead of {}", events.size(), crossings.size()), 1.0, 0.0}};
    std::vector<Judgement> judgements;
    const double u = promised(trial, largest(trial.result.u));
    for (std::size_t k = 0; k < crossings.size(); ++k) {
      const auto& [time, speed, acceleration] = crossings[k];
      // |u'| dt + |u''| dt^2 / 2 = du, at worst
      const double late =
          acceleration > 0.0 ? (std::sqrt(speed * speed + 2 * acceleration * u) - speed) / acceleration : u / speed;
      judgements.push_back({fmt::format("change {}", k + 1), std::abs(events[k].time - time),
                            late + 2 * step_of(trial) + 64 * rounding * trial.run.end});
    }
    return judgements;
  };
}

Oracle untouched() {
  return [](const Trial& trial) -> std::vector<Judgement> {
    return {{"no contact change", static_cast<double>(trial.result.events.size()), 0.0}};
  };
}

Oracle mirrored() {
  return [](const Trial& trial) -> std::vector<Judgement> {
    const Recording& result = trial.result;
    double skew = 0.0;
    for (std::size_t k = 0; k < result.times.size(); ++k) {
      const auto u = result.displacement(k);
      for (std::size_t j = 0; j < u.size(); ++j) skew = std::max(skew, std::abs(u[j] - u[u.size() - 1 - j]));
    }
    std::vector<double> left, right;
    for (const Event& event : result.events) (event.where == Where::left ? left : right).push_back(event.time);
    return {{"mirrored u", skew, promised(trial, largest(result.u))},
            {"changes in pairs", distance(left, right), 1e-9 * trial.run.end}};
  };
}

Oracle settled(SpaceFunction u, double tolerance) {
  return [=](const Trial& trial) -> std::vector<Judgement> {
    const Recording& result = trial.result;
    double error = 0.0;
    const auto last = result.displacement(result.times.size() - 1);
    for (std::size_t j = 0; j < last.size(); ++j) error = std::max(error, std::abs(last[j] - u(result.mesh.node(j))));
    return {{"u at the end", error, tolerance + promised(trial, largest(result.u))}};
  };
}

Oracle energy_held(double scale, double per_change) {
  return [=](const Trial& trial) -> std::vector<Judgement> {
    const EnergyAccount& energy = *trial.result.statistics.energy;
    const double steps = step_of(trial) * per_change * static_cast<double>(trial.result.events.size());
    const double relative = is_adaptive(trial.run.method) ? 200 * trial.run.tolerance.relative : 1e-10;
    return {{"energy held", std::abs(energy.final - energy.initial - energy.work), relative * scale + steps}};
  };
}

Oracle impact_law() {
  return [](const Trial& trial) -> std::vector<Judgement> {
    const Case& run = trial.run;
    if (!is_penalised(run.method)) return {};
    const double gap = std::get<Obstacle>(run.scene.left).gap, speed = -run.scene.velocity(0.0);
    const exact::ImpactLaw law{run.scene.bar, speed, *run.epsilon, gap};
    double error = 0.0;
    for (std::size_t k = 0; k < trial.result.times.size(); ++k) {
      const double t = trial.result.times[k] - law.closing();
      if (t > 0.0) error = std::max(error, std::abs(trial.result.displacement(k)[0] + gap + law.penetration(t)));
    }
    return {{"impact law", error, speed * run.mesh().smallest() + promised(trial, largest(trial.result.u))}};
  };
}

namespace {

// Height of the point of bouncing() at t.
double bounce_height(double gap, double epsilon, double t) {
  // On the spring d = g / omega^2 (1 - cos) + (v / omega) sin, back at zero after theta / omega.
  const double fall = std::sqrt(2 * gap), v = fall, omega = 1 / std::sqrt(epsilon);
  const double theta = 2 * (std::numbers::pi - std::atan(v * omega)), period = 2 * fall + theta / omega;
  const double phase = std::fmod(t + fall, period);  // 0 as it leaves the obstacle
  if (phase <= 2 * fall) return -gap + v * phase - phase * phase / 2;
  const double angle = omega * (phase - 2 * fall);
  return -gap - epsilon * (1 - std::cos(angle)) - v / omega * std::sin(angle);
}

}  // namespace

Oracle bouncing(double gap, double epsilon) {
  return [=](const Trial& trial) -> std::vector<Judgement> {
    const Recording& result = trial.result;
    double error = 0.0;
    for (std::size_t k = 0; k < result.times.size(); ++k)
      for (const double u : result.displacement(k))
        error = std::max(error, std::abs(u - bounce_height(gap, epsilon, result.times[k])));
    const double bounces = 1 + static_cast<double>(result.events.size()) / 2;
    return {{"bouncing point", error, 2 * bounces * promised(trial, gap)}};
  };
}

Oracle scaled(std::function<Case(Case)> base, double factor, double tolerance) {
  return [=](const Trial& trial) -> std::vector<Judgement> {
    std::vector<double> u = record(base(trial.run)).u;
    for (double& value : u) value *= factor;
    return {{"u scaled", distance(trial.result.u, u), tolerance * largest(u)}};
  };
}

}  // namespace viscobar::hard
