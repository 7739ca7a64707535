#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

namespace viscobar::testing_cli {

namespace fs = std::filesystem;

inline std::string content(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// What a command printed and how it ended.
struct Ended {
  int code = -1;
  std::string out, error;

  nlohmann::json json() const { return nlohmann::json::parse(out); }
};

/// Runs the program in a directory of the test's own.
class Command : public testing::Test {
 protected:
  Command() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(info->test_suite_name()) + "." + info->name();
    for (char& c : name)
      if (c == '/') c = '-';
    directory_ = fs::path(testing::TempDir()) / ("viscobar-" + name + "-" + std::to_string(getpid()));
    fs::create_directories(directory_);
  }
  ~Command() override {
    std::error_code ignored;
    fs::remove_all(directory_, ignored);
  }

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
    ended.error = content(error);
    return ended;
  }

  /// Path of a scene among the examples, quoted.
  static std::string scene(const std::string& name) {
    return "'" VISCOBAR_SOURCE_DIR "/examples/scenes/" + name + ".toml'";
  }

  fs::path directory_;
};

}  // namespace viscobar::testing_cli
