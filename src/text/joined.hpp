#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

namespace viscobar {

/// The parts behind each other, copied once: fmt::format copies long ones three times.
inline std::string joined(std::initializer_list<std::string_view> parts) {
  std::size_t size = 0;
  for (const std::string_view part : parts) size += part.size();
  std::string text;
  text.reserve(size);
  for (const std::string_view part : parts) text += part;
  return text;
}

}  // namespace viscobar
