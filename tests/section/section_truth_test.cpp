// Bars of varying section and given meshes, against closed forms; docs/sections.md derives what is claimed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <regex>
#include <string>
#include <vector>

#include "discretisation/varying_section.hpp"
#include "dynamics/gauge.hpp"
#include "support/decompositions.hpp"
#include "support/dense_matrix.hpp"
#include "support/maximum_norm.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/discretisation/mass.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

using Eigen::Index;

// Sizes that repeat, over [0, 1].
Mesh repeated(std::size_t elements, std::vector<double> sizes) {
  std::vector<double> nodes{0.0};
  for (std::size_t j = 0; j < elements; ++j) nodes.push_back(nodes.back() + sizes[j % sizes.size()]);
  for (double& node : nodes) node /= nodes.back();
  Mesh mesh{1.0, elements};
  mesh.given = std::make_shared<const std::vector<double>>(std::move(nodes));
  return mesh;
}

TEST(SectionRows, OfSectionOneOnAUniformMeshAreThoseOfTheBar) {
  const Mesh mesh{1.5, 7};
  const VaryingSection one([](double) { return 1.0; }, {}, mesh);
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::redistributed, Mass::fourth_order})
    EXPECT_LT((dense(inertia_matrix(mesh, mass, true, true, &one)) - dense(inertia_matrix(mesh, mass, true, true)))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-15)
        << name(mass);
}

// A row is int A phi_i a dx, exact for parabolas in s: moments by an adaptive formula of other points.
TEST(SectionRows, AreExactForParabolasInS) {
  const auto area = [](double x) { return std::exp(x) * (2.0 - x); };
  Mesh mesh = repeated(7, {1.0, 2.0, 3.0});
  mesh.length = 1.3;
  const VaryingSection section(area, {}, mesh);
  // s by Simpson's rule on so many parts that its error is rounding.
  const auto simpson = [](double from, double to, auto&& f) {
    constexpr int parts = 400;
    const double h = (to - from) / parts;
    double sum = 0.0;
    for (int k = 0; k < parts; ++k)
      sum += h / 6 * (f(from + h * k) + 4 * f(from + h * (k + 0.5)) + f(from + h * (k + 1)));
    return sum;
  };
  const auto s = [&](double x) { return simpson(0.0, x, [&](double at) { return 1.0 / area(at); }); };
  const MatrixXd rows = dense(mass_matrix(mesh, Mass::fourth_order, &section));
  for (const int power : {0, 1, 2})
    for (std::size_t i = 0; i < mesh.nodes(); ++i) {
      long double row = 0.0L;
      double moment = 0.0;
      for (std::size_t j = 0; j < mesh.nodes(); ++j)
        row += rows(static_cast<Index>(i), static_cast<Index>(j)) * std::pow(s(mesh.node(j)), power);
      for (const bool right : {false, true}) {
        if (right ? i == mesh.elements : i == 0) continue;
        const double a = mesh.node(right ? i : i - 1), b = mesh.node(right ? i + 1 : i), s_a = s(a), s_b = s(b);
        moment += simpson(a, b, [&](double x) {
          const double at = s(x), share = (at - s_a) / (s_b - s_a);
          return area(x) * (right ? 1.0 - share : share) * std::pow(at, power);
        });
      }
      EXPECT_NEAR(static_cast<double>(row), moment, 1e-11) << power << " " << i;
    }
}

TEST(SectionRows, PullAsTheStressOfAnyFieldDoes) {
  Scene scene;
  scene.bar = {1.0, 1.3, 0.7, 0.0};
  scene.left = Free{}, scene.right = Free{};
  scene.displacement = scene.velocity = [](double) { return 0.0; };
  scene.section = [](double x) { return (1.0 + x) * (1.0 + x); };
  const BarSystem system(scene, repeated(6, {1.0, 3.0, 2.0}), Mass::consistent);
  // E A u_x of u is q(x) = x (1 - x), which is 0 at free ends: rows are the differences of the mean of q weighted by
  // 1 / A, that is int q / A dx / s_e, for any u.
  const auto u = [](double x) {  // int q / (E A) dx in closed form
    const double y = 1.0 + x;
    return (-y + 3.0 * std::log(y) + 2.0 / y) / 0.7;
  };
  std::vector<double> nodal, still(7, 0.0), force(7);
  for (std::size_t j = 0; j <= 6; ++j) nodal.push_back(u(system.mesh().node(j)));
  system.internal_force(nodal, still, force);
  double before = 0.0;
  for (std::size_t j = 0; j <= 6; ++j) {
    double next = 0.0;
    if (j < 6) {
      const double a = system.mesh().node(j), b = system.mesh().node(j + 1);
      next = 0.7 * (u(b) - u(a)) / (1.0 / (1.0 + a) - 1.0 / (1.0 + b));
    }
    EXPECT_NEAR(force[j], next - before, 1e-14) << j;
    before = next;
  }
}

