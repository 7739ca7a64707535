#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "viscobar/io/scene_file.hpp"

namespace viscobar::cli {

enum ExitCode { success = 0, run_failed = 1, wrong_input = 2, stopped = 130 };

/// What every command that reads a scene understands: SCENE, --set table.key=value and --json.
struct SceneOptions {
  std::string file;
  std::vector<std::string> overrides;
  bool json = false;

  explicit SceneOptions(CLI::App& command);
  SceneFile read() const { return read_scene(file, overrides); }
};

class RunCommand {
 public:
  explicit RunCommand(CLI::App& app);
  bool chosen() const { return command_.parsed(); }
  int operator()() const;

 private:
  CLI::App& command_;
  SceneOptions scene_;
  std::string directory_;
  bool quiet_ = false;
};

class CheckCommand {
 public:
  explicit CheckCommand(CLI::App& app);
  bool chosen() const { return command_.parsed(); }
  int operator()() const;

 private:
  CLI::App& command_;
  SceneOptions scene_;
};

/// Writes to standard output and makes sure that it got there. @throws IoError
void print(std::string_view text);

/// A line "  name   value" of a table of results.
std::string row(std::string_view name, std::string_view value);

}  // namespace viscobar::cli
