#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>

#include "cli/commands.hpp"
#include "input/scene_template.hpp"
#include "results/output_file.hpp"
#include "text/printable_text.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar::cli {

namespace {

/// Makes the file ours, empty, or tells that there is one: in one call, so that no other can come between.
void create_new(const std::string& file) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor >= 0) {
    ::close(descriptor);
    return;
  }
  if (errno == EEXIST) throw std::invalid_argument(file + " is there already; nothing was overwritten");
  throw IoError(file, "cannot be created: " + std::generic_category().message(errno));
}

}  // namespace

NewCommand::NewCommand(CLI::App& app) : Command(app, "new", "Write a commented scene to start from") {
  command_.add_option("file", file_, "The new file, which must not exist (default: standard output)")
      ->type_name("FILE");
}

int NewCommand::operator()() const {
  if (file_.empty()) {
    print(scene_template());
    return success;
  }
  create_new(file_);
  try {
    OutputFile file(file_, OutputFile::Content::keep);
    file.write_at(0, scene_template());
    file.close();
  } catch (const IoError&) {
    ::unlink(file_.c_str());
    throw;
  }
  print(fmt::format("{0} is a scene; edit it, then\n  viscobar check {0}\n  viscobar run {0}\n", one_line(file_)));
  return success;
}

}  // namespace viscobar::cli
