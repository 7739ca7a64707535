#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <utility>

#include "discretisation/gauss.hpp"
#include "ends/closed_forms.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

// Springs and drag along the bar, rho u_tt = (E u_x + eta u_xt)_x + f - k u - c u_t, against closed forms.
namespace viscobar {
namespace {

using closed_forms::error;
using closed_forms::numerics;

Recording run_of(const std::string& text) { return record(parse_scene(text, "").run); }

// The error on 2 n elements and the order from n.
void expect_order(double order, const std::function<std::string(int)>& scene, const closed_forms::Exact& u, int n) {
  const double coarse = error(run_of(scene(n)), u), fine = error(run_of(scene(2 * n)), u);
  EXPECT_NEAR(std::log2(coarse / fine), order, 0.1) << coarse << " " << fine;
}

// Modes of the bar stay modes: with (c/rho + eta w_0^2/E)/2 as decay and w^2 = w_0^2 + k/rho - decay^2.
TEST(Side, ModeOfAFixedBarDecaysAtAQuarterAndHasTheFrequency2_3248InEveryMethodAtTheOrderOfItsMass) {
  const double decay = 0.25, w = 2.3248443174;
  const auto exact = [=](double x, double t) {
    return std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t)) *
           std::sin(std::numbers::pi * x / 2.0);
  };
  for (const auto& [method, mass, order] : closed_forms::all_orders) {
    SCOPED_TRACE(method);
    const auto scene = [&, method = method, mass = mass](int elements) {
      return "[bar]\nlength = 1\n[left]\nkind = \"fixed\"\n[side]\nstiffness = 3\ndrag = 0.5\n"
             "[initial]\ndisplacement = \"sin(pi*x/2)\"\n" +
             numerics(elements, mass, method, 4.0);
    };
    expect_order(order, scene, exact, order > 3 ? 8 : 16);
  }
}

// A free elastic bar with springs k = 20 beyond x = a: cos(w x) before, a cosh(q (1 - x)) behind, q^2 = k - w^2, and w
// tan(w a) = q tanh(q (1 - a)). The nodes do not know where the springs begin; means over phi_i do, with an error of
// order two.
TEST(Side, SpringsThatBeginWithinAnElementHaveOrderTwo) {
  const double a = 0.537, k = 20.0;
  double low = 0.0, high = std::numbers::pi / (2.0 * a);
  for (int i = 0; i < 200; ++i) {
    const double w = 0.5 * (low + high), q = std::sqrt(k - w * w);
    (w * std::tan(w * a) < q * std::tanh(q * (1.0 - a)) ? low : high) = w;
  }
  const double w = low, q = std::sqrt(k - w * w), share = std::cos(w * a) / std::cosh(q * (1.0 - a));
  const auto exact = [=](double x, double t) {
    return std::cos(w * t) * (x < a ? std::cos(w * x) : share * std::cosh(q * (1.0 - x)));
  };
  for (const char* mass : {"fourth_order", "consistent", "lumped"})
    for (const int n : {20, 40, 80, 160}) {
      const Recording run = run_of(fmt::format(
          "[bar]\nlength = 1\n[side]\nstiffness = \"x<{0} ? 0 : {1}\"\n[initial]\ndisplacement = \"x<{0} ? cos({2}*x) : "
          "{3}/2*(exp({4}*(1-x))+exp({4}*(x-1)))\"\n{5}",
          a, k, w, share, q, numerics(n, mass, "rigid", 4.0)));
      EXPECT_LT(error(run, exact), 10.0 / (n * n)) << mass << n;
    }
}

// Springs that stand between two nodes are there: 20 per area in all, which would be 0 by values at the nodes.
TEST(Side, SpringsBetweenTwoNodesAreThere) {
  const auto narrow = [](int n) {
    return run_of(
        fmt::format("[bar]\nlength = 1\nviscosity = 0.05\n[side]\nstiffness = \"x>0.51 && x<0.53 ? 1000 : "
                    "0\"\n[initial]\nvelocity = 1\n[time]\nend = 3\n[mesh]\nelements = {}\n",
                    n));
  };
  const Recording fine = narrow(640);
  for (const int n : {20, 40}) {
    const Recording run = narrow(n);
    EXPECT_NEAR(run.displacement(run.times.size() - 1)[0], fine.displacement(fine.times.size() - 1)[0], 20.0 / (n * n));
  }
}

// The order of the mass says 2e-9 for 64 elements: |lambda - lambda_h| is 4e-9 on 40, in rows made apart.
TEST(Side, ModeOfAnElasticOrViscousBarIsRightToEightDigitsOn64Elements) {
  struct Mode {
    double viscosity, decay, w;
  };
  for (const auto& [viscosity, decay, w] :
       {Mode{0.0, 0.25, 2.324844317427}, Mode{0.1, 0.373370055014, 2.308245199777}}) {
    const auto exact = [decay = decay, w = w](double x, double t) {
      return std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t)) *
             std::sin(std::numbers::pi * x / 2.0);
    };
    for (const char* method : {"rigid", "cvode", "ida", "arkode"})
      EXPECT_LT(error(run_of(fmt::format("[bar]\nlength = 1\nviscosity = {}\n[left]\nkind = \"fixed\"\n[side]\n"
                                         "stiffness = 3\ndrag = 0.5\n[initial]\ndisplacement = \"sin(pi*x/2)\"\n",
                                         viscosity) +
                             numerics(64, "fourth_order", method, 4.0)),
                      exact),
                1e-8)
          << method << " " << viscosity;
  }
}

