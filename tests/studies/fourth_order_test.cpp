// The mass fourth_order: order four in h of what a run computes, with and without impact; docs/fourth-order.md has
// theory and tables.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/contact_with_wave.hpp"
#include "support/falling_bar.hpp"
#include "viscobar/case/end_traces.hpp"
#include "viscobar/studies/orders/orders.hpp"
#include "viscobar/testing/examine.hpp"

namespace viscobar {
namespace {

// Gap and reaction have the powers 3 and 2 of the time from a change: an error h^4 of the gap moves the change by
// h^(4/3).
constexpr double within = 0.15;

exact::Solution solution_with(int ends) {
  exact::ManufacturedContact contact;
  if (ends == 2) contact.right = exact::ManufacturedContact::End{0.3, 3.0};
  constexpr double skew = 1.0;  // the third derivative in x does not vanish at the ends
  return exact::contact_with_wave(contact, 0.1, skew);
}

struct Road {
  MethodName method;
  int ends;
};
std::string text(const Road& road) {
  return std::string(name(road.method)) + (road.ends == 2 ? "_two_ends" : "_one_end");
}
void PrintTo(const Road& road, std::ostream* out) { *out << text(road); }

class FourthOrderInH : public ::testing::TestWithParam<Road> {};

TEST_P(FourthOrderInH, OfASmoothContactIsFour) {
  const auto& [method, ends] = GetParam();
  const exact::Solution solution = solution_with(ends);
  Case run;
  run.scene = solution.scene;
  run.method = method;
  run.mass = Mass::fourth_order;
  run.restitution = 0.0;
  run.elements = 20;
  run.end = 2.0;
  run.output_every = 0.05;
  run.tolerance = {1e-11, 1e-14};
  std::vector<Case> cases = refinements(run, Refine::mesh, 3);
  for (Case& one : cases) {
    const double h = one.mesh().spacing();
    // Their shares of the error are the penetration, epsilon times a reaction of one, and 10 dt^2: a hundredth of h^4.
    one.epsilon = 1e-2 * h * h * h * h;
    one.step = 0.05 * h * h;
    one.start = Start::second_order;
  }
  const OrderStudy study = order_study(record, solution, cases, Refine::mesh);
  EXPECT_TRUE(has_order(study.displacement_l2, 4.0, within)) << order_text(study);
  EXPECT_TRUE(has_order(study.end_trace, 4.0, within)) << order_text(study);
}

std::vector<Road> roads() {
  std::vector<Road> all;
  for (const int ends : {1, 2})
    for (const MethodName method :
         {MethodName::rigid, MethodName::arkode, MethodName::cvode, MethodName::ida, MethodName::fully_discrete})
      all.push_back({method, ends});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Roads, FourthOrderInH, ::testing::ValuesIn(roads()),
                         [](const auto& test) { return text(test.param); });

TEST(FourthOrderInDt, OfTheSchemeIsTwoWithTheSecondOrderStart) {
  for (const int ends : {1, 2}) {
    Case run;
    run.scene = solution_with(ends).scene;
    run.method = MethodName::fully_discrete;
    run.mass = Mass::fourth_order;
    run.elements = 40;
    run.end = 2.0;
    run.output_every = 0.05;
    run.step = 1.0 / 800;
    run.start = Start::second_order;
    const OrderStudy study = self_study(record, refinements(run, Refine::step, 5));
    EXPECT_TRUE(has_order(study.displacement_l2, 2.0, 0.1)) << order_text(study);
    EXPECT_TRUE(has_order(study.end_trace, 2.0, 0.1)) << order_text(study);
  }
}

Case resting(double viscosity, double gap, std::size_t elements) {
  Case run;
  run.scene = falling_bar(gap, 1.0, viscosity);
  run.method = MethodName::rigid;
  run.mass = Mass::fourth_order;
  run.restitution = 0.0;
  run.elements = elements;
  run.tolerance = {1e-11, 1e-14};
  return run;
}

// A Kelvin-Voigt bar in touch at t = 0: contact time and speed of rebound from its solution in Laplace space, to ten
// digits.
TEST(FourthOrderMass, ReboundsWithTheContactTimeAndSpeedOfTheContinuousBar) {
  struct Exact {
    double viscosity, opening, speed, at_120;
  };
  for (const auto& [viscosity, exact_opening, speed, at_120] :
       {Exact{1.0, 1.3692116746, 0.1503140958, 1e-9}, Exact{0.1, 1.9124710098, 0.6507936369, 4e-9},
        Exact{0.01, 1.9912495450, 0.8874003786, 3e-7}}) {
    double before = 0.0;
    for (const std::size_t elements : {30u, 60u, 120u}) {
      Case run = resting(viscosity, 0.0, elements);
      run.end = run.output_every = 2.5;
      const BarSystem system = resolve(run).system();
      double opening = 0.0, momentum = 0.0;
      Observers observers;
      observers.event = [&](const Event& event) { opening = event.time; };
      observers.snapshot = [&](const Snapshot& now) {
        std::vector<double> product(system.size());
        system.inertia().matrix().multiply(now.v, product);
        momentum = 0.0;
        for (const double entry : product) momentum += entry;
      };
      const Statistics done = simulate(resolve(run), system, observers);
      EXPECT_EQ(done.events, 2u) << viscosity << " " << elements;
      const double error = std::max(std::abs(opening - exact_opening), std::abs(momentum - speed));
      // Order four: 16, of which the tolerance and the digits of the exact values leave eight at least.
      if (elements > 30) {
        EXPECT_LT(error, before / 8) << viscosity << " " << elements;
      }
      if (elements == 120) {
        EXPECT_LT(error, at_120) << viscosity;
      }
      before = error;
    }
  }
}

// Impacts and rests of a bar of little viscosity: the sequence of changes of the finest mesh on the coarsest, order
// four.
TEST(FourthOrderMass, HasTheRightContactChangesAndOrderFourInTheEndTracesWithImpacts) {
  for (const double viscosity : {0.05, 0.003}) {
    std::vector<EndTraces> traces;
    for (const std::size_t elements : {50u, 100u, 400u}) {
      Case run = resting(viscosity, 0.1, elements);
      const double load = viscosity == 0.05 ? -4.0 : -1.0;
      run.scene.load = SteadyLoad{[load](double) { return load; }};
      run.end = 6.0;
      run.output_every = 0.05;
      traces.push_back(trace_ends(run, run.output_times()));
      EXPECT_EQ(traces.back().events.size(), viscosity == 0.05 ? 1u : 3u) << viscosity << " " << elements;
    }
    const double order = std::log2(largest_difference(traces[0], traces[2]) / largest_difference(traces[1], traces[2]));
    EXPECT_NEAR(order, 4.0, 0.5) << "3.6 to 4.0 where the layer of the impact is just resolved: " << viscosity;
    // The first change is a free fall's.
    if (viscosity == 0.05) continue;
    const auto off = [&](std::size_t k) {
      double latest = 0.0;
      for (std::size_t i = 1; i < traces[k].events.size(); ++i)
        latest = std::max(latest, std::abs(traces[k].events[i].time - traces[2].events[i].time));
      return latest;
    };
    EXPECT_NEAR(std::log2(off(0) / off(1)), 4.0, 0.5) << "the times of the others";
  }
}

// A held end whose initial velocity is another than that of what holds it stops at once, and sends a front.
TEST(FourthOrderMass, HasOrderFourWhereAFixedEndStopsAtTheStart) {
  const std::pair<SpaceFunction, TimeFunction> starts[] = {
      {[](double) { return -1.0; }, {}},
      {[](double x) { return x - 1.0; }, [](double t) { return -0.5 * t + 0.2 * t * t; }}};
  for (const auto& [velocity, motion] : starts) {
    std::vector<EndTraces> traces;
    for (const std::size_t elements : {20u, 40u, 80u, 640u}) {
      Case run = resting(1.0, 0.1, elements);
      run.scene.right = Fixed{};
      run.scene.velocity = velocity;
      if (motion)
        run.scene.right_input.motion =
            EndMotion{motion, [](double t) { return -0.5 + 0.4 * t; }, [](double) { return 0.4; }, {}};
      run.end = 1.5;
      run.output_every = 0.05;
      traces.push_back(trace_ends(run, run.output_times()));
    }
    for (const std::size_t k : {0u, 1u})
      EXPECT_NEAR(std::log2(largest_difference(traces[k], traces[3]) / largest_difference(traces[k + 1], traces[3])),
                  4.0, 0.15)
          << (motion ? "moved" : "held") << " " << k;
  }
}

// The errors of the end traces of six scenes, computed elsewhere: by modes, exact in time, against 8 J and 16 J.
TEST(FourthOrderMass, HasTheErrorsThatAnotherProgramHasOnTheSameMass) {
  struct Row {
    double viscosity, load, first, second;
    std::size_t elements, changes;
  };
  for (const Row& row : {Row{1.0, 0.0, 1.0e-7, 6.4e-9, 30, 1}, Row{0.1, 0.0, 3.3e-6, 2.5e-7, 30, 1},
                         Row{0.03, 0.0, 7.1e-5, 5.3e-6, 30, 1}, Row{0.05, -4.0, 2.5e-6, 2.1e-7, 25, 1},
                         Row{0.003, -1.0, 7.5e-4, 5.5e-5, 25, 3}, Row{0.001, -1.0, 4.3e-3, 1.3e-4, 25, 3}}) {
    std::vector<EndTraces> traces;
    for (const std::size_t elements : {row.elements, 2 * row.elements, 16 * row.elements}) {
      Case run = resting(row.viscosity, 0.1, elements);
      run.end = 6.0;
      run.scene.load = SteadyLoad{[load = row.load](double) { return load; }};
      if (row.load == 0.0) {
        run.end = 2.5;
        run.scene.load = SteadyLoad{[](double x) { return -1 - x * x; }};
        run.scene.displacement = [](double x) { return 0.4 * x * (1 - x); };
        run.scene.velocity = [](double x) { return -0.5 - x; };
      }
      run.output_every = 0.05;
      traces.push_back(trace_ends(run, run.output_times()));
      EXPECT_EQ(traces.back().events.size(), row.changes) << row.viscosity << " " << elements;
    }
    EXPECT_NEAR(largest_difference(traces[0], traces[2]) / row.first, 1.0, 0.2) << row.viscosity;
    EXPECT_NEAR(largest_difference(traces[1], traces[2]) / row.second, 1.0, 0.2) << row.viscosity;
  }
}

}  // namespace
}  // namespace viscobar
