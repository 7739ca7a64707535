#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

#include "malformed/expectations.hpp"

namespace viscobar::malformed {

/// The program on malformed files.
class ByProgram : public testing_cli::Command {
 protected:
  /// `command` ends on each file of the folder with code 2, the errors that the file announces, a line each, and no
  /// result and no document begun.
  void expect_errors_alone(const std::string& command, const fs::path& folder) const {
    for (const fs::path& file : files_in(folder)) {
      const Expectations expected = expectations_of(file);
      std::string arguments = command + " --json -o out " + quoted(file.string());
      for (const std::string& one : expected.overrides) arguments += " --set " + quoted(one);
      const testing_cli::Ended ended = viscobar(arguments);
      EXPECT_EQ(ended.code, 2) << file;
      EXPECT_EQ(ended.out, "") << file;
      EXPECT_EQ(static_cast<std::size_t>(std::count(ended.error.begin(), ended.error.end(), '\n')),
                expected.errors.size())
          << file << "\n"
          << ended.error;
      EXPECT_FALSE(fs::exists(directory_ / "out")) << file;
    }
  }

 private:
  static std::string quoted(const std::string& text) {
    std::string word = "'";
    for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
    return word + "'";
  }
};

}  // namespace viscobar::malformed
