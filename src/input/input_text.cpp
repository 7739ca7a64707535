#include "input/input_text.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <istream>

#include "viscobar/input/scene_file.hpp"

namespace viscobar {

std::string input_text(const std::filesystem::path& file, std::size_t most) {
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  return input_text(stream, file.empty() ? "\"\"" : file.string(), most);
}

std::string input_text(std::istream& stream, const std::string& name, std::size_t most) {
  const auto fail = [&](const std::string& problem) { throw SceneError({{name, 0, 0, "", problem}}); };
  std::string text;
  std::array<char, 4096> block;
  while (stream && text.size() <= most) {
    stream.read(block.data(), block.size());
    text.append(block.data(), static_cast<std::size_t>(stream.gcount()));
  }
  if (stream.eof() && text.size() <= most) return text;
  if (errno == ENOENT) fail("does not exist");
  fail("cannot be read: " +
       (errno != 0 ? std::strerror(errno) : "it is longer than " + std::to_string(most >> 20) + " MiB"));
  return text;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t end = 0; (end = text.find(separator)) != text.npos; text.remove_prefix(end + 1))
    parts.push_back(text.substr(0, end));
  parts.push_back(text);
  return parts;
}

}  // namespace viscobar