// omega of modes of rho M u'' + E K u = 0, in rising order; the largest imaginary part of their squares beside them.
std::pair<std::vector<double>, double> frequencies(const Scene& scene, const Mesh& mesh, Mass mass) {
  const BarSystem system(scene, mesh, mass);
  BandedMatrix stiffness;
  system.dynamic_stiffness(0.0, 0.0, 1.0, stiffness);
  const auto values =
      testing_support::eigenvalues(testing_support::quotient(dense(system.inertia().matrix()), dense(stiffness)));
  std::vector<double> found;
  double imaginary = 0.0;
  for (Index k = 0; k < values.size(); ++k) {
    EXPECT_GT(values[k].real(), -1e-9 * values.cwiseAbs().maxCoeff());
    found.push_back(std::sqrt(std::max(0.0, static_cast<double>(values[k].real()))));
    imaginary = std::max(imaginary, std::abs(static_cast<double>(values[k].imag())));
  }
  std::ranges::sort(found);
  return {found, imaginary};
}

Scene fixed_free(SpaceFunction section) {
  Scene scene;
  scene.left = Fixed{}, scene.right = Free{};
  scene.displacement = scene.velocity = [](double) { return 0.0; };
  scene.section = std::move(section);
  return scene;
}

std::vector<double> orders(const std::vector<double>& errors) {
  std::vector<double> found;
  for (std::size_t k = 1; k < errors.size(); ++k) found.push_back(std::log2(errors[k - 1] / errors[k]));
  return found;
}

// A = exp(2x): u = exp(-x) sin kx with tan k = k, omega^2 = k^2 + 1, and u = x exp(-x), omega = 1. A = (1+x)^2:
// u = sin(omega x) / (1+x), tan omega = 2 omega.
TEST(SectionFrequencies, OfHornAndConeHaveOrderFour) {
  struct Bar {
    SpaceFunction section;
    double first, second;
  };
  for (const auto& [section, first, second] :
       {Bar{[](double x) { return std::exp(2.0 * x); }, 1.0, 4.6033388487517},
        Bar{[](double x) { return (1.0 + x) * (1.0 + x); }, 1.16556118520721, 4.60421677720057}})
    for (const double ratio : {1.0, 3.0}) {
      std::vector<double> of_first, of_second, of_consistent;
      for (const std::size_t elements : {20u, 40u, 80u}) {
        const Mesh mesh{1.0, elements, {ratio, true, false}};
        const auto [modes, imaginary] = frequencies(fixed_free(section), mesh, Mass::fourth_order);
        EXPECT_LT(imaginary, 1e-9 * modes.back() * modes.back());
        of_first.push_back(std::abs(modes[0] - first)), of_second.push_back(std::abs(modes[1] - second));
        of_consistent.push_back(std::abs(frequencies(fixed_free(section), mesh, Mass::consistent).first[0] - first));
      }
      for (const double order : orders(of_first)) EXPECT_NEAR(order, 4.0, 0.15) << ratio;
      for (const double order : orders(of_consistent)) EXPECT_NEAR(order, 2.0, 0.1) << ratio;
      // Errors of the second change sign on the way; (omega h)^4 of the largest element is their size.
      EXPECT_LT(of_second.back(), second * std::pow(second * 2.0 * ratio / (1.0 + ratio) / 80.0, 4) / 50.0) << ratio;
    }
}

// Three nodes a row: order 4 where sizes change smoothly, 3 where they repeat 1, 2, 3, whose sum of h1 h2 (h1^2 - h2^2)
// over a period is not 0.
TEST(SectionFrequencies, OnAGivenMeshHaveOrderThree) {
  std::vector<double> errors;
  for (const std::size_t elements : {24u, 48u, 96u, 192u})
    errors.push_back(
        std::abs(frequencies(fixed_free({}), repeated(elements, {1.0, 2.0, 3.0}), Mass::fourth_order).first[0] -
                 std::numbers::pi / 2));
  for (const double order : orders(errors)) EXPECT_NEAR(order, 3.0, 0.35);
  EXPECT_LT(errors[1], 6e-8);  // accuracy is not only a matter of order
}

