#pragma once

#include <span>
#include <string_view>

#include "viscobar/run/run.hpp"

namespace viscobar::sundials {

/// What a return flag of a library means.
struct ReturnFlag {
  int value;
  std::string_view meaning;
  Failure why;
};

/// The failures of each library that a scene can bring about; negative flags only.
std::span<const ReturnFlag> cvode_flags();
std::span<const ReturnFlag> ida_flags();
std::span<const ReturnFlag> arkode_flags();

/// The row of a flag. Any other is a defect: of what viscobar asks the library for, or of the library.
const ReturnFlag& return_flag(std::span<const ReturnFlag> flags, int value);

}  // namespace viscobar::sundials
