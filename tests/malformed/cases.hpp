#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <stdexcept>
#include <string>
#include <vector>

namespace viscobar::malformed {

/// A malformed file: what is in it, the overrides that go with it, and the errors that it must get, each "line:column
/// key fragment".
struct Case {
  std::string place, text;
  std::vector<std::string> overrides, errors;
};

/// \x00 is a byte, «a×3» is aaa, and ¶ ends a line.
inline std::string written_out(std::string text) {
  const std::regex repeated("«(.*?)×([0-9]+)»"), byte(R"(\\x([0-9a-f]{2}))"), end("¶");
  for (std::smatch found; std::regex_search(text, found, repeated);) {
    std::string all;
    for (int i = std::stoi(found[2]); i > 0; --i) all += found[1];
    text = found.prefix().str() + all + found.suffix().str();
  }
  text = std::regex_replace(text, end, "\n");
  std::string bytes;
  for (std::smatch found; std::regex_search(text, found, byte); text = found.suffix().str())
    bytes += found.prefix().str() + static_cast<char>(std::stoi(found[1], nullptr, 16));
  return bytes + text;
}

/// A sound text and its changes, by the numbers of its lines.
class Edited {
 public:
  /// Appends a line, and returns its number.
  std::size_t add(const std::string& line) {
    lines_.push_back(line + "\n");
    return lines_.size();
  }

  /// Takes in a change as scenes.txt describes it; false where it is none.
  bool change(const std::string& edit) {
    static const std::regex form(R"((=|([0-9]*)(-([0-9]+))?(\+?))( (.*))?)");
    std::smatch part;
    if (!std::regex_match(edit, part, form)) return false;
    const std::string text = written_out(part[7]);
    if (part[1] == "=") {
      lines_ = {text};
      return true;
    }
    const std::size_t first = part[2].length() > 0 ? std::stoul(part[2]) : lines_.size();
    const std::size_t last = part[4].matched ? std::stoul(part[4]) : first;
    if (last > lines_.size() || (part[5] != "+" && first == 0)) return false;
    if (part[5] == "+") {
      added_[first] += text + "\n";
    } else {
      for (std::size_t i = first; i <= last; ++i) lines_[i - 1].clear();
      if (part[6].matched) lines_[first - 1] = text + "\n";
    }
    return true;
  }

  std::string text() {
    std::string all = added_[0];
    for (std::size_t i = 0; i < lines_.size(); ++i) all += lines_[i] + added_[i + 1];
    return all;
  }

 private:
  std::vector<std::string> lines_;
  std::map<std::size_t, std::string> added_;
};

/// The cases of a table such as scenes.txt, which begins with the description of the format.
inline std::vector<Case> cases_of(const std::filesystem::path& table) {
  std::ifstream stream(table);
  Edited sound, edited;
  std::vector<Case> cases;
  std::size_t number = 0;
  for (std::string line; std::getline(stream, line);) {
    const std::string place = table.filename().string() + ":" + std::to_string(++number);
    if (line.empty() || line.starts_with('#')) continue;
    if (line.starts_with("base ")) {
      const std::size_t blank = line.find(' ', 5);
      if (sound.add(line.substr(blank + 1)) != std::stoul(line.substr(5, blank)))
        throw std::invalid_argument(place + ": another number is next");
      continue;
    }
    if (!line.starts_with(' ')) {
      edited = sound;
      cases.push_back({place + ": " + line, {}, {}, {}});
    }
    line.erase(0, line.find_first_not_of(' '));
    if (line.starts_with("| ")) line.insert(0, 1, ' ');
    const std::size_t bar = line.rfind(" | ");
    if (bar != line.npos) cases.back().errors.push_back(line.substr(bar + 3));
    const std::string edit = line.substr(0, bar);
    if (edit.starts_with("--set "))
      cases.back().overrides.push_back(edit.substr(6));
    else if (!edit.empty() && !edited.change(edit))
      throw std::invalid_argument(place + ": no change: " + edit);
    cases.back().text = edited.text();
  }
  return cases;
}

}  // namespace viscobar::malformed