// A = 1 and then r: cos(omega b) cos(omega (1 - b)) = r sin(omega b) sin(omega (1 - b)).
TEST(SectionFrequencies, OfAStepInsideAnElementConvergeFasterThanOrderTwo) {
  static constexpr double at = 0.5371, ratio = 4.0, exact = 0.9290754617;
  Scene scene = fixed_free([](double x) { return x < at ? 1.0 : ratio; });
  scene.section_places.breaks = [](double after, double until) -> std::optional<double> {
    return after < at && at < until ? std::optional(at) : std::nullopt;
  };
  for (const std::size_t elements : {48u, 96u, 192u}) {
    const double error = std::abs(frequencies(scene, {1.0, elements}, Mass::fourth_order).first[0] - exact);
    EXPECT_LT(error, 0.02 * std::pow(static_cast<double>(elements), -3.0)) << elements;
  }
}

// Real and not negative: else a mode of an elastic bar grows.
TEST(SectionFrequencies, AreRealForElementsThatFitTheMass) {
  std::mt19937 random(44);
  const auto number = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int scenes = 0; scenes < 300; ++scenes) {
    const std::size_t elements = 3 + random() % 22;
    const double a = number(-1.0, 1.0), b = number(0.0, 0.5), c = number(1.0, 9.0);
    Scene scene = fixed_free([=](double x) { return std::exp(a * x + b * std::sin(c * x)); });
    if (scenes % 3 == 0) scene.left = Free{};
    if (scenes % 2 == 0) scene.right = Fixed{};
    std::vector<double> sizes{1.0};
    while (sizes.size() < elements) sizes.push_back(sizes.back() * std::exp(number(-1.0, 1.0)));  // e < 3
    const auto [modes, imaginary] = frequencies(scene, repeated(elements, sizes), Mass::fourth_order);
    EXPECT_LT(imaginary, 1e-8 * modes.back() * modes.back()) << scenes;
  }
}

// With w = (2 - x) u the bar of section (2 - x)^2, held at x = 0, is one of section 1 with a spring E and a dashpot eta
// at x = 1, whose reaction there is the same; a load f becomes (2 - x) f, a motion d of the held end 2 d, and what
// resists along the bar stays.
std::string cone(std::size_t elements, const std::string& method, const std::string& more, bool transformed,
                 bool moved = false) {
  const auto data = [&](const std::string& f) { return transformed ? "(2-x)*(" + f + ")" : f; };
  const std::string motion = moved ? fmt::format("motion = \"{}*(1-cos(3*t))\"\n", transformed ? 0.06 : 0.03) : "";
  return fmt::format(
      "[bar]\nlength = 1.0\ndensity = 1.1\nmodulus = 0.9\nviscosity = 0.2\n{}[left]\nkind = \"fixed\"\n{}[right]\n"
      "kind = \"obstacle\"\ngap = 0.05\n{}[initial]\ndisplacement = \"{}\"\nvelocity = \"{}\"\n[load]\ndensity = "
      "\"{}\"\n[side]\nstiffness = 0.7\ndrag = 0.3\n[time]\nend = 2.4\n[mesh]\nelements = {}\nmass = "
      "\"fourth_order\"\n[method]\nname = \"{}\"\n{}[output]\nevery = 0.2\n",
      transformed ? "" : "section = \"(2-x)^2\"\n", motion, transformed ? "stiffness = 0.9\ndashpot = 0.2\n" : "",
      data("0.02*x*x*(3-2*x)"), data("-x*x*(3-2*x)"), data("-x*exp(-t)"), elements, method, more);
}

TEST(SectionContact, OfAConeIsThatOfTheBarThatItIsTransformedInto) {
  const std::string tolerance = "relative_tolerance = 1e-11\n";
  for (const bool moved : {false, true}) {
    const Recording truth = record(parse_scene(cone(320, "rigid", tolerance, true, moved), "").run);
    ASSERT_GE(truth.events.size(), 2u);
    std::vector<double> displacement, times;
    for (const std::size_t elements : {20u, 40u, 80u}) {
      const Recording run = record(parse_scene(cone(elements, "rigid", tolerance, false, moved), "").run);
      ASSERT_EQ(run.events.size(), truth.events.size());
      std::vector<double> ends, of_truth;
      for (std::size_t k = 0; k < run.times.size(); ++k)
        ends.push_back(run.displacement(k).back()), of_truth.push_back(truth.displacement(k).back());
      displacement.push_back(distance(ends, of_truth));
      double late = 0.0;
      for (std::size_t k = 0; k < run.events.size(); ++k)
        late = std::max(late, std::abs(run.events[k].time - truth.events[k].time));
      times.push_back(late);
      const EnergyAccount& energy = *run.statistics.energy;
      EXPECT_NEAR(energy.final, energy.initial + energy.work - energy.dissipated, 1e-10) << elements;
      EXPECT_NEAR(run.statistics.account->right.impulse, truth.statistics.account->right.impulse,
                  40.0 / std::pow(static_cast<double>(elements), 4))
          << elements;
    }
    for (const double order : orders(displacement)) EXPECT_NEAR(order, 4.0, 0.4) << moved;
    for (const double order : orders(times)) EXPECT_NEAR(order, 4.0, 0.5) << moved;
  }
}

