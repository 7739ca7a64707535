#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "support/scratch.hpp"

namespace viscobar::testing_cli {

namespace fs = std::filesystem;

/// Output and exit code of a command.
struct Ended {
  int code = -1;
  std::string out, error;

  nlohmann::json json() const { return nlohmann::json::parse(out); }
};

/// The last line of a table, by the names of its columns.
inline std::map<std::string, std::string> last_row(const std::string& table) {
  std::istringstream lines(table);
  std::string header, line, last;
  std::getline(lines, header);
  while (std::getline(lines, line))
    if (!line.empty()) last = line;
  std::map<std::string, std::string> row;
  std::istringstream names(header), cells(last);
  for (std::string name, cell; std::getline(names, name, ',') && std::getline(cells, cell, ',');) row[name] = cell;
  return row;
}

/// Runs the program in a directory of the test's own.
class Command : public testing::Test {
 protected:
  Ended viscobar(const std::string& arguments) const {
    const fs::path error = directory_ / "standard-error";
    const std::string line =
        "cd '" + directory_.string() + "' && '" VISCOBAR_COMMAND "' " + arguments + " 2>'" + error.string() + "'";
    Ended ended;
    FILE* pipe = popen(line.c_str(), "r");
    if (!pipe) return ended;
    std::array<char, 4096> buffer{};
    for (std::size_t n = 0; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
      ended.out.append(buffer.data(), n);
    const int status = pclose(pipe);
    if (WIFEXITED(status)) ended.code = WEXITSTATUS(status);
    ended.error = read_text(error);
    return ended;
  }

  /// Path of a scene among the examples, quoted.
  static std::string scene(const std::string& name) {
    return "'" VISCOBAR_SOURCE_DIR "/examples/scenes/" + name + ".toml'";
  }

  const Scratch scratch_;
  const fs::path directory_ = scratch_.path();
};

}  // namespace viscobar::testing_cli
