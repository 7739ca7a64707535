#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar::malformed {

namespace fs = std::filesystem;

using testing_cli::content;

inline std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".toml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

inline std::string test_name(const testing::TestParamInfo<fs::path>& info) {
  std::string name = info.param.stem().string();
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

/// What a malformed file announces, in its first lines, or, where they would spoil it (an encoding, an empty file), in
/// NAME.expect beside it: "# set key=value" is an override, "# expect line:column key fragment" an error, in their
/// order. The key of an error that is about none is "-", and the position of one that is about an override begins with
/// "--set:".
struct Expectations {
  std::vector<std::string> overrides;
  std::vector<std::string> errors;
};

inline Expectations expectations_of(const fs::path& file) {
  const fs::path beside = fs::path(file).replace_extension(".expect");
  std::istringstream stream(content(fs::exists(beside) ? beside : file));
  Expectations expected;
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("# set "))
      expected.overrides.push_back(line.substr(6));
    else if (line.starts_with("# expect "))
      expected.errors.push_back(line.substr(9));
    else
      break;
  }
  return expected;
}

/// Exactly the announced errors, in their order, each on one line.
inline void expect_announced(const std::vector<Diagnostic>& found, const Expectations& expected) {
  ASSERT_FALSE(expected.errors.empty());
  std::string all;
  for (const Diagnostic& one : found) all += one.text() + "\n";
  EXPECT_EQ(found.size(), expected.errors.size()) << all;
  for (std::size_t i = 0; i < std::min(found.size(), expected.errors.size()); ++i) {
    std::istringstream words(expected.errors[i]);
    std::string position, key, fragment;
    words >> position >> key >> std::ws;
    std::getline(words, fragment);
    ASSERT_FALSE(fragment.empty()) << expected.errors[i];
    const Diagnostic& one = found[i];
    const std::string source = one.source == "--set" ? "--set:" : "";
    EXPECT_EQ(source + std::to_string(one.line) + ":" + std::to_string(one.column), position) << one.text();
    EXPECT_EQ(one.key.empty() ? "-" : one.key, key) << one.text();
    EXPECT_NE(one.message.find(fragment), std::string::npos) << one.text() << "\nlacks: " << fragment;
    EXPECT_EQ(one.text().find('\n'), std::string::npos) << one.text();
  }
}

}  // namespace viscobar::malformed
