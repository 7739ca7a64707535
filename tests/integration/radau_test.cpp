// Radau's formula of `rigid`: what docs/internals/integrators.md derives of it.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <complex>
#include <random>

#include "integration/radau/formula.hpp"
#include "integration/radau/shifted_systems.hpp"
#include "integration/radau/step_powers.hpp"
#include "support/maximum_norm.hpp"
#include "support/run_trace.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/integration/integrate.hpp"
#include "viscobar/studies/exact/exact_solutions.hpp"

namespace viscobar::testing_radau {
namespace {

using namespace radau;
using Number = std::complex<double>;

Number lane(const Complex& x, std::size_t k) {
  return {x.re[static_cast<Eigen::Index>(k)], x.im[static_cast<Eigen::Index>(k)]};
}

// Sum of the parts, x(k) being those of pole k.
template <class X>
double sum(const Parts& weights, X&& x) {
  double total = 0.0;
  for (std::size_t k = 0; k < lanes; ++k) total += weights[k] * x(k).real() + weights[lanes + k] * x(k).imag();
  return total;
}

// (zeta - z) X = z y_0 of an oscillation that dies out: of y'' + 2 d y' + y = 0, its two numbers for h = 1 scaled by z.
Eigen::Vector2cd part_of_oscillation(Number zeta, double h, const Eigen::Matrix2d& a, const Eigen::Vector2d& y) {
  const Eigen::Matrix2cd system = zeta * Eigen::Matrix2cd::Identity() - h * a.cast<Number>();
  return system.partialPivLu().solve((h * a * y).cast<Number>().eval());
}

TEST(RadauFormula, IsTheExponentialToTheNinthPowerWithinAStepAndToTheSixteenthAtItsEnd) {
  const Formula& formula = Formula::get();
  Eigen::Matrix2d a;
  a << 0.0, 1.0, -1.0, -0.2;
  const Eigen::Vector2d y0(0.3, -1.0);
  // exp(a t) y0: the zeros are -0.1 +- i omega.
  const double omega = std::sqrt(0.99);
  const auto exact = [&](double t) {
    return std::exp(-0.1 * t) * (0.3 * std::cos(omega * t) + (-1.0 + 0.03) / omega * std::sin(omega * t));
  };
  for (const double h : {0.25, 0.5, 1.0, 2.0})
    for (const double theta : {0.05, 0.3, 0.5, 0.8, 1.0}) {
      const Parts weights = formula.weights(theta, 0);
      const auto x = [&](std::size_t k) { return part_of_oscillation(lane(formula.poles, k), h, a, y0)[0]; };
      const double error = std::abs(y0[0] + sum(weights, x) - exact(theta * h));
      // |c_9| < 6e-11; behind it terms of |z| / 10 times, Q(z) and |y_0| < 1.1 count for less than twice. At the end it
      // is c_16, 1 / (15! 16!) times 7! 8!: 1e-17. The weights are
      // 1e4 together, of numbers of |z| / 10.
      const double bound = theta < 1.0 ? 2 * 6e-11 * std::pow(h, 9) : 1e-16 * std::pow(h, 16);
      EXPECT_LT(error, bound + 1e4 * 0.1 * h * 2.2e-16) << h << " " << theta;
    }
}

TEST(RadauFormula, TheRateOfItsPolynomialIsThatOfItsWeights) {
  const Formula& formula = Formula::get();
  for (const double theta : {0.1, 0.6, 0.95}) {
    const Parts rate = formula.weights(theta, 1), late = formula.weights(theta + 1e-5, 0),
                early = formula.weights(theta - 1e-5, 0);
    for (std::size_t l = 0; l < radau::parts; ++l)
      // Error of a central difference: h^2/6 of the third derivative, which is less than 1e3 of the weights at a pole
      // of |zeta| < 13, and rounding over 2e-5.
      EXPECT_NEAR(rate[l], (late[l] - early[l]) / 2e-5, 3000 * (1000 * 1e-10 / 6 + 2e-15 / 1e-5)) << theta;
  }
}

// y' = theta^j: y = theta^(j+1) / (j+1), exact where the polynomial has that degree, at the end by Radau's quadrature.
TEST(RadauFormula, IntegratesALoadExactlyToItsDegree) {
  const Formula& formula = Formula::get();
  for (int j = 1; j <= 14; ++j)
    for (const double theta : {0.2, 0.7, 1.0}) {
      if (theta < 1.0 && j > 7) continue;
      const Parts weights = formula.weights(theta, 0);
      const double y = sum(weights, [&](std::size_t k) {
        Number x = 0;
        for (std::size_t m = 0; m < stages; ++m) x += lane(formula.of_load[m], k) * std::pow(formula.nodes[m], j);
        return x / lane(formula.poles, k);
      });
      EXPECT_NEAR(y, std::pow(theta, j + 1) / (j + 1), 1e-12) << j << " " << theta;
    }
}

// A load c_k(theta) X_k and its conjugate are X_k in the system of that pole, and nothing in the others. A weight is a
// sum of nine terms, none larger than the largest weight of its pole by much, and rounds with them.
TEST(RadauFormula, ALoadThatIsLinearInTheMotionIsInEachSystemOneOfItsPart) {
  const Formula& formula = Formula::get();
  const Number x(0.6, -0.8);
  const auto size = [](const Parts& weights, std::size_t k) {
    return std::abs(weights[k]) + std::abs(weights[lanes + k]);
  };
  for (std::size_t k = 0; k < lanes; ++k) {
    double largest = 0.0;
    for (const double node : formula.nodes) largest = std::max(largest, size(formula.weights(node, 0), k));
    for (std::size_t l = 0; l < lanes; ++l) {
      Number image = 0.0;
      double sizes = 0.0;
      for (std::size_t m = 0; m < stages; ++m) {
        const Parts weights = formula.weights(formula.nodes[m], 0);
        const double load = weights[k] * x.real() + weights[lanes + k] * x.imag();
        image += lane(formula.of_load[m], l) * load;
        sizes += std::abs(lane(formula.of_load[m], l)) * largest;
      }
      EXPECT_NEAR(std::abs(image - (k == l ? x : 0.0)), 0.0, 9.0 * 0x1p-53 * sizes) << k << " " << l;
      EXPECT_LT(sizes, 1e5);
    }
  }
}

// D X = right-hand side, by a dense solve.
TEST(ShiftedSystems, SolveTheirEquationsForEveryMassSizeAndContact) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const Formula& formula = Formula::get();
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::redistributed, Mass::paper, Mass::fourth_order})
    for (const std::size_t elements : {4, 5, 6, 13})
      for (const bool closed : {false, true}) {
        Scene scene;
        scene.bar.viscosity = 0.3;
        scene.left = scene.right = Obstacle{0.1};
        scene.displacement = scene.velocity = [](double) { return 0.0; };
        const BarSystem bar(scene, {1.0, elements}, mass);
        PenalisedSystem system(bar, {0.0, 0.0});
        system.contacts().set_closed(1, closed);
        const std::size_t n = system.size();
        const auto count = static_cast<Eigen::Index>(n);
        std::vector<double> force(n), rate(n);
        for (double& entry : force) entry = uniform(random);
        for (double& entry : rate) entry = uniform(random);
        std::vector<Complex> x(n);
        ShiftedSystems systems;
        systems.take(system);
        const double h = 0.07;
        systems.factorise(h);
        systems.refine(elements % 2 == 0);
        systems.solve(force, rate, false, x);
        BandedMatrix m, c, k;
        bar.dynamic_stiffness(1.0, 0.0, 0.0, m);
        bar.dynamic_stiffness(0.0, 1.0, 0.0, c);
        bar.dynamic_stiffness(0.0, 0.0, 1.0, k);
        const auto dense = [&](const BandedMatrix& matrix) {
          Eigen::MatrixXd full(count, count);
          std::vector<double> unit(n), column(n);
          for (std::size_t j = 0; j < n; ++j) {
            std::ranges::fill(unit, 0.0);
            unit[j] = 1.0;
            matrix.multiply(unit, column);
            full.col(static_cast<Eigen::Index>(j)) = Eigen::Map<Eigen::VectorXd>(column.data(), count);
          }
          return full;
        };
        for (std::size_t pole = 0; pole < lanes; ++pole) {
          const Number zeta = lane(formula.poles, pole);
          Eigen::MatrixXcd d =
              zeta * dense(m).cast<Number>() + h * dense(c).cast<Number>() + (h * h / zeta) * dense(k).cast<Number>();
          Eigen::VectorXcd right(count);
          for (std::size_t i = 0; i < n; ++i)
            right[static_cast<Eigen::Index>(i)] = h * force[i] - h * h / zeta * rate[i];
          if (closed) {
            d.row(count - 1).setZero();
            d(count - 1, count - 1) = 1.0;
            right[count - 1] = 0.0;
          }
          const Eigen::VectorXcd solution = d.partialPivLu().solve(right);
          for (std::size_t i = 0; i < n; ++i)
            EXPECT_LT(std::abs(lane(x[i], pole) - solution[static_cast<Eigen::Index>(i)]),
                      1e-12 * solution.cwiseAbs().maxCoeff())
                << name(mass) << " " << elements << " " << closed << " " << pole << " " << i;
        }
      }
}

