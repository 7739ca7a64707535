#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "viscobar/run/run.hpp"

namespace viscobar::sundials {

enum class Library : std::size_t { cvode, ida, arkode };

/// Meaning of a return flag.
struct ReturnFlag {
  std::array<int, 3> values;  ///< in each Library, negative; 0 where there is none
  std::string_view meaning;
  Failure why;
};

/// The failures that a scene can bring about.
std::span<const ReturnFlag> return_flags();

/// The row of a flag of a library. Any other is a defect: of what viscobar asks the library for, or of the library.
const ReturnFlag& return_flag(Library library, int value);

}  // namespace viscobar::sundials
