#pragma once

#include <stdexcept>

namespace viscobar {

/// A step that could not be made.
struct StepFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace viscobar