double largest_difference(const RunTrace& a, const RunTrace& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.u.size(); ++k)
    for (std::size_t i = 0; i < a.u[k].size(); ++i) largest = std::max(largest, std::abs(a.u[k][i] - b.u[k][i]));
  return largest;
}

Scene random_scene(std::mt19937& random) {
  const auto uniform = [&](double from, double to) { return std::uniform_real_distribution(from, to)(random); };
  Scene scene;
  scene.bar = {.length = uniform(0.5, 2.0), .density = uniform(0.5, 2.0), .modulus = uniform(0.5, 4.0)};
  scene.bar.viscosity = std::pow(10.0, uniform(-2.5, 0.0));
  scene.left = Obstacle{uniform(0.02, 0.2)};
  if (uniform(0, 1) < 0.5) scene.right = Obstacle{uniform(0.02, 0.2)};
  const double a = uniform(-0.1, 0.1), b = uniform(1, 6), v = uniform(-1, 1), f = uniform(-1, 1), p = uniform(2, 9);
  scene.displacement = [=](double x) { return a * std::sin(b * x) * x; };
  scene.velocity = [=](double x) { return v * (1 - x); };
  if (uniform(0, 1) < 0.6)
    scene.load = SeparableLoad{[=](double x) { return f * x; }, [=](double t) { return std::sin(p * t); }, {}};
  return scene;
}

