#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

/// Bars against closed forms, and the order in which each method comes to them.
namespace viscobar::closed_forms {

// A bar whose numbers are not 1: c = sqrt(E / rho) = 1.5, Z = sqrt(E rho) = 3.
inline constexpr double length = 1.25, density = 2.0, modulus = 4.5, c = 1.5, impedance = 3.0;
inline constexpr const char* bar = "[bar]\nlength = 1.25\ndensity = 2\nmodulus = 4.5\n";

inline std::string numerics(int elements, const std::string& mass, const std::string& method, double end) {
  return fmt::format(
      "[time]\nend = {}\n[mesh]\nelements = {}\nmass = \"{}\"\n[method]\nname = \"{}\"\nrelative_tolerance = 1e-11\n"
      "step = {}\n[output]\nevery = {}\n",
      end, elements, mass, method, 0.02 / elements / elements, end / 16);
}

using Exact = std::function<double(double x, double t)>;

inline double error(const Recording& run, const Exact& u) {
  double most = 0.0;
  for (std::size_t k = 0; k < run.times.size(); ++k)
    for (std::size_t j = 0; j < run.mesh.nodes(); ++j)
      most = std::max(most, std::abs(run.displacement(k)[j] - u(run.mesh.node(j), run.times[k])));
  return most;
}

// The error on 2 n elements and what it falls by from n: the order of the mass, since time is resolved further.
inline void expect_order(double order, const std::function<std::string(int)>& scene, const Exact& u, int n) {
  const double coarse = error(record(parse_scene(scene(n), "").run), u);
  const double fine = error(record(parse_scene(scene(2 * n), "").run), u);
  EXPECT_GT(std::log2(coarse / fine), order - 0.4) << coarse << " " << fine;
}

struct Orders {
  std::string method, mass;
  double order;
};
inline const Orders all_orders[] = {{"cvode", "fourth_order", 4},        {"ida", "lumped", 2},
                                    {"arkode", "consistent", 2},         {"odeint", "lumped", 2},
                                    {"rigid", "fourth_order", 4},        {"exponential", "consistent", 2},
                                    {"fully_discrete", "consistent", 2}, {"finite_difference", "lumped", 2}};

}  // namespace viscobar::closed_forms
