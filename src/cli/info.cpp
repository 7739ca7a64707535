#include "cli/commands.hpp"
#include "io/result_info.hpp"

namespace viscobar::cli {

InfoCommand::InfoCommand(CLI::App& app)
    : Command(app, "info", "Say what is in a directory of results, or in one summary of it") {
  command_
      .add_option("directory", directory_,
                  "Where a command put its results, or a file there: summary.json, sweep.h5, ...")
      ->required()
      ->type_name("DIR");
  command_.add_flag("--json", json_, "Print one JSON document on standard output, and nothing else there");
}

int InfoCommand::operator()() const {
  print(json_ ? result_json(directory_) : result_text(directory_));
  return success;
}

}  // namespace viscobar::cli
