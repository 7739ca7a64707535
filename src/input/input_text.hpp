#pragma once

#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace viscobar {

/// Bytes of a scene or sweep file at most; a scene takes about one thousand.
inline constexpr std::size_t longest_scene = std::size_t{1} << 20;

/// The text of a file that the user wrote. @throws SceneError when it cannot be read or has more bytes than that
std::string input_text(const std::filesystem::path& file, std::size_t most = longest_scene);
/// The same of a stream, which `name` names in the error.
std::string input_text(std::istream& stream, const std::string& name, std::size_t most = longest_scene);

inline bool is_digit(char c) { return c >= '0' && c <= '9'; }
inline bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// Without blanks, tabs and carriage returns at both ends.
std::string_view trimmed(std::string_view text);

/// The parts between the separators, one more than there are of them.
std::vector<std::string_view> split(std::string_view text, char separator);

}  // namespace viscobar
