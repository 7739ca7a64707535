#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace viscobar::cli {

/// An option or argument as man page and completions tell it, read off the definition of the command line.
struct OptionText {
  std::vector<std::string> names;  ///< "-o", "--output"; of an argument none
  std::string type;                ///< "DIR"; empty: a flag
  std::string description, fallback;
  bool required = false, repeatable = false;

  bool is_argument() const { return names.empty(); }
  bool takes_list() const { return type.find(',') != type.npos; }
  /// The words that may stand here, blanks between them, where they are known: masses, methods, "csv|xdmf".
  std::string words() const;
};

std::vector<OptionText> options_of(const CLI::App& command);

}  // namespace viscobar::cli
