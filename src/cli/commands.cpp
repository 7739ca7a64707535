#include "cli/commands.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <system_error>

#include "viscobar/io/io_error.hpp"

namespace viscobar::cli {

SceneOptions::SceneOptions(CLI::App& command) {
  command.add_option("scene", file, "The scene file (TOML)")->required()->type_name("SCENE");
  command.add_option("--set", overrides, "Replace a value of the scene, such as contact.epsilon=1e-5 (repeatable)")
      ->type_name("TABLE.KEY=VALUE")
      ->allow_extra_args(false);
  command.add_flag("--json", json, "Print one JSON document on standard output, and nothing else there");
}

void print(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
    throw IoError("standard output", "cannot be written: " + std::generic_category().message(errno));
}

std::string row(std::string_view name, std::string_view value) { return fmt::format("  {:<20} {}\n", name, value); }

}  // namespace viscobar::cli