// Rows that are not alike have no filter of high modes, whose polynomials are for the spectrum of those that are.
TEST(SectionContact, OnUnequalElementsNeverGrowsAndIsNearerToAFineMeshThanConsistent) {
  const auto run = [](const std::string& mesh, const std::string& mass, const std::string& method) {
    return record(parse_scene(fmt::format("[bar]\nlength = 1.0\nviscosity = 0.01\n[left]\nkind = \"obstacle\"\ngap = "
                                          "0.1\n[initial]\nvelocity = \"-x\"\n[time]\nend = 10.0\n[mesh]\n{}\nmass = "
                                          "\"{}\"\n[method]\nname = \"{}\"\nstep = 1e-3\n[contact]\nepsilon = 1e-4\n",
                                          mesh, mass, method),
                              "")
                      .run);
  };
  for (const char* mesh : {"elements = 20\ngrading = 2.0", "elements = 40\ngrading = 16.0",
                           "nodes = [0.0, 0.2, 0.5, 0.75, 0.9, 1.0]\nelements = 24"})
    for (const char* method : {"rigid", "fully_discrete", "cvode", "exponential"}) {
      const auto end = [](const Recording& of) { return of.displacement(of.times.size() - 1).back(); };
      const Recording here = run(mesh, "fourth_order", method);
      // On 120, 140 and 124 elements.
      const double truth =
          end(run(std::regex_replace(mesh, std::regex("elements = "), "elements = 1"), "fourth_order", method));
      EXPECT_LT(std::abs(end(here) - truth), std::abs(end(run(mesh, "consistent", method)) - truth)) << mesh << method;
      EXPECT_LT(here.statistics.energy->largest, 1.05 * here.statistics.energy->initial) << mesh << method;
    }
}

// A bar so stiff that it moves as a rigid body, by int A f dx / int A dx. The section jumps within an element, apart
// from the jump of f.
TEST(SectionMoments, OfLoadsAndVelocitiesWithBreaksHaveTheWholeSection) {
  const double force = 0.31 + 2.0 * (0.22 + 3.0 * 0.47), mass = 0.53 + 3.0 * 0.47;
  struct Push {
    const char* lines;
    double u;  // at t = 1
  };
  for (const auto& [lines, u] : {Push{"[load]\nprofile = \"x < 0.31 ? 1 : 2\"\nhistory = 1\n", 0.5 * force / mass},
                                 Push{"[load]\ndensity = \"x < 0.31 + 0*t ? 1 : 2\"\n", 0.5 * force / mass},
                                 Push{"[initial]\nvelocity = \"x < 0.31 ? 1 : 2\"\n", force / mass}})
    for (const char* of : {"fourth_order", "consistent", "lumped"}) {
      const Recording run =
          record(parse_scene(fmt::format("[bar]\nlength = 1.0\nmodulus = 1e8\nviscosity = 1e6\n"
                                         "section = \"x < 0.53 ? 1 : 3\"\n{}[time]\nend = 1.0\n[mesh]\n"
                                         "elements = 7\nmass = \"{}\"\n[method]\nname = \"rigid\"\n",
                                         lines, of),
                             "")
                     .run);
      for (const double end :
           {run.displacement(run.times.size() - 1).front(), run.displacement(run.times.size() - 1).back()})
        EXPECT_NEAR(end, u, 1e-5) << lines << of;
    }
}

