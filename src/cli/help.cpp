#include <algorithm>

#include "cli/commands.hpp"

namespace viscobar::cli {

Action help_command(CLI::App& command) {
  const auto topic = std::make_shared<std::string>();
  add(command, "command", "COMMAND", *topic, "The command (default: the list of all)");
  return [topic, &app = *command.get_parent()] {
    if (topic->empty()) {
      // App::help() would be that of the command that is asked, this one.
      print(app.get_formatter()->make_help(&app, "viscobar", CLI::AppFormatMode::Normal));
      return success;
    }
    std::vector<std::string> names;
    for (const CLI::App* known : app.get_subcommands({})) names.push_back(known->get_name());
    if (std::ranges::find(names, *topic) == names.end())
      refuse("help: there is no command {}{}", *topic, instead_of(*topic, names));
    print(app.get_subcommand(*topic)->help("viscobar", CLI::AppFormatMode::Normal));
    return success;
  };
}

}  // namespace viscobar::cli
