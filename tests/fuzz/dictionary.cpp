// Prints a dictionary for libFuzzer: the names and words of scene files, and what formulas, ranges and sweeps consist
// of.
#include <fmt/format.h>

#include <set>
#include <string>

#include "input/scene_keys.hpp"

int main() {
  using namespace viscobar;
  std::set<std::string> words;
  for (const SceneKey& key : scene_keys()) {
    words.insert(std::string(key.leaf()) + " = ");
    words.insert(std::string(key.name));
    for (const Choice& choice : key.choices) words.insert("\"" + std::string(choice.name) + "\"");
  }
  for (const std::string_view table : scene_tables()) words.insert("[" + std::string(table) + "]\n");
  for (const char* word : {"sin(",
                           "cos(",
                           "tan(",
                           "exp(",
                           "log(",
                           "sqrt(",
                           "abs(",
                           "min(",
                           "max(",
                           "pi",
                           "x",
                           "t",
                           "&&",
                           "||",
                           "==",
                           "!=",
                           "<=",
                           ">=",
                           "?",
                           ":",
                           "1e308",
                           "1e-308",
                           "0/0",
                           "1/0",
                           "nan",
                           "inf",
                           "-inf",
                           "true",
                           "1979-05-27",
                           "\"\"\"",
                           "'''",
                           "[[",
                           "]]",
                           "{ ",
                           " }",
                           "0x7fffffffffffffff",
                           "1e100",
                           "\xEF\xBB\xBF",
                           "\r\n",
                           "scene = ",
                           "combine = ",
                           "[set]\n",
                           "[vary]\n",
                           "from = ",
                           "to = ",
                           "count = ",
                           "per_decade = ",
                           "spacing = ",
                           "\"zip\"",
                           "\"log\""})
    words.insert(word);
  for (const std::string& word : words) {
    std::string escaped;
    for (const char c : word) {
      const auto byte = static_cast<unsigned char>(c);
      const bool plain = byte >= 0x20 && byte < 0x7f && c != '"' && c != '\\';
      escaped += plain ? std::string(1, c) : fmt::format("\\x{:02X}", byte);
    }
    fmt::print("\"{}\"\n", escaped);
  }
}
