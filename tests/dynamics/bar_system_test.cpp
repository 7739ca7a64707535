#include "viscobar/dynamics/bar_system.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/random_vector.hpp"
#include "viscobar/dynamics/load_error.hpp"
#include "viscobar/dynamics/load_vector.hpp"
namespace viscobar::testing_bar_system {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr Mass all_masses[] = {Mass::consistent, Mass::lumped, Mass::paper, Mass::redistributed, Mass::fourth_order};

Scene scene_with(EndCondition left, EndCondition right, double viscosity = 0.5) {
  Scene scene;
  scene.bar = {2.0, 3.0, 5.0, viscosity};
  scene.left = left;
  scene.right = right;
  scene.displacement = [](double x) { return 1.0 + 0.5 * x; };
  scene.velocity = [](double x) { return 0.25 - x; };
  return scene;
}

const EndCondition all_ends[] = {Free{}, Fixed{}, Obstacle{10.0}};

TEST(BarSystem, ARigidMotionHasNoInternalForceAtAll) {
  const BarSystem system(scene_with(Free{}, Free{}), {2.0, 17}, Mass::consistent);
  const std::vector<double> u(system.size(), 0.1), w(system.size(), -0.3);
  std::vector<double> force(system.size(), 1.0);
  system.internal_force(u, w, force);
  for (const double f : force) EXPECT_EQ(f, 0.0);
}

TEST(BarSystem, InternalForceIsTheGradientOfTheEnergyPlusTheDampingOfTheRate) {
  for (const auto& left : all_ends)
    for (const auto& right : all_ends)
      for (const std::size_t elements : {2u, 3u, 8u}) {
        const BarSystem system(scene_with(left, right), {2.0, elements}, Mass::consistent);
        const std::size_t n = system.size();
        const auto u = random_vector(n, 1), w = random_vector(n, 2), direction = random_vector(n, 3);
        std::vector<double> force(n), plus(u), minus(u), w_plus(w), w_minus(w);
        system.internal_force(u, w, force);
        double power = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
          power += force[i] * direction[i];
          plus[i] += direction[i], minus[i] -= direction[i];
          w_plus[i] += direction[i], w_minus[i] -= direction[i];
        }
        // Central differences of quadratic forms are exact: d/dw of eta/2 int w_x^2 in that direction.
        const double elastic = system.bar().modulus / 4 *
                               (system.elements().squared_strain(plus) - system.elements().squared_strain(minus));
        const double viscous =
            system.bar().viscosity / 4 *
            (system.elements().squared_strain_rate(w_plus) - system.elements().squared_strain_rate(w_minus));
        EXPECT_NEAR(power, -elastic - viscous, 1e3 * static_cast<double>(n) * eps)
            << left.index() << right.index() << elements;
      }
}

TEST(BarSystem, DynamicStiffnessIsTheDerivativeOfTheForces) {
  for (const auto& left : all_ends)
    for (const auto& right : all_ends)
      for (const Mass mass : all_masses) {
        const BarSystem system(scene_with(left, right), {2.0, 6}, mass);
        const std::size_t n = system.size();
        const double m = 0.7, c = 0.3, k = 1.9;
        BandedMatrix matrix;
        system.dynamic_stiffness(m, c, k, matrix);
        const auto x = random_vector(n, 4);
        std::vector<double> zero(n, 0.0), cx(n), kx(n), product(n), inertia(n), at_x(n), at_zero(n);
        for (std::size_t i = 0; i < n; ++i) cx[i] = c * x[i], kx[i] = k * x[i];
        matrix.multiply(x, product);
        system.inertia().matrix().multiply(x, inertia);
        system.internal_force(kx, cx, at_x);
        system.internal_force(zero, zero, at_zero);
        for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(product[i], m * inertia[i] - (at_x[i] - at_zero[i]), 500 * eps);
      }
}

TEST(BarSystem, FixedNodesAreNoUnknownsAndKeepTheirDisplacement) {
  const BarSystem system(scene_with(Fixed{}, Fixed{}), {2.0, 4}, Mass::lumped);
  ASSERT_EQ(system.size(), 3u);
  EXPECT_EQ(system.unknowns().first_node(), 1u);
  std::vector<double> u(5), v(5);
  system.unknowns().expand_displacement(system.initial_state().u, u);
  system.unknowns().expand_velocity(system.initial_state().v, v);
  EXPECT_EQ(u, (std::vector<double>{1.0, 1.25, 1.5, 1.75, 2.0}));
  EXPECT_EQ(v, (std::vector<double>{0.0, -0.25, -0.75, -1.25, 0.0}));
}

TEST(BarSystem, ListsContactsLeftRightSpanWithTrapezoidalWeights) {
  Scene scene = scene_with(Obstacle{1.0}, Free{});
  scene.span = Obstacle{2.0};
  const BarSystem system(scene, {2.0, 4}, Mass::consistent);
  ASSERT_EQ(system.contacts().size(), 6u);
  EXPECT_EQ(system.contacts()[0].where, Where::left);
  double weight = 0.0;
  for (std::size_t k = 1; k < 6; ++k) {
    EXPECT_EQ(system.contacts()[k].where, Where::span);
    weight += system.contacts()[k].weight;
  }
  EXPECT_EQ(weight, 2.0);
  EXPECT_TRUE(BarSystem(scene_with(Free{}, Free{}), {2.0, 4}, Mass::consistent).contacts().empty());
}

