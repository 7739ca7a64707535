// Observed orders against the theory of docs/orders.md, each within 0.1.
#include "viscobar/studies/orders/orders.hpp"

#include <gtest/gtest.h>

#include "support/contact_with_wave.hpp"
#include "support/paper_throw.hpp"
#include "viscobar/studies/compare/difference.hpp"
#include "viscobar/testing/examine.hpp"

namespace viscobar {
namespace {

constexpr double within = 0.1;

exact::Solution solution_with(int ends, double t0 = 0.1) {
  exact::ManufacturedContact contact;
  if (ends == 2) contact.right = exact::ManufacturedContact::End{0.3, 3.0};
  return exact::contact_with_wave(contact, t0);
}

// At 40 elements the dashpot of the bar stops a node on a spring of epsilon = h^2 / 1000, so that from there on the
// penalty's share of the error is a thousandth of h^2; dt = h/32 leaves the scheme's at that, too.
Case coarse(const Scene& scene, MethodName method, Mass mass) {
  Case run;
  run.scene = scene;
  run.method = method;
  run.mass = mass;
  run.elements = 40;
  run.end = 2.0;
  run.output_every = 0.05;
  run.tolerance = {1e-8, 1e-11};
  return run;
}

std::vector<Case> meshes(const Case& coarsest, std::size_t levels) {
  std::vector<Case> cases = refinements(coarsest, Refine::mesh, levels);
  for (Case& run : cases) {
    const double h = run.mesh().spacing();
    run.epsilon = 1e-3 * h * h;
    run.step = h / 32;
    run.start = Start::second_order;
  }
  return cases;
}

struct OnMesh {
  MethodName method;
  Mass mass;
  int ends;
  double order;
};

std::string text(const OnMesh& on) {
  return std::string(name(on.method)) + "_" + std::string(name(on.mass)) + (on.ends == 2 ? "_two_ends" : "_one_end");
}
void PrintTo(const OnMesh& on, std::ostream* out) { *out << text(on); }

class OrderInH : public ::testing::TestWithParam<OnMesh> {};

TEST_P(OrderInH, IsThatOfTheMass) {
  const auto& [method, mass, ends, order] = GetParam();
  const exact::Solution solution = solution_with(ends);
  const OrderStudy study = order_study(record, solution, meshes(coarse(solution.scene, method, mass), 3), Refine::mesh);
  EXPECT_TRUE(has_order(study.displacement_l2, order, within)) << order_text(study);
  EXPECT_TRUE(has_order(study.end_trace, order, within)) << order_text(study);
}

std::vector<OnMesh> on_meshes() {
  std::vector<OnMesh> all;
  for (const int ends : {1, 2})
    for (const MethodName method : {MethodName::fully_discrete, MethodName::cvode, MethodName::ida}) {
      all.push_back({method, Mass::consistent, ends, 2.0});
      all.push_back({method, Mass::lumped, ends, 2.0});
      all.push_back({method, Mass::paper, ends, 1.0});
    }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Masses, OrderInH, ::testing::ValuesIn(on_meshes()),
                         [](const auto& test) { return text(test.param); });

// The mass moved inward is a force rho a h/2 (1, -2, 1) on the first three nodes. Statically it displaces the second
// node alone, by O(h^2): h^(5/2) in L2; what reaches the end and the bar is O(h^3).
class Redistribution : public ::testing::TestWithParam<MethodName> {};

TEST_P(Redistribution, CostsFiveHalvesInL2AndThreeAtTheEnds) {
  for (const int ends : {1, 2}) {
    const exact::Solution solution = solution_with(ends);
    std::vector<double> spacings, norms, traces;
    for (Case run : meshes(coarse(solution.scene, GetParam(), Mass::redistributed), 3)) {
      const Recording moved = record(run);
      if (run.method == MethodName::rigid) run.method = MethodName::cvode;
      run.mass = Mass::consistent;
      const Difference found = compare(moved, record(run));
      spacings.push_back(run.mesh().spacing());
      norms.push_back(*found.displacement_l2);
      traces.push_back(found.end_trace);
    }
    EXPECT_TRUE(has_order(observed_order(spacings, norms), 2.5, within)) << ends;
    EXPECT_TRUE(has_order(observed_order(spacings, traces), 3.0, within)) << ends;
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, Redistribution,
                         ::testing::Values(MethodName::fully_discrete, MethodName::cvode, MethodName::ida,
                                           MethodName::rigid),
                         [](const auto& test) { return std::string(name(test.param)); });

class OrderInDt : public ::testing::TestWithParam<Mass> {};

TEST_P(OrderInDt, OfContactIsTwoWithTheSecondOrderStart) {
  for (const int ends : {1, 2}) {
    Case run = coarse(solution_with(ends).scene, MethodName::fully_discrete, GetParam());
    run.step = 1.0 / 800;
    run.start = Start::second_order;
    const OrderStudy study = self_study(record, refinements(run, Refine::step, 6));
    EXPECT_TRUE(has_order(study.displacement_l2, 2.0, within)) << ends << "\n" << order_text(study);
    EXPECT_TRUE(has_order(study.end_trace, 2.0, within)) << ends << "\n" << order_text(study);
  }
}

// It changes the first velocity by dt/2 u_tt. From t0 = 0, where that is small: a contact that closes without velocity
// answers to a change delta of its gap with a shift like delta^(1/3), and a large delta bends the order.
TEST_P(OrderInDt, OfTheFirstOrderStartsShareIsOne) {
  for (const int ends : {1, 2}) {
    Case run = coarse(solution_with(ends, 0.0).scene, MethodName::fully_discrete, GetParam());
    run.step = 1.0 / 1600;
    std::vector<double> steps, norms, traces;
    for (Case refined : refinements(run, Refine::step, 4)) {
      const Recording first = record(refined);
      refined.start = Start::second_order;
      const Difference share = compare(first, record(refined));
      steps.push_back(*refined.step);
      norms.push_back(*share.displacement_l2);
      traces.push_back(share.end_trace);
    }
    EXPECT_TRUE(has_order(observed_order(steps, norms), 1.0, within)) << ends;
    EXPECT_TRUE(has_order(observed_order(steps, traces), 1.0, within)) << ends;
  }
}

INSTANTIATE_TEST_SUITE_P(Masses, OrderInDt,
                         ::testing::Values(Mass::consistent, Mass::lumped, Mass::paper, Mass::redistributed),
                         [](const auto& test) { return std::string(name(test.param)); });

using MassAndStart = std::tuple<Mass, Start>;

std::string label(const ::testing::TestParamInfo<MassAndStart>& test) {
  const auto [mass, start] = test.param;
  return std::string(name(mass)) + (start == Start::first_order ? "_first" : "_second");
}

class OrderInDtOfAnImpact : public ::testing::TestWithParam<MassAndStart> {};

Case thrown(Mass mass) {
  Case run = coarse(paper_throw(0.01).scene, MethodName::fully_discrete, mass);
  run.elements = 27;
  run.step = 1.0 / 1000;
  return run;
}

// A node that the constraint stops, and keeps, is where it should be at the end of its step, whatever its velocity was.
TEST_P(OrderInDtOfAnImpact, IsThatOfTheStartAtTheStepTimes) {
  const auto [mass, start] = GetParam();
  Case run = thrown(mass);
  run.start = start;
  const double order = start == Start::first_order ? 1.0 : 2.0;
  const OrderStudy study = self_study(record, refinements(run, Refine::step, 5));
  EXPECT_TRUE(has_order(study.displacement_l2, order, within)) << order_text(study);
  EXPECT_TRUE(has_order(study.end_trace, order, within)) << order_text(study);
}

// Not on the mass `paper`: its heavy end node is stopped at t = 0.99 and leaves at once, up to a step late.
INSTANTIATE_TEST_SUITE_P(Starts, OrderInDtOfAnImpact,
                         ::testing::Combine(::testing::Values(Mass::consistent, Mass::lumped, Mass::redistributed),
                                            ::testing::Values(Start::first_order, Start::second_order)),
                         label);

// Between u^n and -gap the output is linear, the motion goes on to the obstacle and rests: V dt theta (1 - theta).
TEST(OrderInDtOfAnImpact, BetweenStepsTheCornerIsCutByAtMostAQuarterOfAStep) {
  Case run = thrown(Mass::consistent);
  run.start = Start::second_order;
  run.output_every = 1.0 / 9973;
  const Recording coarser = record(run);
  run.step = 1.0 / 128000;
  const Recording finer = record(run);
  double speed = 0.0;
  for (const Event& event : finer.events) speed = std::max(speed, std::abs(event.velocity));
  const double scheme = 2e-5;  // O(dt^2) at the steps, from docs/orders.md
  EXPECT_LT(compare(coarser, finer).end_trace, 0.25 * speed / 1000 + scheme);
}

TEST(OrderStudy, RefusesToRefineAStepThatIsNotThere) {
  EXPECT_THROW(refinements(Case{}, Refine::step, 2), std::invalid_argument);
}

TEST(OrderStudy, RefinesBothInProportionAndKeepsTheOutputTimes) {
  Case run;
  run.elements = 3;
  run.step = 0.5;
  const auto cases = refinements(run, Refine::both, 3);
  EXPECT_EQ(cases[2].elements, 12u);
  EXPECT_EQ(*cases[2].step, 0.125);
  EXPECT_EQ(cases[2].output_times(), run.output_times());
}

}  // namespace
}  // namespace viscobar
