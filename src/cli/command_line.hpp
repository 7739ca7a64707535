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
  /// The words that may stand here, where they are known: masses, methods, "csv|npy".
  std::vector<std::string> words() const;
};

struct CommandText {
  std::string name, description;
  std::vector<OptionText> options;
};

/// Commands with a group; hidden ones have none.
std::vector<CommandText> command_texts(const CLI::App& app);

/// What completes a word: a shell's function of this name, and the man page.
std::string bash_completion(const CLI::App& app);
std::string zsh_completion(const CLI::App& app);
std::string man_page(const CLI::App& app);

}  // namespace viscobar::cli