TEST(BarSystem, AccelerationSolvesTheMassiveRows) {
  for (const Mass mass : all_masses) {
    const BarSystem system(scene_with(Obstacle{1.0}, Obstacle{1.0}), {2.0, 9}, mass);
    const auto force = random_vector(system.size(), 5);
    auto a = force;
    system.inertia().accelerate(a);
    std::vector<double> back(system.size());
    system.inertia().matrix().multiply(a, back);
    for (std::size_t i = system.inertia().massive_begin(); i < system.inertia().massive_end(); ++i)
      EXPECT_NEAR(back[i], force[i], 100 * eps) << name(mass);
    EXPECT_EQ(system.inertia().has_massless(), mass == Mass::redistributed);
    if (system.inertia().has_massless()) {
      EXPECT_EQ(a.front(), 0.0);
    }
  }
}

TEST(BarSystem, EffectiveMassOfAnEndIsHalfAnElementLumpedAndRootThreeSixthsOfOneConsistent) {
  const Mesh mesh{2.0, 40};
  const double h = mesh.spacing(), rho = 3.0;
  const Scene scene = scene_with(Obstacle{1.0}, Free{});
  EXPECT_NEAR(BarSystem(scene, mesh, Mass::lumped).inertia().effective_masses().front(), rho * h / 2, 4 * eps);
  // Pivots of (h/6) [2 1; 1 4 1; ...] converge to (h/6)(2 + sqrt 3), so the end's is (h/6)(2 - 1/(2 + sqrt 3)).
  EXPECT_NEAR(BarSystem(scene, mesh, Mass::consistent).inertia().effective_masses().front(),
              rho * h / 6 * std::sqrt(3.0), 10 * eps);
  EXPECT_EQ(BarSystem(scene, mesh, Mass::redistributed).inertia().effective_masses().front(), 0.0);
}

TEST(BarSystem, RefusesMeshesThatCannotCarryTheScene) {
  EXPECT_THROW(BarSystem(scene_with(Fixed{}, Fixed{}), {2.0, 1}, Mass::lumped), std::invalid_argument);
  EXPECT_THROW(BarSystem(scene_with(Obstacle{1.0}, Obstacle{1.0}), {2.0, 2}, Mass::redistributed),
               std::invalid_argument);
  Scene span = scene_with(Free{}, Free{});
  span.span = Obstacle{1.0};
  EXPECT_THROW(BarSystem(span, {2.0, 8}, Mass::redistributed), std::invalid_argument);
}

TEST(LoadVector, IsTheSameForASteadyASeparableAndAGeneralFormOfOneLoad) {
  Scene steady = scene_with(Fixed{}, Obstacle{1.0}), separable = steady, general = steady;
  const auto profile = [](double x) { return std::cos(2 * x); };
  steady.load = SteadyLoad{profile};
  separable.load = SeparableLoad{profile, [](double) { return 1.0; }};
  general.load = GeneralLoad{[profile](double x, double) { return profile(x); }};
  for (const Mass mass : all_masses) {
    const Mesh mesh{2.0, 9};
    const BarSystem a(steady, mesh, mass), b(separable, mesh, mass), c(general, mesh, mass);
    LoadVector load_a(a), load_b(b), load_c(c);
    const auto va = load_a.at(0.3), vb = load_b.at(0.3), vc = load_c.at(0.3);
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(va[i], vb[i]);
      EXPECT_EQ(va[i], vc[i]);
    }
    EXPECT_TRUE(load_a.steady());
    EXPECT_FALSE(load_b.steady());
  }
}

TEST(LoadVector, HasTheEntryOfOneNodeWithoutTheOthers) {
  const auto profile = [](double x) { return std::sin(x) + 2.0; };
  const auto history = [](double t) { return std::exp(-t); };
  for (const Mass mass : all_masses)
    for (const EndCondition& left : all_ends)
      for (int form = 0; form < 3; ++form) {
        Scene scene = scene_with(left, Obstacle{10.0});
        if (form == 0) scene.load = SteadyLoad{profile};
        if (form == 1) scene.load = SeparableLoad{profile, history};
        if (form == 2) scene.load = GeneralLoad{[=](double x, double t) { return profile(x) * history(t); }};
        const BarSystem system(scene, {2.0, 9}, mass);
        LoadVector load(system);
        const std::span<const double> all = load.at(0.7);
        const std::size_t evaluations = load.evaluations();
        for (std::size_t i = 0; i < system.size(); ++i) EXPECT_NEAR(load.at(0.7, i), all[i], 8 * eps) << form;
        EXPECT_EQ(load.evaluations(), evaluations);
      }
}

TEST(LoadVector, EvaluatesAProfileOncePerNodeAndAHistoryOncePerTime) {
  int profiles = 0, histories = 0;
  Scene scene = scene_with(Free{}, Free{});
  scene.load = SeparableLoad{[&](double) { return ++profiles, 1.0; }, [&](double) { return ++histories, 1.0; }};
  const BarSystem system(scene, {2.0, 9}, Mass::consistent);
  LoadVector load(system);
  for (const double t : {0.0, 0.1, 0.1, 0.2}) load.at(t);
  EXPECT_EQ(profiles, 10);
  EXPECT_EQ(histories, 3);
}

TEST(LoadVector, RefusesValuesThatAreNotFiniteAndSaysWhen) {
  Scene scene = scene_with(Free{}, Free{});
  scene.load = GeneralLoad{[](double x, double t) { return x / (1.0 - t); }};
  const BarSystem system(scene, {2.0, 9}, Mass::consistent);
  LoadVector load(system);
  EXPECT_NO_THROW(load.at(0.5));
  try {
    load.at(1.0);
    FAIL() << "no exception";
  } catch (const LoadError& error) {
    EXPECT_EQ(error.time, 1.0);
  }
}

}  // namespace
}  // namespace viscobar::testing_bar_system