TEST(Side, CoefficientsThatVaryAlongTheBarKeepTheOrderOfTheMass) {
  const auto exact = [](double x, double t) { return std::sin(std::numbers::pi * x / 2.0) * std::cos(2.0 * t); };
  for (const auto& [method, mass, order] : closed_forms::all_orders) {
    SCOPED_TRACE(method);
    const auto scene = [&, method = method, mass = mass](int elements) {
      return "[bar]\nlength = 1\n[left]\nkind = \"fixed\"\n[side]\nstiffness = \"4+3*sin(4*x)\"\ndrag = \"0.5+0.6*x^2\"\n"
             "[initial]\ndisplacement = \"sin(pi*x/2)\"\n[load]\ndensity = \"sin(pi*x/2)*((pi^2/4+3*sin(4*x))*cos(2*t)-"
             "2*sin(2*t)*(0.5+0.6*x^2))\"\n" +
             numerics(elements, mass, method, 2.0);
    };
    expect_order(order, scene, exact, order > 3 ? 24 : 16);
  }
}

// The telegrapher's equation: a force F(t) on the end of a bar without viscosity moves it, until an echo comes, by
//     u(0,t) = int F(s) g(t - s) ds,   g = exp(-c t / 2) J_0(t (k - c^2 / 4)^(1/2)),
// I_0 of t (c^2 / 4 - k)^(1/2) where that is real.
TEST(Side, EndOfAnElasticBarAnswersAForceByBesselFunctions) {
  const double end = 1.6;
  for (const auto& [k, c] : {std::pair{0.0, 2.0}, {9.0, 0.0}, {9.0, 2.0}, {0.5, 3.0}}) {
    SCOPED_TRACE(fmt::format("k = {}, c = {}", k, c));
    const auto answer = [k = k, c = c](double t) {
      const double square = k - c * c / 4.0, w = std::sqrt(std::abs(square));
      return std::exp(-c * t / 2.0) * (square > 0.0 ? std::cyl_bessel_j(0.0, w * t) : std::cyl_bessel_i(0.0, w * t));
    };
    const auto exact = [&](double t) {
      double sum = 0.0;
      constexpr int pieces = 32;
      for (int p = 0; p < pieces; ++p)
        for (const auto [node, weight] : gauss(8)) {
          const double s = t * (p + 0.5 + 0.5 * node) / pieces;
          sum += 0.5 * weight * t / pieces * std::pow(s, 4) * answer(t - s);
        }
      return sum;
    };
    for (const char* method : {"rigid", "ida"}) {
      double errors[2];
      for (const int fine : {0, 1}) {
        const Recording run = run_of(
            fmt::format(
                "[bar]\nlength = 1\n[left]\nkind = \"free\"\nforce = \"t^4\"\n[side]\nstiffness = {}\ndrag = {}\n", k,
                c) +
            numerics(fine ? 40 : 20, "fourth_order", method, end));
        errors[fine] = 0.0;
        for (std::size_t j = 0; j < run.times.size(); ++j)
          errors[fine] = std::max(errors[fine], std::abs(run.displacement(j)[0] - exact(run.times[j])));
      }
      EXPECT_GT(std::log2(errors[0] / errors[1]), 3.7) << method << " " << errors[0] << " " << errors[1];
    }
  }
}

// A bar thrown at a rigid wall, in touch at t = 0. In Laplace space R = tanh(q) / q, q = ((s^2 + c s + k) / (1 + eta
// s))^(1/2); the ends of contact are inversions of that, by a program that shares nothing with this one.
TEST(Side, BarThrownAtARigidWallPartsWhenLaplacesTransformSays) {
  struct Truth {
    double c, k, parts, impulse;
  };
  for (const auto& [c, k, parts, impulse] :
       {Truth{0.5, 3.0, 1.280536046771, 0.754611530475}, Truth{0.5, 0.0, 1.959606137963, 1.386501022234},
        Truth{0.0, 3.0, 1.268067403678, 0.8410726345394}}) {
    const Recording run = run_of(
        fmt::format("[bar]\nlength = 1\nviscosity = 0.1\n[left]\nkind = \"obstacle\"\ngap = 0\n[side]\nstiffness = {}\n"
                    "drag = {}\n[initial]\nvelocity = -1\n",
                    k, c) +
        numerics(100, "fourth_order", "rigid", 2.2));
    ASSERT_EQ(run.events.size(), 2u) << c << " " << k;
    EXPECT_NEAR(run.events[1].time, parts, 1e-8) << c << " " << k;
    EXPECT_NEAR(run.statistics.account->left.impulse, impulse, 1e-8) << c << " " << k;
  }
}

}  // namespace
}  // namespace viscobar