// Forces are as the area, and so is what they move. A power of two times, to the last bit but for the tolerance, which
// has a force in it.
TEST(SectionContact, OpensWhenItDoesWhateverTheUnitOfArea) {
  const auto events_of = [](double area, const char* joint, double tolerance) {
    return record(parse_scene(
                      fmt::format("[[bar]]\nlength = 1.0\nviscosity = 0.1\nsection = {0}\nvelocity = -1.0\nelements = "
                                  "20\n{1}[left]\nkind = \"obstacle\"\ngap = 0.05\n[time]\nend = 9.0\n[method]\nname = "
                                  "\"rigid\"\nrelative_tolerance = {2}\n",
                                  area, fmt::format(fmt::runtime(joint), area), tolerance),
                      "")
                      .run)
        .events;
  };
  for (const char* joint :
       {"", "[[bar]]\nmass = {0}\nvelocity = -1.0\n[[joint]]\nkind = \"spring\"\nstiffness = {0}\n"})
    for (const double tolerance : {1e-3, 1e-6}) {
      const std::vector<Event> unit = events_of(1.0, joint, tolerance);
      ASSERT_GE(unit.size(), 2U);
      for (const double area : {0x1p-13, 0x1p-27, 0x1p20}) {
        const std::vector<Event> other = events_of(area, joint, tolerance);
        ASSERT_EQ(other.size(), unit.size()) << area << joint << tolerance;
        for (std::size_t k = 0; k < unit.size(); ++k)
          EXPECT_NEAR(other[k].time, unit[k].time, tolerance) << area << joint << tolerance;
      }
    }
}

// A force that is the same along the bar strains it by 1 / A: u = s(x).
TEST(SectionGauges, BesideABreakOfTheSectionAreOfOneSide) {
  for (const char* elements : {"20", "7", "3"}) {
    const Case run =
        parse_scene(fmt::format("[bar]\nlength = 1.0\nsection = \"x < 0.5 ? 1 : 2\"\n[left]\nkind = \"free\"\n"
                                "force = 1.0\n[time]\nend = 1.0\n[mesh]\nelements = {}\n",
                                elements),
                    "")
            .run;
    const Mesh mesh = resolve(run).mesh;
    const auto s = [](double x) { return x < 0.5 ? x : 0.5 + 0.5 * (x - 0.5); };
    std::vector<double> u;
    for (std::size_t j = 0; j < mesh.nodes(); ++j) u.push_back(s(mesh.node(j)));
    for (const double x : {0.0, 0.42, 0.47, 0.499, 0.501, 0.53, 0.58, 1.0}) {
      const Gauge::Reading at = Gauge(mesh, run.scene, x)(u, u);
      EXPECT_NEAR(at.u, s(x), 1e-14) << elements << " elements, x = " << x;
      EXPECT_NEAR(at.strain, x < 0.5 ? 1.0 : 0.5, 1e-12) << elements << " elements, x = " << x;
    }
  }
}

// The transformed bar on as many elements differs by O(h^4), to 50 h^4 with derivatives of these data.
TEST(SectionContact, OfAConeIsTheSameInEveryMethod) {
  const std::string tolerance = "relative_tolerance = 1e-8\n";
  const std::string stiff = tolerance + "[contact]\nepsilon = 1e-4\n";
  for (const char* method : {"cvode", "ida", "arkode", "odeint", "exponential"}) {
    const Recording run = record(parse_scene(cone(40, method, stiff, false), "").run);
    const Recording same = record(parse_scene(cone(40, method, stiff, true), "").run);
    ASSERT_EQ(run.events.size(), same.events.size()) << method;
    for (std::size_t k = 0; k < run.times.size(); ++k)
      EXPECT_NEAR(run.displacement(k).back(), same.displacement(k).back(), 50.0 / std::pow(40.0, 4)) << method;
    const EnergyAccount& energy = *run.statistics.energy;
    EXPECT_NEAR(energy.final, energy.initial + energy.work - energy.dissipated, 1e-7) << method;
  }
  for (const std::size_t elements : {40, 160}) {  // node by node, and 16 nodes side by side
    const Recording run = record(parse_scene(cone(elements, "fully_discrete", "step = 1e-4\n", false), "").run);
    const Recording same = record(parse_scene(cone(elements, "fully_discrete", "step = 1e-4\n", true), "").run);
    for (std::size_t k = 0; k < run.times.size(); ++k)
      EXPECT_NEAR(run.displacement(k).back(), same.displacement(k).back(),
                  50.0 / std::pow(static_cast<double>(elements), 4))
          << elements;
    const EnergyAccount& energy = *run.statistics.energy;
    EXPECT_NEAR(energy.final, energy.initial + energy.work - energy.dissipated, 1e-12) << elements;
  }
}

}  // namespace
}  // namespace viscobar
