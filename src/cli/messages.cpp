#include "cli/messages.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <memory>
#include <system_error>
#include <utility>

#include "cli/commands.hpp"
#include "text/printable_text.hpp"
#include "viscobar/results/io_error.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar::cli {

namespace {

/// The log beside standard error: as that, one for the process.
struct Log {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file{nullptr, &std::fclose};
  bool verbose = false, lost = false;  // `lost`: a line could not be written
  WallClock clock;
} the_log;

// Each line at once, so that it is there when the program is killed. A message that cannot be written is lost, and the
// run goes on; end_messages() tells of a log that is not complete.
bool put(std::FILE* file, std::string_view text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  return std::fflush(file) == 0 && written;
}

// A line that follows within a message is indented, so that no text of the user's can look like a message of its own.
std::string message(std::string_view what) {
  std::string text;
  for (const char c : printable(what)) text += c == '\n' ? "\n  " : std::string(1, c);
  return text;
}

void write_log(std::string_view what) {
  if (!the_log.file) return;
  const std::string line = fmt::format("{:%Y-%m-%dT%H:%M:%SZ} {}\n", fmt::gmtime(std::time(nullptr)), message(what));
  if (!put(the_log.file.get(), line)) the_log.lost = true;
}

/// A log is appended to a file that is empty, or begins like one: 2026-11-22T20:15:00Z viscobar. Pipes, devices
/// and the streams of this process (/dev/stderr) are what they are said to be. @throws std::invalid_argument for
/// another file, a scene for example
void check_log(int descriptor, const std::string& file) {
  constexpr std::string_view like = "0000-00-00T00:00:00Z viscobar ";
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode) || status.st_size == 0) return;
  if (file.starts_with("/dev/")) return;
  std::string begin(like.size(), '\0');
  std::ifstream(file, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size()));
  const auto fits = [](char a, char b) { return a == '0' ? b >= '0' && b <= '9' : a == b; };
  if (!std::equal(like.begin(), like.end(), begin.begin(), fits))
    refuse("--log: {} is not a log of viscobar; nothing was appended to it", file);
}

bool colours() {
  const auto is_set = [](const char* name) {
    const char* value = std::getenv(name);
    return value && *value;
  };
  return on_terminal() && !is_set("NO_COLOR") && is_set("TERM") && std::string_view(std::getenv("TERM")) != "dumb";
}

void write_line(std::string_view word, std::string_view colour, std::string_view what) {
  const std::string begin = on_terminal() ? "\r\033[K" : "";  // a progress line may stand there
  const std::string marked =
      colour.empty() || !colours() ? std::string(word) : fmt::format("\033[{}m{}\033[0m", colour, word);
  put(stderr, fmt::format("{}{}{}{}\n", begin, marked, word.empty() ? "" : " ", message(what)));
}

void write_both(std::string_view word, std::string_view colour, std::string_view what) {
  write_line(word, colour, what);
  write_log(fmt::format("{}{}{}", word, word.empty() ? "" : " ", what));
}

/// "35 s", "2 min 05 s", "3 h 07 min"
std::string duration(double seconds) {
  const auto whole = static_cast<long long>(seconds + 0.5);
  if (whole >= 3600) return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
  return whole >= 60 ? fmt::format("{} min {:02} s", whole / 60, whole % 60) : fmt::format("{} s", whole);
}

}  // namespace

void open_standard_streams() {
  // In the other direction than they are used, so that a result which nobody can read is still an error.
  for (const auto& [stream, mode] :
       {std::pair{STDIN_FILENO, O_WRONLY}, {STDOUT_FILENO, O_RDONLY}, {STDERR_FILENO, O_RDONLY}})
    if (::fcntl(stream, F_GETFD) == -1 && errno == EBADF && ::open("/dev/null", mode) != stream) std::_Exit(run_failed);
  std::signal(SIGPIPE, SIG_IGN);
}

bool on_terminal() { return isatty(STDERR_FILENO) == 1; }

void StatusLine::show(std::string_view what) {
  put(stderr, fmt::format("\r\033[K{}", what));
  shown_ = true;
}

void StatusLine::clear() {
  if (shown_) show("");
  shown_ = false;
}

bool Progress::due() {
  const double now = clock_.seconds();
  if (now < next_) return false;
  next_ = now + 0.2;
  return true;
}

void Progress::show(const std::string& what, double share) {
  const double elapsed = clock_.seconds();
  line_.show(share > 0.0 ? fmt::format("{}  {} left", what, duration(elapsed * (1.0 - share) / share)) : what);
}

void MessageOptions::add_to(CLI::App& command) {
  add(command, "--log", "FILE", log,
      "Append every action and message with its time to FILE, a new file or a log of viscobar");
  command.add_flag("-v,--verbose", verbose, "Print more on standard error: files read, contact changes as they happen");
}

void MessageOptions::begin(int argc, char** argv) const {
  the_log.verbose = verbose;
  if (log.empty()) return;
  // A pipe that nobody reads gives an error at once.
  const int descriptor = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_NONBLOCK | O_CLOEXEC, 0666);
  if (descriptor < 0) throw IoError(log, "cannot be opened: " + std::generic_category().message(errno));
  check_log(descriptor, log);
  ::fcntl(descriptor, F_SETFL, O_APPEND);
  the_log.file.reset(::fdopen(descriptor, "a"));
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
  write_log(fmt::format("exit code {} after {:.3f} s", code, the_log.clock.seconds()));
  if (the_log.file && std::fclose(the_log.file.release()) != 0) the_log.lost = true;
  if (the_log.lost) complain("--log: lines of the log could not be written; it is not complete");
  return code;
}

}  // namespace viscobar::cli
