// Derivatives of runs through contact, against those of a solution that shares no code with the library: complex
// arithmetic through matrix exponentials.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "sensitivity/complex_bar.hpp"
#include "viscobar/case/case.hpp"

namespace {

using namespace viscobar;
using Number = ComplexBar::Number;

constexpr double tiny = 1e-40;

/// A parameter of both: its key, and where it is in the referee.
struct Parameter {
  std::string key;
  std::function<Number&(ComplexBar&)> of;
};

const std::vector<Parameter>& parameters() {
  static const std::vector<Parameter> all = {
      {"bar.viscosity", [](ComplexBar& bar) -> Number& { return bar.viscosity; }},
      {"bar.modulus", [](ComplexBar& bar) -> Number& { return bar.modulus; }},
      {"bar.density", [](ComplexBar& bar) -> Number& { return bar.density; }},
      {"bar.length", [](ComplexBar& bar) -> Number& { return bar.length; }},
      {"left.gap", [](ComplexBar& bar) -> Number& { return *bar.left_gap; }},
      {"right.gap", [](ComplexBar& bar) -> Number& { return *bar.right_gap; }},
      {"contact.epsilon", [](ComplexBar& bar) -> Number& { return bar.epsilon; }},
      {"contact.restitution", [](ComplexBar& bar) -> Number& { return bar.restitution; }},
      {"load", [](ComplexBar& bar) -> Number& { return bar.f_1; }},
      {"throw", [](ComplexBar& bar) -> Number& { return bar.c; }},
  };
  return all;
}

Case case_of(const ComplexBar& bar, MethodName method, double tolerance) {
  Case run;
  run.scene.bar = {bar.length.real(), bar.density.real(), bar.modulus.real(), bar.viscosity.real()};
  if (bar.left_gap) run.scene.left = Obstacle{bar.left_gap->real()};
  if (bar.right_gap) run.scene.right = Obstacle{bar.right_gap->real()};
  run.scene.displacement = [&bar](double x) { return bar.a.real() * x + bar.b.real(); };
  run.scene.velocity = [&bar](double x) { return bar.c.real() + bar.d.real() * x; };
  run.scene.load = GeneralLoad{
      [&bar](double, double t) { return bar.f_0.real() + bar.f_1.real() * std::sin(bar.omega.real() * t); }};
  run.elements = bar.elements;
  run.mass = bar.inertia == ComplexBar::Inertia::lumped         ? Mass::lumped
             : bar.inertia == ComplexBar::Inertia::fourth_order ? Mass::fourth_order
                                                                : Mass::consistent;
  run.epsilon = bar.epsilon.real();
  run.restitution = bar.restitution.real();
  run.method = method;
  run.tolerance = {tolerance};
  run.end = bar.end;
  run.output_every = bar.end / 20.0;
  return run;
}

Direction along(const Case& run, const ComplexBar& bar, const std::string& key) {
  if (key != "load" && key != "throw") return direction(run, key);
  Direction parameter = direction(run, "bar.density");
  parameter.key = key;
  parameter.bar.density = 0.0;
  if (key == "throw") parameter.data.velocity = [](double) { return 1.0; };
  if (key == "load")
    parameter.data.load = GeneralLoad{[&bar](double, double t) { return std::sin(bar.omega.real() * t); }};
  return parameter;
}

/// The largest differences of a run's derivatives from the referee's, each over the largest that the referee has, and
/// over what the scene magnifies: by how many tolerances that derivative of the referee's changes when a tolerance is
/// added to a, b, c or d, and a tolerance of the largest derivative of the motion to the derivative of it, where that
/// is more than one. After many contacts, or where a contact ends slowly, it may be a thousand.
struct Verdict {
  bool same_sequence = false, lost = false;
  std::size_t changes = 0;
  double traces = 0.0, times = 0.0, accounts = 0.0;
};

Verdict judge(ComplexBar bar, const Parameter& parameter, MethodName method, double tolerance) {
  Case run = case_of(bar, method, tolerance);
  const Direction direction = along(run, bar, parameter.key);
  const BarSystem system = resolve(run).system();
  Observers observers;
  observers.account = observers.energy = true;
  observers.directions = std::span(&direction, 1);
  std::vector<std::vector<double>> told;
  std::vector<double> motion;
  observers.snapshot = [&](const Snapshot& now) {
    const FieldSensitivity& s = now.sensitivities[0];
    std::vector<double> both(s.u.begin(), s.u.end());
    both.insert(both.end(), s.v.begin(), s.v.end());
    told.push_back(both);
  };
  std::vector<Event> events;
  observers.event = [&](const Event& event) { events.push_back(event); };
  const Statistics done = simulate(resolve(run), system, observers);

  parameter.of(bar) += Number(0.0, tiny);
  std::vector<double> times = run.output_times();
  times.erase(times.begin());
  const ComplexBar::Result truth = bar.run(times);
  Verdict verdict;
  verdict.changes = truth.changes.size();
  verdict.lost = done.sensitivity->lost.has_value();
  verdict.same_sequence = events.size() == truth.changes.size();
  for (std::size_t i = 0; i < events.size() && verdict.same_sequence; ++i)
    verdict.same_sequence = std::abs(events[i].time - truth.changes[i].time.real()) < 1e-3 * bar.end;
  if (!verdict.same_sequence || verdict.lost) return verdict;
  const std::size_t n = bar.elements + 1;
  double displacement = 0.0, velocity = 0.0;
  for (const ComplexBar::Vector& state : truth.states) {
    displacement = std::max(displacement, state.head(n).imag().cwiseAbs().maxCoeff());
    velocity = std::max(velocity, state.tail(n).imag().cwiseAbs().maxCoeff());
  }
  std::vector<ComplexBar::Result> nudged;
  for (const auto& [nudge, largest] : {std::pair{&ComplexBar::b, displacement}, std::pair{&ComplexBar::a, displacement},
                                       std::pair{&ComplexBar::c, velocity}, std::pair{&ComplexBar::d, velocity}}) {
    ComplexBar other = bar;
    other.*nudge += tolerance * Number(1.0, largest);
    nudged.push_back(other.run(times));
    verdict.same_sequence &= nudged.back().changes.size() == truth.changes.size();
  }
  if (!verdict.same_sequence) return verdict;
  // `slope` of a result.
  const auto magnified = [&](const auto& slope, double largest) {
    double moved = tolerance;
    for (const ComplexBar::Result& other : nudged)
      moved = std::max(moved, std::abs(slope(other) - slope(truth)) / largest);
    return moved / tolerance;
  };
  for (const std::size_t half : {0, 1}) {
    double largest = 0.0, worst = 0.0, gain = 1.0;
    const auto at = [&](std::size_t k, std::size_t j) {
      return [k, j](const ComplexBar::Result& of) { return of.states[k](static_cast<Eigen::Index>(j)).imag() / tiny; };
    };
    for (std::size_t k = 0; k < times.size(); ++k)
      for (std::size_t j = half * n; j < (half + 1) * n; ++j) {
        largest = std::max(largest, std::abs(at(k, j)(truth)));
        worst = std::max(worst, std::abs(told[k + 1][j] - at(k, j)(truth)));
      }
    if (largest > 0.0)
      for (std::size_t k = 0; k < times.size(); ++k)
        for (std::size_t j = half * n; j < (half + 1) * n; ++j) gain = std::max(gain, magnified(at(k, j), largest));
    verdict.traces = std::max(verdict.traces, (largest > 0.0 ? worst / largest : worst) / gain);
  }
  for (std::size_t i = 0; i < events.size(); ++i) {
    const auto slope = [&](const ComplexBar::Result& of) { return of.changes[i].time.imag() / tiny; };
    const double told_slope = events[i].sensitivities[0].time, largest = std::max(1.0, std::abs(slope(truth)));
    if (std::isnan(told_slope)) continue;
    verdict.times =
        std::max(verdict.times, std::abs(told_slope - slope(truth)) / (largest * magnified(slope, largest)));
  }
  const auto account = [&](double value, const auto& number) {
    const auto slope = [&](const ComplexBar::Result& of) { return number(of).imag() / tiny; };
    const double largest = std::max(1.0, std::abs(slope(truth)));
    verdict.accounts =
        std::max(verdict.accounts, std::abs(value - slope(truth)) / (largest * magnified(slope, largest)));
  };
  using Result = ComplexBar::Result;
  account(done.sensitivity->impulse_left[0], [](const Result& of) { return of.impulse_left; });
  account(done.sensitivity->impulse_right[0], [](const Result& of) { return of.impulse_right; });
  account(done.sensitivity->energy[0], [](const Result& of) { return of.energy; });
  return verdict;
}

ComplexBar thrown(ComplexBar::Law law) {
  ComplexBar bar;
  bar.elements = 6;
  bar.left_gap = 0.1;
  bar.right_gap = 0.3;
  bar.c = -1.0, bar.d = 0.3, bar.a = 0.05;
  bar.f_0 = -0.3, bar.f_1 = 0.5, bar.omega = 2.0;
  bar.viscosity = 0.2;
  bar.end = 2.5;
  bar.law = law;
  if (law == ComplexBar::Law::rigid) bar.restitution = 0.0;
  return bar;
}

void expect_agreement(const Verdict& found, double within, const std::string& what) {
  EXPECT_TRUE(found.same_sequence) << what;
  EXPECT_FALSE(found.lost) << what;
  EXPECT_LT(found.traces, within) << what;
  EXPECT_LT(found.times, within) << what;
  EXPECT_LT(found.accounts, within) << what;
}

// The promise of methods: 100 tolerances.
constexpr double tight = 1e-9, promised = 100.0 * tight;

TEST(Referee, AgreesInEachParameterThroughContactWithASpring) {
  const ComplexBar bar = thrown(ComplexBar::Law::spring);
  for (const MethodName method : {MethodName::cvode, MethodName::ida, MethodName::arkode})
    for (const Parameter& parameter : parameters())
      if (parameter.key != "contact.restitution")
        expect_agreement(judge(bar, parameter, method, tight), promised,
                         fmt::format("{} by {}", parameter.key, name(method)));
}

TEST(Referee, AgreesInEachParameterWithADashpotBesideTheSpring) {
  ComplexBar bar = thrown(ComplexBar::Law::spring);
  bar.restitution = 0.4;
  for (const Parameter& parameter : parameters())
    expect_agreement(judge(bar, parameter, MethodName::cvode, tight), promised, parameter.key);
}

TEST(Referee, AgreesInEachParameterOfARigidContactThatStopsDead) {
  for (const auto inertia :
       {ComplexBar::Inertia::fourth_order, ComplexBar::Inertia::consistent, ComplexBar::Inertia::lumped}) {
    ComplexBar bar = thrown(ComplexBar::Law::rigid);
    bar.inertia = inertia;
    for (const Parameter& parameter : parameters())
      if (!parameter.key.starts_with("contact."))
        expect_agreement(judge(bar, parameter, MethodName::rigid, tight), promised, parameter.key);
  }
}

TEST(Referee, AgreesInEachParameterOfARigidContactThatRebounds) {
  ComplexBar bar = thrown(ComplexBar::Law::rigid);
  bar.inertia = ComplexBar::Inertia::fourth_order;
  bar.restitution = 0.5;
  bar.viscosity = 0.02;
  bar.end = 0.113;
  for (const Parameter& parameter : parameters())
    if (parameter.key != "contact.epsilon")
      expect_agreement(judge(bar, parameter, MethodName::rigid, tight), promised, parameter.key);
}

TEST(Referee, AgreesWhereTheBarIsInTouchAtTheStart) {
  for (const auto law : {ComplexBar::Law::spring, ComplexBar::Law::rigid}) {
    ComplexBar bar = thrown(law);
    bar.left_gap = 0.0;
    for (const Parameter& parameter : parameters())
      if (!parameter.key.starts_with("contact."))
        expect_agreement(
            judge(bar, parameter, law == ComplexBar::Law::rigid ? MethodName::rigid : MethodName::cvode, tight),
            promised, parameter.key);
  }
}

// Both ends of a bar that flies flat close 1e-6 apart, where a step is some thousand times as long. Such a flight has
// no error, so it alone would let a step be of any length, and what the amplitude of a load does in it would be lost.
TEST(Referee, AgreesWhereTwoContactsCloseWithinAStep) {
  for (const auto law : {ComplexBar::Law::spring, ComplexBar::Law::rigid}) {
    ComplexBar bar = thrown(law);
    bar.a = 0.0, bar.d = 0.0;
    bar.f_0 = bar.f_1 = 0.0;
    bar.right_gap = *bar.left_gap + 1e-6;
    for (const Parameter& parameter : parameters())
      if (!parameter.key.starts_with("contact."))
        expect_agreement(
            judge(bar, parameter, law == ComplexBar::Law::rigid ? MethodName::rigid : MethodName::cvode, tight),
            promised, parameter.key);
  }
}

TEST(Referee, AgreesOnRandomScenes) {
  // Another seed by --gtest_random_seed.
  const int seed = ::testing::GTEST_FLAG(random_seed);
  std::mt19937 random(seed == 0 ? 7u : static_cast<unsigned>(seed));
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  constexpr double loose = 1e-8;
  std::size_t compared = 0, lost = 0, elsewhere = 0, most_changes = 0;
  double worst = 0.0;
  for (int scene = 0; compared < 200 && scene < 400; ++scene) {
    ComplexBar bar;
    bar.law = scene % 2 == 0 ? ComplexBar::Law::spring : ComplexBar::Law::rigid;
    bar.inertia = static_cast<ComplexBar::Inertia>(random() % 3);
    bar.elements = 3 + random() % 5;
    bar.length = between(0.5, 2.0), bar.density = between(0.5, 2.0), bar.modulus = between(0.5, 2.0);
    bar.viscosity = std::pow(10.0, between(-2.5, 0.0));
    bar.left_gap = between(0.02, 0.3);
    if (random() % 2) bar.right_gap = between(0.02, 0.3);
    bar.epsilon = std::pow(10.0, between(-3.0, -1.0));
    bar.restitution = bar.law == ComplexBar::Law::rigid ? 0.0 : random() % 2 ? 1.0 : between(0.2, 0.9);
    bar.c = between(-1.5, -0.2), bar.d = between(-0.5, 0.5), bar.a = between(-0.01, 0.01);
    bar.f_0 = between(-1.0, 0.2), bar.f_1 = between(-1.0, 1.0), bar.omega = between(0.5, 5.0);
    bar.end = between(1.0, 5.0);
    const std::size_t one = random() % 3;
    const MethodName penalised = one == 0 ? MethodName::ida : one == 1 ? MethodName::arkode : MethodName::cvode;
    const MethodName method = bar.law == ComplexBar::Law::rigid ? MethodName::rigid : penalised;
    const Parameter& parameter = parameters()[random() % parameters().size()];
    if (parameter.key == "right.gap" && !bar.right_gap) continue;
    if (parameter.key.starts_with("contact.") && method == MethodName::rigid) continue;
    if (parameter.key == "contact.restitution" && bar.restitution == 1.0) continue;
    Verdict found;
    try {
      found = judge(bar, parameter, method, loose);
    } catch (const std::runtime_error&) {
      continue;  // more changes than the referee follows
    }
    if (found.changes > 50) continue;
    // Where the two do not see the same contacts, or the derivative ends, there is nothing to compare.
    lost += found.lost ? 1 : 0;
    if (found.lost) continue;
    elsewhere += found.same_sequence ? 0 : 1;
    if (!found.same_sequence) continue;
    ++compared;
    most_changes = std::max(most_changes, found.changes);
    const double of = std::max({found.traces, found.times, found.accounts});
    worst = std::max(worst, of);
    EXPECT_LT(of, 100.0 * loose) << fmt::format(
        "scene {}: {} by {}, {} changes; traces {:.2g}, times {:.2g}, accounts {:.2g}", scene, parameter.key,
        name(method), found.changes, found.traces, found.times, found.accounts);
  }
  RecordProperty("compared", static_cast<int>(compared));
  fmt::print("{} compared, worst {:.1e}, up to {} changes; {} lost, {} with other contacts\n", compared, worst,
             most_changes, lost, elsewhere);
  EXPECT_EQ(compared, 200u);
  EXPECT_GT(most_changes, 20u);
  EXPECT_LT(lost + elsewhere, compared / 10);
}

}  // namespace