// s^n on a step of length 3, up to places within it: exact to n = 16; over all of it to n = 15, and beyond that nearly.
TEST(StepPowers, IntegratePowersOfTimeExactlyToTheirDegree) {
  for (int n = 0; n <= 16; ++n) {
    radau::StepPowers powers;
    const auto at = [&](double s) { return radau::StepPowers::Flow{std::pow(s, n), -2.0 * std::pow(s, n), 0.0}; };
    const auto integral = [&](double s) { return 1.5 * (std::pow(s, n + 1) - std::pow(-1.0, n + 1)) / (n + 1); };
    std::array<radau::StepPowers::Flow, radau::StepPowers::of_gauss> at_gauss;
    for (std::size_t k = 0; k < at_gauss.size(); ++k) at_gauss[k] = at(radau::StepPowers::nodes()[k]);
    const radau::StepPowers::Flow all = powers.over_step(3.0, at_gauss);
    EXPECT_NEAR(all[0], integral(1.0), n <= 15 ? 1e-14 : 1e-4) << n;
    for (const double s : {-1.0, -0.99, -0.3, 0.0, 0.5, 0.999}) {
      EXPECT_NEAR(powers.up_to(s, at)[0], integral(s), 2e-14) << n << " " << s;
      EXPECT_NEAR(powers.up_to(s, at)[1], -2.0 * integral(s), 4e-14) << n << " " << s;
    }
  }
}

// The same bar in a frame that is told to move and stands still: the powers come point by point, not in lanes.
TEST(RigidByRadau, HasOneAccountInAFrameThatStandsStillAndInNone) {
  std::mt19937 random(7);
  for (int round = 0; round < 6; ++round) {
    Scene scene = random_scene(random);
    scene.right = Fixed{};
    scene.left_input.dashpot = 0.3;
    const Mesh mesh{scene.bar.length, 17, {round % 2 == 1 ? 4.0 : 1.0, true, false}};
    const Mass mass = round % 2 == 1 ? Mass::consistent : Mass::fourth_order;
    const BarSystem still(scene, mesh, mass);
    const auto none = [](double) { return 0.0; };
    scene.right_input.motion = EndMotion{none, none, none};
    const BarSystem told(scene, mesh, mass);
    const auto times = uniform_times(0.037, 60);
    const EnergyAccount a = *record(still, times, Rigid{{1e-8}}).statistics.energy;
    const EnergyAccount b = *record(told, times, Rigid{{1e-8}}).statistics.energy;
    // The steps are the same; a sum of 17 nodes, 8 points and some hundred steps rounds so far.
    const double rounding = 1e3 * std::numeric_limits<double>::epsilon() * (a.initial + std::abs(a.work));
    EXPECT_NEAR(a.dissipated, b.dissipated, rounding) << round;
    EXPECT_NEAR(a.work, b.work, rounding) << round;
    EXPECT_GT(a.dissipated, 1e-3 * a.initial) << round;
  }
}

