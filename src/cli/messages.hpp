#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>

namespace viscobar::cli {

/// What every command understands: --log FILE and -v.
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

/// Puts a line of progress in the place of the one before, on the terminal; an empty one clears it.
void show_status(std::string_view what);

/// Closes the log with the exit code, which it returns.
int end_messages(int code);

}  // namespace viscobar::cli
