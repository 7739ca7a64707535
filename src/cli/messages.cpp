#include "cli/messages.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <system_error>

#include "cli/progress.hpp"
#include "viscobar/io/io_error.hpp"
#include "viscobar/io/versions.hpp"

namespace viscobar::cli {

namespace {

using Clock = std::chrono::steady_clock;

/// The log beside standard error: as that, one for the process.
struct Log {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file{nullptr, &std::fclose};
  bool verbose = false;
  Clock::time_point started = Clock::now();
} the_log;

void write_log(std::string_view what) {
  if (!the_log.file) return;
  // A line at a time, so that it is there when the program is killed. What cannot be written is lost, the run goes on.
  fmt::print(the_log.file.get(), "{:%Y-%m-%dT%H:%M:%SZ} {}\n", fmt::gmtime(std::time(nullptr)), what);
  std::fflush(the_log.file.get());
}

bool colours() {
  const auto is_set = [](const char* name) {
    const char* value = std::getenv(name);
    return value && *value;
  };
  return on_terminal() && !is_set("NO_COLOR") && is_set("TERM") && std::string_view(std::getenv("TERM")) != "dumb";
}

void write_line(std::string_view word, std::string_view colour, std::string_view what) {
  if (on_terminal()) fmt::print(stderr, "\r\033[K");  // a progress line may stand there
  if (word.empty())
    fmt::print(stderr, "{}\n", what);
  else if (colours())
    fmt::print(stderr, "\033[{}m{}\033[0m {}\n", colour, word, what);
  else
    fmt::print(stderr, "{} {}\n", word, what);
}

void write_both(std::string_view word, std::string_view colour, std::string_view what) {
  write_line(word, colour, what);
  write_log(word.empty() ? std::string(what) : fmt::format("{} {}", word, what));
}

}  // namespace

void MessageOptions::add_to(CLI::App& command) {
  command.add_option("--log", log, "Append to FILE what is done, and every message, with the time")->type_name("FILE");
  command.add_flag("-v,--verbose", verbose, "Say more on standard error: what is read, contact changes as they come");
}

void MessageOptions::begin(int argc, char** argv) const {
  the_log.verbose = verbose;
  if (log.empty()) return;
  the_log.file.reset(std::fopen(log.c_str(), "ae"));
  if (!the_log.file) throw IoError(log, "cannot be opened: " + std::generic_category().message(errno));
  const Versions used = versions();
  std::string line = fmt::format("viscobar {}:", used.viscobar);
  for (int i = 1; i < argc; ++i) line += fmt::format(" {}", argv[i]);
  write_log(line);
  write_log(fmt::format("SUNDIALS {}, HDF5 {}, {}", used.sundials, used.hdf5, used.platform));
}

void complain(std::string_view what) { write_both("viscobar:", "1;31", what); }
void warn(std::string_view what) { write_both("warning:", "1;33", what); }
void say(std::string_view what) { write_both("", "", what); }

void detail(std::string_view what) {
  if (the_log.verbose) write_line("", "", what);
  write_log(what);
}

int end_messages(int code) {
  write_log(fmt::format("exit code {} after {:.3f} s", code,
                        std::chrono::duration<double>(Clock::now() - the_log.started).count()));
  the_log.file.reset();
  return code;
}

}  // namespace viscobar::cli
