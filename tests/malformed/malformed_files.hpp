#pragma once

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "malformed/cases.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar::malformed {

namespace fs = std::filesystem;

/// Exactly the errors of `expected`, in their order, each on one line.
inline void expect_errors(const std::vector<Diagnostic>& found, const std::vector<std::string>& expected) {
  ASSERT_FALSE(expected.empty());
  std::string all;
  for (const Diagnostic& one : found) all += one.text() + "\n";
  EXPECT_EQ(found.size(), expected.size()) << all;
  for (std::size_t i = 0; i < std::min(found.size(), expected.size()); ++i) {
    std::istringstream words(expected[i]);
    std::string position, key, fragment;
    words >> position >> key >> std::ws;
    std::getline(words, fragment);
    ASSERT_FALSE(fragment.empty()) << expected[i];
    const Diagnostic& one = found[i];
    const std::string source = one.source == "--set" ? "--set:" : "";
    EXPECT_EQ(source + std::to_string(one.line) + ":" + std::to_string(one.column), position) << one.text();
    EXPECT_EQ(one.key.empty() ? "-" : one.key, key) << one.text();
    EXPECT_NE(one.message.find(fragment), std::string::npos) << one.text() << "\nlacks: " << fragment;
    EXPECT_EQ(one.text().find('\n'), std::string::npos) << one.text();
  }
}

/// The cases of a table, each as a file in a directory of the test's own, beside a sound scene.
class MalformedFiles : public testing_cli::Command {
 protected:
  explicit MalformedFiles(const std::string& table)
      : cases_(cases_of(VISCOBAR_SOURCE_DIR "/tests/malformed/" + table)) {
    fs::copy(VISCOBAR_SOURCE_DIR "/examples/scenes/chatter.toml", directory_);
  }

  /// `read(file, overrides)` of each case throws the errors announced.
  template <class Read>
  void expect_refused(Read read) const {
    for (const Case& one : cases_) {
      SCOPED_TRACE(one.place);
      std::vector<Diagnostic> found;
      try {
        read(file(one), one.overrides);
      } catch (const SceneError& error) {
        found = error.diagnostics;
      }
      expect_errors(found, one.errors);
    }
  }

  /// `command` ends on each case with code 2, the errors announced, a line each, and no result and no document begun.
  void expect_errors_alone(const std::string& command) const {
    for (const Case& one : cases_) {
      SCOPED_TRACE(one.place);
      std::string arguments = command + " --json -o out " + file(one).filename().string();
      for (const std::string& override : one.overrides) arguments += " --set " + quoted(override);
      const testing_cli::Ended ended = viscobar(arguments);
      EXPECT_EQ(ended.code, 2);
      EXPECT_EQ(ended.out, "");
      EXPECT_EQ(static_cast<std::size_t>(std::count(ended.error.begin(), ended.error.end(), '\n')), one.errors.size())
          << ended.error;
      EXPECT_FALSE(fs::exists(directory_ / "out"));
    }
  }

  std::vector<Case> cases_;

 private:
  fs::path file(const Case& one) const {
    const fs::path path = directory_ / "malformed.toml";
    std::ofstream(path, std::ios::binary) << one.text;
    return path;
  }

  static std::string quoted(const std::string& text) {
    std::string word = "'";
    for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
    return word + "'";
  }
};

}  // namespace viscobar::malformed
