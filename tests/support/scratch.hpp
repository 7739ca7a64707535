#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "viscobar/input/scene_file.hpp"

namespace viscobar {

/// A directory of its own for one test, removed with it.
class Scratch {
 public:
  Scratch() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(test->test_suite_name()) + "-" + test->name();
    std::ranges::replace(name, '/', '-');
    path_ = std::filesystem::temp_directory_path() / ("viscobar-" + std::to_string(::getpid()) + "-" + name);
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Scratch() { std::filesystem::remove_all(path_); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline std::string read_text(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

inline std::vector<std::string> read_lines(const std::filesystem::path& file) {
  std::vector<std::string> lines;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// A bar that falls on an obstacle at its left end at t = 0.1 and leaves it again before t = 1.
inline SceneFile bouncing_bar() {
  SceneFile file;
  Case& run = file.run;
  run.scene.title = "A <bounce> & back";
  run.scene.bar.length = 0.3;
  run.scene.bar.viscosity = 0.5;
  run.scene.left = Obstacle{0.1};
  run.scene.displacement = [](double) { return 0.0; };
  run.scene.velocity = [](double) { return -1.0; };
  run.elements = 10;
  run.epsilon = 1e-3;
  run.method = MethodName::cvode;
  run.end = 1.0;
  run.output_every = 0.01;
  file.values = {{"bar.viscosity", 0.5}};
  return file;
}

}  // namespace viscobar
