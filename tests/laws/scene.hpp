#pragma once

#include <fmt/format.h>

#include <array>
#include <string>

#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

/// Stops with a law of their own.
namespace viscobar::laws {

inline constexpr std::array all_methods = {"cvode", "ida", "arkode", "odeint"};
/// Those that take spring_damper.
inline constexpr std::array linear_methods = {"cvode", "ida", "arkode", "odeint", "exponential"};

/// A run with its energy and account.
struct Outcome {
  std::vector<Event> events;
  Statistics statistics;
};

inline Outcome outcome(const Case& run) {
  Outcome made;
  Observers observers;
  observers.event = [&](const Event& event) { made.events.push_back(event); };
  observers.energy = observers.account = true;
  made.statistics = simulate(resolve(run), observers);
  return made;
}
inline Outcome outcome(const std::string& scene) { return outcome(parse_scene(scene, "").run); }

/// "[left] contact = { ... }"
inline std::string contact(const std::string& law, double stiffness, double damping = 0.0) {
  return fmt::format("contact = {{ law = \"{}\", stiffness = {:.17g}{} }}\n", law, stiffness,
                     law == "hertz" ? "" : fmt::format(", damping = {:.17g}", damping));
}

/// A mass on the end of a bar that weighs and presses nearly nothing: all its numbers are 1e-12 of the mass's.
inline std::string lone_mass(const std::string& left, double speed, double end, const std::string& method,
                             double tolerance = 1e-11) {
  return fmt::format(
      "[bar]\nlength = 1\ndensity = 1e-12\nmodulus = 1e-12\n[left]\nkind = \"obstacle\"\ngap = 0\n{}[initial]\nvelocity = "
      "{:.17g}\n[time]\nend = {:.17g}\n[mesh]\nelements = 3\nmass = \"fourth_order\"\n[method]\nname = "
      "\"{}\"\nrelative_tolerance = {}\nabsolute_tolerance = 1e-14\n",
      left, -speed, end, method, tolerance);
}

/// A bar of unit numbers but for its viscosity, thrown at its left end's stop at speed 1.
inline std::string thrown_bar(const std::string& stop, double viscosity, int elements, double end,
                              const std::string& method, double tolerance = 1e-10) {
  return fmt::format(
      "[bar]\nlength = 1\nviscosity = {}\n[left]\nkind = \"obstacle\"\ngap = 0\n{}[initial]\nvelocity = "
      "-1\n[time]\nend = {}\n[mesh]\nelements = {}\nmass = \"fourth_order\"\n[method]\nname = \"{}\"\nrelative_tolerance = "
      "{}\n",
      viscosity, stop, end, elements, method, tolerance);
}

}  // namespace viscobar::laws
