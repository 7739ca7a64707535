#include "campaign/campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "campaign/draw.hpp"
#include "case/alarm.hpp"
#include "properties/random_scene.hpp"
#include "support/absolute_tolerance.hpp"
#include "support/maximum_norm.hpp"

namespace viscobar::campaign {

namespace {

struct TooLong {};

struct Run {
  std::vector<double> u;
  std::vector<Event> events;
  Statistics statistics;
  double largest = 0.0, fastest = 0.0;
};

Run run_of(const Case& run) {
  Run result;
  Observers observers;
  std::size_t steps = 0;
  observers.energy = true;
  observers.snapshot = [&](const Snapshot& snapshot) {
    result.u.insert(result.u.end(), snapshot.u.begin(), snapshot.u.end());
    for (const double v : snapshot.v) result.fastest = std::max(result.fastest, std::abs(v));
  };
  observers.event = [&](const Event& event) { result.events.push_back(event); };
  observers.progress = [&](double) { return ++steps > longest ? RunControl::stop : RunControl::go_on; };
  result.statistics = simulate(resolve(run), observers);
  if (!result.statistics.completed) throw TooLong();
  result.largest = largest(result.u);
  return result;
}

// At each node closings and openings take turns, a node that closes moves in, to rounding, one that opens moves out,
// and a contact lasts. Where u has a rounding du, a node on a spring of the frequency omega has one of omega du in its
// velocity. The velocity of a node that is passed over, on a spring that a step does not resolve, is known
// to the promise. An undamped node without mass has no velocity of its own.
std::string phantom_of(const Case& run, const Run& result) {
  const Setup setup = resolve(run);
  const BarSystem system = setup.system();
  const std::vector<double> masses = system.inertia().effective_masses();
  const double unknown = 100.0 * (run.tolerance.relative * result.fastest + absolute_tolerance(run));
  std::string all;
  for (const Contact& contact : system.contacts()) {
    const std::size_t node = contact.unknown + system.unknowns().first_node();
    const double du = std::numeric_limits<double>::epsilon() * result.largest;
    const double mass = masses[contact.unknown];
    const bool spring = is_penalised(run.method) && mass > 0.0;
    const double rounding = 1e-12 * result.fastest + (spring ? du / std::sqrt(setup.epsilon * mass) : 0.0);
    std::optional<double> closed;
    for (const Event& event : result.events) {
      if (event.where != contact.where || event.node != node) continue;
      const bool closing = event.change == Change::closing;
      const double away = contact.sign * event.velocity;
      if (closing == closed.has_value()) all += fmt::format("out of turn at {}; ", event.time);
      const bool moves = !system.inertia().massless(contact.unknown) || system.bar().damped();
      if (moves && (closing ? away > rounding : away < -unknown))
        all += fmt::format("{} at {} with {}; ", closing ? "closes" : "opens", event.time, event.velocity);
      if (!closing && closed && !(event.time > *closed)) all += fmt::format("no length at {}; ", event.time);
      closed = closing ? std::optional(event.time) : std::nullopt;
    }
  }
  return all;
}

Case by_exponentials(Case run) {
  run.method = MethodName::exponential;
  return run;
}

// The largest of what a shift of the initial data by `size` changes, over `size`: one of u, of w, and of either end.
double magnification(const Case& run, const Run& exact, double size) {
  double largest = 1.0;
  const double length = run.scene.bar.length;
  const auto shifted = [&](auto&& shift) {
    Case other = run;
    shift(other.scene);
    largest = std::max(largest, distance(run_of(other).u, exact.u) / size);
  };
  const double rate = std::sqrt(run.scene.bar.modulus / run.scene.bar.density) / length;
  for (const double by : {size, -size}) {
    shifted([&](Scene& scene) { scene.displacement = [u = scene.displacement, by](double x) { return u(x) + by; }; });
    shifted([&](Scene& scene) {
      scene.displacement = [u = scene.displacement, by, length](double x) { return u(x) + by * x / length; };
    });
    shifted(
        [&](Scene& scene) { scene.velocity = [v = scene.velocity, by, rate](double x) { return v(x) + by * rate; }; });
    shifted([&](Scene& scene) {
      scene.velocity = [v = scene.velocity, by, rate, length](double x) {
        return v(x) + by * rate * std::cos(6.0 * x / length);
      };
    });
  }
  return largest;
}

}  // namespace

std::string scene_text(std::uint64_t seed, std::size_t index) {
  Draw draw(seed, index);
  properties::RandomScene scene;
  scene.length = draw.decades(0.3, 3.0);
  scene.density = draw.decades(0.3, 3.0);
  scene.modulus = draw.decades(0.1, 10.0);
  scene.elements = static_cast<int>(draw.between(2.0, 11.0));
  const double speed = std::sqrt(scene.modulus / scene.density), transit = scene.length / speed;
  // Damping ratio of a mode of the bar: half its frequency times eta / E.
  scene.viscosity = draw.chance(0.15) ? 0.0 : draw.decades(1e-4, 3.0) * scene.modulus * transit;
  scene.mass = draw.one_of({"consistent", "lumped", "redistributed"});
  scene.method = draw.one_of({"cvode", "ida", "arkode", "odeint"});
  if (scene.mass == "redistributed") {
    scene.elements = std::max(scene.elements, 3);
    if (scene.viscosity == 0.0) scene.method = "ida";
  }
  const double amplitude = draw.decades(0.03, 1.0);
  const auto gap = [&] { return draw.chance(0.2) ? 0.0 : amplitude * draw.between(0.0, 1.0); };
  const bool span = scene.mass != "redistributed" && draw.chance(0.15);
  if (span) {
    scene.span_gap = gap();
  } else {
    scene.left = {"obstacle", gap()};
    const char* right = draw.one_of({"obstacle", "obstacle", "free", "fixed"});
    scene.right = {right, std::string(right) == "obstacle" ? gap() : 0.0};
  }
  const bool moving = draw.chance(0.8);
  if (draw.chance(0.5) && scene.right.kind != "fixed")
    scene.displacement = {0.0, 0.3 * amplitude * draw.between(0.0, 1.0), draw.one_of({1, 2, 3})};
  if (scene.displacement.amplitude != 0.0) scene.displacement.base = scene.displacement.amplitude;  // starts outside
  if (moving)
    scene.velocity = {-amplitude / transit * draw.between(-0.3, 1.0), amplitude / transit * draw.between(-0.5, 0.5),
                      draw.one_of({1, 2, 3})};
  if (draw.chance(0.75)) {
    const double force = scene.density * amplitude / (transit * transit);
    scene.load = properties::Shape{-force * draw.decades(0.03, 3.0), force * draw.between(-0.2, 0.2), 1};
    if (draw.chance(0.3))
      scene.frequency = draw.decades(0.3, 10.0) / transit, scene.delay = -transit * draw.between(0, 3);
  }
  scene.epsilon = draw.decades(1e-14, 1.0) * scene.length / scene.modulus;
  const double kind = draw.between(0.0, 1.0);
  if (kind < 0.3)
    scene.restitution = 0.0;
  else if (kind < 0.8)
    scene.restitution = draw.between(0.0, 1.0);
  else if (kind < 0.9)
    scene.restitution = 1.0;
  scene.end = transit * draw.decades(2.0, 40.0);
  scene.outputs = 40;
  scene.relative = draw.decades(1e-9, 1e-4);
  scene.absolute = scene.relative * amplitude * draw.decades(1e-3, 1.0);
  return scene.toml();
}

Judged judge(const SceneFile& scene) {
  const Case& run = scene.run;
  Judged judged;
  try {
    const Run exact = run_of(by_exponentials(run));
    const Run mine = run_of(run);
    judged.events = mine.statistics.events;
    judged.phantom = phantom_of(run, mine);
    const double tolerance = run.tolerance.relative * exact.largest + absolute_tolerance(run);
    judged.error = distance(mine.u, exact.u) / (100.0 * tolerance);
    const EnergyAccount& energy = *mine.statistics.energy;
    const double scale = std::max({energy.initial, energy.final, energy.dissipated, std::abs(energy.work)});
    if (scale > 0.0) judged.balance = std::abs(energy.balance_error()) / (100.0 * run.tolerance.relative * scale);
    judged.late = mine.statistics.late_opening.ratio;
    for (const Alarm& alarm : alarms(resolve(run), resolve(run).system(), mine.statistics))
      judged.said += alarm.what + "; ";
    for (const Alarm& alarm : alarms(resolve(by_exponentials(run)), resolve(run).system(), exact.statistics))
      judged.said += "exponential: " + alarm.what + "; ";
    if (!(judged.error <= 1.0)) {
      judged.magnification = magnification(by_exponentials(run), exact, tolerance);
      judged.outcome = judged.error <= judged.magnification ? Outcome::magnified
                       : judged.said.empty()                ? Outcome::wrong
                                                            : Outcome::alarmed;
    }
  } catch (const TooLong&) {
    judged.outcome = Outcome::too_long;
  } catch (const std::exception& failure) {
    judged.outcome = Outcome::stopped;
    judged.said = failure.what();
  }
  return judged;
}

}  // namespace viscobar::campaign
