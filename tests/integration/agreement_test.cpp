// cvode, ida, arkode and odeint against the exponential reference: for every pair of ends, every mass, with and without
// load and viscosity, at several penalties. One constant for all scenes: the error of the displacement stays below 100
// (relative max|u| + absolute), in the maximum norm over nodes and output times, and that of the velocity likewise, but
// for what an event that is late by du/v does to it: while a contact spring turns a node round, the acceleration is v
// omega, and such a lateness shows as omega du. omega = (epsilon m)^(-1/2) is the frequency of the node on its spring.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "support/maximum_norm.hpp"
#include "support/paper_throw.hpp"
#include "viscobar/case/recording.hpp"

namespace viscobar::testing_agreement {
namespace {

constexpr double constant = 100.0;

EndCondition end_condition(char kind) {
  if (kind == 'o') return Obstacle{0.1};
  if (kind == 'x') return Fixed{};
  return Free{};
}

Case scene(const std::string& ends, Mass mass, bool loaded, double viscosity, double epsilon) {
  Case run;
  run.scene.bar = {1.0, 1.0, 1.0, viscosity};
  run.scene.left = end_condition(ends[0]);
  run.scene.right = end_condition(ends[1]);
  // Not symmetric: contacts of the two ends must not coincide, where order would be a matter of rounding.
  run.scene.displacement = [](double x) { return x * (1.1 - x); };
  run.scene.velocity = [](double x) { return -0.8 - 0.4 * x; };
  if (loaded)
    run.scene.load = SeparableLoad{[](double x) { return 0.5 + std::cos(2 * x); },
                                   [](double t) { return -std::sin(t * std::sqrt(2.0)); }};
  run.elements = 8;
  run.mass = mass;
  run.epsilon = epsilon;
  run.end = 2.5;
  run.output_every = 0.05;
  return run;
}

Recording run_by(Case run, MethodName method, double tolerance) {
  run.method = method;
  run.tolerance = {tolerance, tolerance * 1e-3};
  return record(run);
}

// Frequency of a contact node on its spring; h/6 is below the effective mass of every kind of mass. None for massless
// nodes.
double contact_frequency(const Case& run) {
  const bool obstacle = is_obstacle(run.scene.left) || is_obstacle(run.scene.right);
  if (!obstacle || run.mass == Mass::redistributed) return 0.0;
  return std::sqrt(6.0 / (*run.epsilon * run.mesh().spacing()));
}

void expect_agreement(const Case& run, const Recording& reference, const Recording& other, double tolerance,
                      const std::string& what, double multiple = constant) {
  const double u = largest(reference.u), v = largest(reference.v);
  EXPECT_LE(distance(other.u, reference.u), multiple * tolerance * u) << what;
  EXPECT_LE(distance(other.v, reference.v), multiple * tolerance * (v + contact_frequency(run) * u)) << what;
}

// The k-th change of each contact, whatever happens at the other end meanwhile.
std::map<std::pair<Where, std::size_t>, std::vector<Event>> by_contact(const Recording& recording) {
  std::map<std::pair<Where, std::size_t>, std::vector<Event>> events;
  for (const Event& event : recording.events) events[{event.where, event.node}].push_back(event);
  return events;
}

// Two changes in a row between which the node is on the other side, no further than a quarter of speed times duration
// (the height of a parabola): where the other run is wrong by as much, it may stay on this one.
bool is_missable(const std::vector<Event>& events, std::size_t k, double error) {
  if (k + 1 >= events.size()) return false;
  const double speed = std::max(std::abs(events[k].velocity), std::abs(events[k + 1].velocity));
  return speed * (events[k + 1].time - events[k].time) / 4 <= error;
}

// Each contact's changes are those of the reference, but for missable pairs in either. A crossing is as late as the
// displacement is wrong: |v| dt <= C tol U; at a graze, v = 0, dt <= sqrt(C tol U / a).
void expect_same_events(const Recording& reference, const Recording& run, double tolerance, const std::string& what,
                        double multiple = constant) {
  const double error = multiple * tolerance * largest(reference.u);
  const double graze = std::sqrt(tolerance) * largest(reference.v);
  const auto is_same = [&](const Event& one, const Event& other) {
    return one.change == other.change && (std::abs(one.velocity) + graze) * std::abs(one.time - other.time) <= error;
  };
  auto all_expected = by_contact(reference), all_found = by_contact(run);
  for (const auto& [contact, events] : all_found) all_expected.try_emplace(contact);
  for (const auto& [contact, expected] : all_expected) {
    const std::vector<Event>& found = all_found[contact];
    for (std::size_t i = 0, k = 0; i < expected.size() || k < found.size();) {
      if (i < expected.size() && k < found.size() && is_same(expected[i], found[k])) {
        ++i, ++k;
      } else if (is_missable(expected, i, error)) {
        i += 2;
      } else if (is_missable(found, k, error)) {
        k += 2;
      } else {
        FAIL() << what << ": change " << i << " of " << expected.size() << " is not change " << k << " of "
               << found.size();
      }
    }
  }
}

// No tolerance promises more than the scene does: node against spring, undamped, one of them magnifies a shift of its
// initial data by 6000 (the others by 40).
double promise(const Case& run, const Recording& reference) {
  if (run.mass != Mass::fourth_order || run.scene.bar.viscosity > 0.0) return constant;
  constexpr double shift = 1e-9;
  Case shifted = run;
  shifted.scene.displacement = [u = run.scene.displacement](double x) { return u(x) + shift; };
  const double magnified = distance(run_by(shifted, MethodName::exponential, 1.0).u, reference.u) / shift;
  return constant * std::max(1.0, magnified / 1000);
}

// In theory error ~ tolerance^rate. The one-step methods advance the better of the two solutions whose difference they
// keep at the tolerance, h^p, so that the rate is 1, and p / (p + 1) = 4/5 where the last order is lost (p >= 4, at
// contact changes say). Formulas of several steps keep h^(q+1) at the tolerance and sum up errors to h^q: q / (q + 1),
// where backward differentiation falls back to q = 2 at worst.
double least_rate(MethodName method) {
  return method == MethodName::cvode || method == MethodName::ida ? 2.0 / 3.0 : 4.0 / 5.0;
}

using Parameters = std::tuple<std::string, Mass>;
class Agreement : public testing::TestWithParam<Parameters> {};

TEST_P(Agreement, ErrorsAndEventsFollowTheTolerance) {
  const auto& [ends, mass] = GetParam();
  const bool obstacle = ends.find('o') != std::string::npos;
  std::map<MethodName, std::vector<double>> rates;
  for (const bool loaded : {false, true}) {
    for (const double viscosity : {0.0, 0.01, 0.5}) {
      for (const double epsilon : obstacle ? std::vector{1e-2, 1e-4, 1e-6} : std::vector{1e-2}) {
        const Case run = scene(ends, mass, loaded, viscosity, epsilon);
        const Recording reference = run_by(run, MethodName::exponential, 1.0);
        const double multiple = promise(run, reference);
        for (const MethodName method : {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint}) {
          const bool differential = method == MethodName::cvode || method == MethodName::odeint;
          if (differential && mass == Mass::redistributed && viscosity == 0.0 && obstacle) continue;
          std::vector<double> errors;
          for (const double tolerance : {1e-6, 1e-8, 1e-10}) {
            const Recording other = run_by(run, method, tolerance);
            const std::string what = std::string(name(method)) + (loaded ? ", loaded" : "") + ", viscosity " +
                                     std::to_string(viscosity) + ", epsilon " + std::to_string(epsilon) +
                                     ", tolerance " + std::to_string(std::log10(tolerance));
            expect_agreement(run, reference, other, tolerance, what, multiple);
            errors.push_back(relative_error(other.u, reference.u));
            expect_same_events(reference, other, tolerance, what, multiple);
          }
          // The reference itself is good to 1e-12 or so.
          rates[method].push_back(std::log10(errors.front() / std::max(errors.back(), 1e-12)) / 4);
        }
      }
    }
  }
  // An error's constant is chance, and one scene may have it small where another has it large: the rate is the mean.
  for (const auto& [method, of_scenes] : rates)
    EXPECT_GE(std::accumulate(of_scenes.begin(), of_scenes.end(), 0.0) / static_cast<double>(of_scenes.size()),
              least_rate(method))
        << name(method);
}

std::string parameter_name(const testing::TestParamInfo<Parameters>& info) {
  return std::get<0>(info.param) + "_" + std::string(name(std::get<1>(info.param)));
}

// o obstacle, f free, x fixed
INSTANTIATE_TEST_SUITE_P(EveryScene, Agreement,
                         testing::Combine(testing::Values("oo", "of", "ox", "fo", "xo", "ff", "fx", "xf", "xx"),
                                          testing::Values(Mass::consistent, Mass::lumped, Mass::paper,
                                                          Mass::redistributed, Mass::fourth_order)),
                         parameter_name);

// Hundreds of bounces multiply errors, and a missed one would shift all that follow.
TEST(AgreementOfChatter, HoldsToTheLastBounce) {
  Case run = paper_throw(0.01);
  run.output_every = 0.05;
  const std::pair<double, std::size_t> all[] = {{1e-2, 4},   {1e-3, 12},  {1e-4, 56}, {1e-5, 352},
                                                {1e-6, 456}, {1e-7, 488}, {1e-8, 496}};
  for (const auto& [epsilon, changes] : all) {
    run.epsilon = epsilon;
    const Recording reference = run_by(run, MethodName::exponential, 1.0);
    EXPECT_EQ(reference.events.size(), changes) << epsilon;
    for (const MethodName method : {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint}) {
      for (const double tolerance : {1e-6, 1e-8, 1e-10}) {
        // Between the ends of odeint's steps a velocity is known to the rounding of u over a step.
        if (method == MethodName::odeint && epsilon < 1e-7 && tolerance < 1e-8) continue;
        const Recording other = run_by(run, method, tolerance);
        const std::string what = std::string(name(method)) + ", epsilon 1e" + std::to_string(std::log10(epsilon)) +
                                 ", tolerance 1e" + std::to_string(std::log10(tolerance));
        expect_agreement(run, reference, other, tolerance, what);
        expect_same_events(reference, other, tolerance, what);
      }
    }
  }
}

}  // namespace
}  // namespace viscobar::testing_agreement
