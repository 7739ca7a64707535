#pragma once

#include <span>
#include <string>
#include <string_view>

#include "run/step_failure.hpp"

namespace viscobar::sundials {

/// What a return flag of a library means to who wrote the scene, and what to change.
struct ReturnFlag {
  int value;
  std::string_view meaning, remedy;
};

/// Every failure of each library, one table a library; negative flags only.
std::span<const ReturnFlag> cvode_flags();
std::span<const ReturnFlag> ida_flags();
std::span<const ReturnFlag> arkode_flags();

/// "meaning; remedy" of a flag; of one that is not in the table (a later release's), that it is unknown.
std::string explanation(std::span<const ReturnFlag> flags, int value);

}  // namespace viscobar::sundials
