#pragma once

#include <stdexcept>
#include <string_view>

namespace viscobar {

/// A step that could not be made.
struct StepFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What to change in a scene.
namespace remedy {

inline constexpr std::string_view accuracy =
    "loosen method.relative_tolerance and method.absolute_tolerance, take a larger contact.epsilon, or check the load "
    "for jumps";
inline constexpr std::string_view rounding = "loosen method.relative_tolerance or raise method.absolute_tolerance";
inline constexpr std::string_view stiffness =
    "take a larger contact.epsilon, mesh.mass = \"redistributed\" or method.name = \"arkode\"; check initial data and "
    "load for values that are far too large";
inline constexpr std::string_view load =
    "change load.density, or load.profile and load.history, so that the load is finite until time.end";
inline constexpr std::string_view times = "choose a later time.end, or a longer output.every";
inline constexpr std::string_view length =
    "choose an earlier time.end, loosen method.relative_tolerance, or take a larger contact.epsilon";
inline constexpr std::string_view chatter =
    "contact nodes bounce without end: take mesh.mass = \"redistributed\", contact.restitution = 0, or a larger "
    "contact.epsilon";
inline constexpr std::string_view memory = "take fewer mesh.elements";
inline constexpr std::string_view report =
    "nothing in the scene is known to cause it: please report it as an error of viscobar, with the scene; another "
    "method.name may do";

}  // namespace remedy

/// Of a step whose new state is not finite.
inline constexpr const char* not_finite =
    "the solution is no longer finite: the numbers of the scene are too large, or too far apart; bring initial data, "
    "load, bar.modulus, bar.density and contact.epsilon nearer to one by a choice of units";

}  // namespace viscobar