// On random scenes of every mass, against ARKODE's formulas at a hundred-thousandth of the tolerance: a tenth of what
// docs/methods.md promises.
TEST(RigidByRadau, IsWithinItsToleranceOfAnotherIntegrator) {
  std::mt19937 random(20);
  for (int round = 0; round < 12; ++round) {
    const Scene scene = random_scene(random);
    const Mass mass = std::array{Mass::consistent, Mass::redistributed, Mass::fourth_order}[round % 3];
    const BarSystem system(scene, {scene.bar.length, 17}, mass);
    const auto times = uniform_times(0.037, 60);
    const RunTrace other = record(system, times, Arkode{{0.0, 0.0}, {1e-11}});
    double largest = 0.0;
    for (const auto& u : other.u)
      for (const double value : u) largest = std::max(largest, std::abs(value));
    for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
      const RunTrace own = record(system, times, Rigid{{tolerance}});
      EXPECT_EQ(own.events.size(), other.events.size()) << round;
      EXPECT_LT(largest_difference(own, other), 10 * tolerance * largest)
          << round << " " << name(mass) << " " << tolerance;
      EXPECT_LT(std::abs(own.statistics.energy->balance_error()),
                10 * tolerance * (own.statistics.energy->initial + std::abs(own.statistics.energy->work)))
          << round << " " << name(mass) << " " << tolerance;
    }
  }
}

// The pivots of a fine viscous mesh round off its inertia: without refinement 3e-11 here.
TEST(RigidByRadau, KeepsItsDigitsOnAFineViscousMesh) {
  Scene scene;
  scene.bar.viscosity = 1.0;
  scene.left = Obstacle{0.1};
  scene.displacement = [](double x) { return 0.4 * x * (1.0 - x); };
  scene.velocity = [](double x) { return -0.5 - x; };
  scene.load = SteadyLoad{[](double x) { return -1.0 - x * x; }};
  const BarSystem system(scene, {1.0, 600}, Mass::fourth_order);
  const auto times = uniform_times(0.1, 15);
  const RunTrace best = record(system, times, Rigid{{1e-13, 1e-16}}),
                 good = record(system, times, Rigid{{1e-11, 1e-14}});
  EXPECT_LT(largest_difference(best, good), 1e-12);
  EXPECT_LT(largest_difference(best, record(system, times, Arkode{{0.0, 0.0}, {1e-12, 1e-15}})), 1e-12);
}

// h^8 in the error estimate for ARKODE's h^5: at 1e-9 it takes a fifth of the steps.
TEST(RigidByRadau, TakesAFifthOfTheStepsOfOrderFive) {
  Scene scene;
  scene.bar.viscosity = 0.1;
  scene.left = scene.right = Obstacle{0.1};
  scene.displacement = [](double x) { return x * (1.0 - x); };
  scene.velocity = [](double x) { return -x * (1.0 - x); };
  const BarSystem system(scene, {1.0, 80}, Mass::fourth_order);
  const auto times = uniform_times(0.1, 24);
  EXPECT_LT(5 * record(system, times, Rigid{{1e-9}}).statistics.steps,
            record(system, times, Arkode{{0.0, 0.0}, {1e-9}}).statistics.steps);
}

// The load of the manufactured contact has kinks where the contact changes, and functions of C++ cannot name them.
TEST(RigidByRadau, KeepsItsPromiseUnderALoadWithKinksThatNobodyNames) {
  Case run;
  run.scene = exact::ManufacturedContact{}.scene();
  run.elements = 16;
  run.mass = Mass::redistributed;
  run.method = MethodName::rigid;
  run.end = 1.9;
  run.output_every = 0.02;
  const auto displacements = [&](double tolerance) {
    run.tolerance.relative = tolerance;
    return record(run).u;
  };
  const std::vector<double> truth = displacements(1e-13);
  const double largest = viscobar::largest(truth);
  for (const double tolerance : {1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11}) {
    const std::vector<double> u = displacements(tolerance);
    const double error = distance(u, truth);
    EXPECT_LT(error, 100.0 * tolerance * largest) << tolerance;
  }
}

}  // namespace
}  // namespace viscobar::testing_radau
