#include "cli/commands.hpp"
#include "results/result_info.hpp"

namespace viscobar::cli {

InfoCommand::InfoCommand(CLI::App& app)
    : Command(app, "info", "List the contents of a directory of results, or of one summary") {
  command_.add_option("directory", directory_, "A directory of results, or a file in it: summary.json, sweep.h5, ...")
      ->required()
      ->type_name("DIR");
  command_.add_flag("--verify", verify_,
                    "Read every file of the result and compare it with the checksums that were taken while it was "
                    "written; exit code 0: all sound, 1: damaged, 2: not checkable");
  add_json(command_, json_);
}

int InfoCommand::operator()() const {
  if (verify_) {
    const auto files = verify_result(directory_);
    print(json_ ? verification_json(directory_, files) : verification_text(directory_, files));
    const FileState state = verdict(files);
    return state == FileState::sound ? success : state == FileState::damaged ? run_failed : wrong_input;
  }
  print(json_ ? result_json(directory_) : result_text(directory_));
  return success;
}

}  // namespace viscobar::cli
