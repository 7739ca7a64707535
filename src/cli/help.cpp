#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"

namespace viscobar::cli {

HelpCommand::HelpCommand(CLI::App& app) : Command(app, "help", "Print the help of a command"), app_(app) {
  command_.add_option("command", topic_, "The command (default: the list of all)")->type_name("COMMAND");
}

int HelpCommand::operator()() const {
  if (topic_.empty()) {
    // App::help() would be that of the command that is asked, this one.
    print(app_.get_formatter()->make_help(&app_, "viscobar", CLI::AppFormatMode::Normal));
    return success;
  }
  std::vector<std::string> names;
  for (const CommandText& command : command_texts(app_)) names.push_back(command.name);
  if (std::find(names.begin(), names.end(), topic_) == names.end())
    throw std::invalid_argument(fmt::format("help: there is no command {}{}", topic_, instead_of(topic_, names)));
  print(app_.get_subcommand(topic_)->help("viscobar", CLI::AppFormatMode::Normal));
  return success;
}

}  // namespace viscobar::cli
