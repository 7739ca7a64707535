#pragma once

#include <stdexcept>
#include <string>

#include "viscobar/run/run.hpp"

namespace viscobar {

/// A step that could not be made.
struct StepFailure : std::runtime_error {
  StepFailure(Failure because, const std::string& what) : std::runtime_error(what), why(because) {}
  Failure why;
};

/// The failure of a step whose new state is not finite.
inline StepFailure not_finite() { return {Failure::overflow, "the solution is no longer finite"}; }

}  // namespace viscobar
