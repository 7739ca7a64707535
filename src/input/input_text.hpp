#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace viscobar {

/// The text of a file that the user wrote. @throws SceneError when it cannot be read or is longer than 1 MiB
std::string input_text(const std::filesystem::path& file);
/// The same of a stream, which `name` names in the error.
std::string input_text(std::istream& stream, const std::string& name);

inline bool is_digit(char c) { return c >= '0' && c <= '9'; }
/// Of ASCII.
inline bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// Without blanks, tabs and carriage returns at both ends.
std::string_view trimmed(std::string_view text);

/// The parts between the separators, one more than there are of them.
std::vector<std::string_view> split(std::string_view text, char separator);

}  // namespace viscobar
