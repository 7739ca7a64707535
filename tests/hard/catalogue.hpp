#pragma once

#include <string>
#include <vector>

#include "hard/oracle.hpp"

namespace viscobar::hard {

/// A named error in place of a solution: what its message must say, by which methods (empty: all), and whether it has
/// to come or a right answer would do as well.
struct NamedError {
  std::string message;
  std::vector<MethodName> methods = {};
  bool certain = true;
};

/// A scene at which integrators break, or might. A user runs it by
///
///     viscobar run tests/hard/scenes/FILE.toml --set OVERRIDE ... --set mesh.mass=MASS --set method.name=METHOD
struct HardScene {
  std::string name;
  std::string file;
  std::vector<std::string> overrides;
  std::vector<Mass> masses;
  std::vector<Oracle> oracles;  ///< besides the invariants
  std::vector<NamedError> errors = {};
  std::vector<MethodName> methods = {};  ///< that the scene is meant for; empty: all
  bool slow = false;                     ///< too long for the tests: measure_stability runs it
};

/// All of them, in the order in which measure_stability prints them.
std::vector<HardScene> catalogue();

std::vector<HardScene> parameter_scenes();  ///< penalty, viscosity, mesh, gap, density, scale, step
std::vector<HardScene> contact_scenes();    ///< when and how contacts change
std::vector<HardScene> load_scenes();       ///< loads that are not smooth, or not finite
std::vector<HardScene> span_scenes();       ///< distributed obstacles, long runs

}  // namespace viscobar::hard
