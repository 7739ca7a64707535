#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "cli/commands.hpp"
#include "input/vocabulary.hpp"
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
  if (errno == EEXIST) refuse("{} is there already; nothing was overwritten", file);
  throw IoError(file, "cannot be created: " + std::generic_category().message(errno));
}

int make_scene(const std::string& file) {
  if (file.empty()) {
    print(scene_template());
    return success;
  }
  create_new(file);
  try {
    OutputFile output(file, OutputFile::Content::keep);
    output.write_at(0, scene_template());
    output.close();
  } catch (const IoError&) {
    ::unlink(file.c_str());
    throw;
  }
  print(fmt::format("{0} is a scene; edit it, then\n  viscobar check {0}\n  viscobar run {0}\n", one_line(file)));
  return success;
}

}  // namespace

Action new_command(CLI::App& command) {
  const auto file = std::make_shared<std::string>();
  add(command, "file", "FILE", *file, "The new file, which must not exist (default: standard output)");
  return [file] { return make_scene(*file); };
}

}  // namespace viscobar::cli
