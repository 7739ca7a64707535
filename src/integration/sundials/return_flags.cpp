#include "integration/sundials/return_flags.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace viscobar::sundials {

std::string explanation(std::span<const ReturnFlag> flags, int value) {
  const auto found = std::ranges::find(flags, value, &ReturnFlag::value);
  if (found == flags.end()) return fmt::format("a failure unknown to viscobar; {}", remedy::report);
  return fmt::format("{}; {}", found->meaning, found->remedy);
}

}  // namespace viscobar::sundials
