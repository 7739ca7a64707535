#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>

#include "run/stopwatch.hpp"

namespace viscobar::cli {

struct MessageOptions {
  std::string log;
  bool verbose = false;

  void add_to(CLI::App& command);
  /// From now on messages go where the options say; the log begins with the command line. @throws IoError
  void begin(int argc, char** argv) const;
};

/// Before anything else: standard streams that were closed are opened, so that no file of ours takes their place, and a
/// pipe whose reader has gone is an error of the write, not the end of the program.
void open_standard_streams();

/// Each writes a message to standard error, and to the log where there is one; colours are for terminals that want
/// them. Whatever a message quotes is shown as printable(); what cannot be written is lost, and the program goes on.
void complain(std::string_view what);  ///< viscobar: ...
void warn(std::string_view what);      ///< warning: ...
void say(std::string_view what);       ///< as it is
/// To standard error with -v only, to the log always.
void detail(std::string_view what);

bool on_terminal();

/// A line on the terminal that says what is being done, overwritten by the next.
class StatusLine {
 public:
  StatusLine() = default;
  ~StatusLine() { clear(); }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  void show(std::string_view what);
  void clear();

 private:
  bool shown_ = false;
};

/// How far the work is, on the terminal, a few times a second once it has taken one.
class Progress {
 public:
  bool due();
  /// The line, and the time left, which follows from the share that is done.
  void show(const std::string& what, double share);

 private:
  WallClock clock_;
  double next_ = 1.0;  // on it
  StatusLine line_;
};

/// Closes the log with the exit code, which it returns.
int end_messages(int code);

}  // namespace viscobar::cli
