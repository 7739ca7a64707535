#include "cli/commands.hpp"
#include "results/result_info.hpp"

namespace viscobar::cli {

namespace {

struct InfoOptions {
  std::string directory;
  bool json = false, verify = false;
};

int tell(const InfoOptions& asked) {
  if (!asked.verify) {
    print(asked.json ? result_json(asked.directory) : result_text(asked.directory));
    return success;
  }
  const auto files = verify_result(asked.directory);
  print(asked.json ? verification_json(asked.directory, files) : verification_text(asked.directory, files));
  const FileState state = verdict(files);
  return state == FileState::sound ? success : state == FileState::damaged ? run_failed : wrong_input;
}

}  // namespace

Action info_command(CLI::App& command) {
  const auto asked = std::make_shared<InfoOptions>();
  add(command, "directory", "DIR", asked->directory,
      "A directory of results, or a file in it: summary.json, sweep.h5, ...")
      ->required();
  command.add_flag("--verify", asked->verify,
                   "Read every file of the result and compare it with the checksums that were taken while it was "
                   "written; exit code 0: all sound, 1: damaged, 2: not checkable");
  add_json(command, asked->json);
  return [asked] { return tell(*asked); };
}

}  // namespace viscobar::cli
