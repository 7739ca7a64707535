#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/messages.hpp"
#include "results/result_directory.hpp"
#include "text/nearest_name.hpp"
#include "text/number.hpp"
#include "viscobar/report/reports.hpp"

namespace viscobar::cli {

enum ExitCode { success = 0, run_failed = 1, wrong_input = 2, stopped = 130 };

/// Takes numbers from `low` to `high` only, as by CLI::Range, whose words differ from version to version.
template <class Number>
CLI::Option* within(CLI::Option* option, Number low, Number high) {
  const auto problem = [=](const std::string& text) {
    const auto value = number_in<Number>(text);
    return value && *value >= low && *value <= high ? ""
                                                    : fmt::format("Value {} not in range {} to {}", text, low, high);
  };
  return option->check(problem)->description(fmt::format("{}, {} to {}", option->get_description(), low, high));
}

/// Action of a command once its options are read; returns the exit code.
using Action = std::function<int()>;

/// Each gives a command its options; main.cpp has their names and descriptions.
Action run_command(CLI::App& command);
Action resume_command(CLI::App& command);
Action check_command(CLI::App& command);
Action compare_command(CLI::App& command);
Action limit_command(CLI::App& command);
Action precision_command(CLI::App& command);
Action fit_command(CLI::App& command);
Action sweep_command(CLI::App& command);
Action list_command(CLI::App& command);
Action new_command(CLI::App& command);
Action info_command(CLI::App& command);
Action export_command(CLI::App& command);
Action help_command(CLI::App& command);

/// An option, or an argument where the name has no dash, with a value of that type: "DIR", "csv|xdmf".
template <class Value>
CLI::Option* add(CLI::App& command, const std::string& name, const char* type, Value& value, const std::string& what) {
  return command.add_option(name, value, what)->type_name(type);
}

inline CLI::Option* add_repeatable(CLI::App& command, const std::string& name, const char* type,
                                   std::vector<std::string>& values, const std::string& what) {
  return add(command, name, type, values, what)->allow_extra_args(false);
}

/// An option with several values, commas between them.
template <class Value>
CLI::Option* add_list(CLI::App& command, const std::string& name, const char* type, std::vector<Value>& values,
                      const std::string& what) {
  return add(command, name, type, values, what)->delimiter(',')->allow_extra_args(false);
}

// Options that are the same for all commands that have them.
void add_set(CLI::App& command, std::vector<std::string>& overrides, const std::string& what);
void add_json(CLI::App& command, bool& json);
void add_quiet(CLI::App& command, bool& quiet);
void add_figures(CLI::App& command, bool& figures);
/// --error ERROR, an error that settings are chosen for; `what` says which.
void add_error(CLI::App& command, std::string& error, const std::string& what);
/// --threads N; 0 when it is not given, which means one a core.
void add_threads(CLI::App& command, std::size_t& threads,
                 const std::string& what = "Runs at a time (default: one a core)");

/// Options of every command that reads a scene: SCENE, --set table.key=value and --json.
struct SceneOptions {
  std::string file;
  std::vector<std::string> overrides;
  bool json = false;
  bool takes_accuracy = false;  ///< the command keeps an error that the scene asks for; others warn that they do not

  explicit SceneOptions(CLI::App& command);
  /// The scene with the user's own values, then those of `settings`; `adapt` is applied before it
  /// is validated. Tells what was read.
  SceneFile read(const std::vector<Setting>& settings = {}, const Adaptation& adapt = {}) const;
  std::string text() const;
  /// The same without a word, for a scene that is read again.
  SceneFile parse(const std::vector<Setting>& settings, const Adaptation& adapt = {}) const;
};

/// Options of every command that writes results: -o DIR and --quiet.
struct OutputOptions {
  std::string where;
  bool quiet = false;

  explicit OutputOptions(CLI::App& command);
  /// The directory that was asked for; else the name of the file with ".out", in the working directory.
  std::filesystem::path directory(const std::string& file) const;
};

/// Options of the commands of runs and studies: a scene, -o DIR, --quiet and --figures.
struct StudyOptions {
  SceneOptions scene;
  OutputOptions output;
  bool figures = false;

  explicit StudyOptions(CLI::App& command);
};

class Study {
 public:
  Study(const StudyOptions& options, const SceneFile& scene, ResultKind kind);

  /// Writes NAME.json, NAME.html and, if it is not empty, NAME.csv, and prints the first, or else the text and where
  /// the pictures are. @throws IoError
  void finish(StudyReport report) const;
  /// True if that would replace a complete result.
  bool replaces_whole() const { return is_complete(directory_.path() / (name_ + ".json")); }
  const std::filesystem::path& path() const { return directory_.path(); }  ///< directory of the results

 private:
  const StudyOptions& options_;
  const SceneFile& scene_;
  ResultDirectory directory_;
  std::string name_;
};

/// Warns of results of other commands in the directory that are of another bar, ends, initial data or load.
void warn_of_other_scenes(const std::filesystem::path& directory, const SceneFile& scene, ResultKind own);

/// The user asks for what cannot be. @throws std::invalid_argument
template <class... Args>
[[noreturn]] void refuse(fmt::format_string<Args...> why, Args&&... args) {
  throw std::invalid_argument(fmt::format(why, std::forward<Args>(args)...));
}

/// Ending of a message on an unknown word: the nearest known word, or all of them.
template <class Names>
std::string instead_of(const std::string& word, const Names& known, std::string_view all = ", only ") {
  const auto nearest = nearest_name(word, known);
  return nearest ? fmt::format("; did you mean {}?", *nearest) : fmt::format("{}{}", all, fmt::join(known, ", "));
}

/// The setting that checks a scene on the finest of several meshes; none where there are none.
std::vector<Setting> finest_mesh(const std::vector<std::size_t>& elements);

/// The methods that an option --methods names. @throws std::invalid_argument for an unknown one, with the nearest
std::vector<MethodName> methods_named(const std::vector<std::string>& words);

/// Value of an option such as "1e-2:1e-8", or a single number: numbers within [low, high], the larger first,
/// `per_decade` in a decade. @throws std::invalid_argument that names the option and says with `expected` what its
/// numbers are
struct DecadeRange {
  std::string_view option, expected, example;
  double low, high;

  std::vector<double> operator()(const std::string& text, std::size_t per_decade = 1) const;

 private:
  double number(const std::string& word) const;
};

/// Fault of a text that is to be a number, finite and above 0, or a number of elements that a mesh may have; empty if
/// it has none.
std::string positive_number(const std::string& text);
std::string number_of_elements(const std::string& text);

/// From now on SIGINT, SIGTERM and SIGHUP (unless it is ignored, as under nohup) only set a flag; a second one ends the
/// program at once.
void catch_interrupts();
bool interrupt_asked();
/// From now on the same signals end the program with exit code 130: for work that leaves nothing half done.
void end_on_interrupt();

/// Writes to standard output, as printable(), and makes sure that it got there. @throws IoError
void print(std::string_view text);

/// A line "  name   value" of a table of results.
std::string row(std::string_view name, std::string_view value);
template <class... Args>
std::string row(std::string_view name, fmt::format_string<Args...> value, Args&&... args) {
  return row(name, fmt::format(value, std::forward<Args>(args)...));
}

/// The title of a scene as the heading of a table, or something else where it has none.
std::string heading(const std::string& title, const std::string& otherwise);

}  // namespace viscobar::cli
