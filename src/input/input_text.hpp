#pragma once

#include <filesystem>
#include <string>

namespace viscobar {

/// The text of a file that the user wrote. @throws SceneError when it cannot be read or is longer than 1 MiB
std::string input_text(const std::filesystem::path& file);

}  // namespace viscobar
