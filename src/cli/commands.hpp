#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "text/nearest_name.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
struct PicturedPage;
}

namespace viscobar::cli {

enum ExitCode { success = 0, run_failed = 1, wrong_input = 2, stopped = 130 };

/// What every command that reads a scene understands: SCENE, --set table.key=value and --json.
struct SceneOptions {
  std::string file;
  std::vector<std::string> overrides;
  bool json = false;
  bool takes_accuracy = false;  ///< the command keeps an error that the scene asks for; others warn that they do not

  explicit SceneOptions(CLI::App& command);
  bool from_standard_input() const { return file == "-"; }
  /// The scene, values of `defaults` and `settings` ("table.key=value") put before and after the user's own,
  /// `adapt` applied before it is validated.
  SceneFile read(const std::vector<std::string>& defaults = {}, const std::vector<std::string>& settings = {},
                 const Adaptation& adapt = {}) const;
};

/// What every command that writes results understands: -o DIR and --quiet.
struct OutputOptions {
  std::string where;
  bool quiet = false;

  explicit OutputOptions(CLI::App& command);
  /// What was asked for, or the scene's name with ".out", in the working directory.
  std::filesystem::path directory(const SceneOptions& scene) const;
};

/// The same of a command whose results have pictures: --figures.
struct PictureOptions : OutputOptions {
  bool figures = false;

  explicit PictureOptions(CLI::App& command);
};

/// A command of the program; running it returns the exit code.
class Command {
 public:
  virtual ~Command() = default;
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  bool chosen() const { return command_.parsed(); }
  virtual int operator()() const = 0;

 protected:
  Command(CLI::App& app, const std::string& name, const std::string& description)
      : command_(*app.add_subcommand(name, description)) {}

  CLI::App& command_;
};

class RunCommand : public Command {
 public:
  explicit RunCommand(CLI::App& app);
  int operator()() const override;

 private:
  SceneOptions scene_;
  PictureOptions output_;
  std::string checkpoint_, wall_time_, error_;
  std::vector<std::string> sensitivity_;
  bool no_estimate_ = false;
};

class ResumeCommand : public Command {
 public:
  explicit ResumeCommand(CLI::App& app);
  int operator()() const override;

 private:
  std::string directory_, wall_time_;
  bool json_ = false, quiet_ = false, figures_ = false;
};

class CompareCommand : public Command {
 public:
  explicit CompareCommand(CLI::App& app);
  int operator()() const override;

 private:
  SceneOptions scene_;
  PictureOptions output_;
  std::vector<std::string> methods_;
  std::size_t threads_ = 0;
};

class LimitCommand : public Command {
 public:
  explicit LimitCommand(CLI::App& app);
  int operator()() const override;

 private:
  SceneOptions scene_;
  PictureOptions output_;
  std::string epsilon_, mass_, error_;
  std::size_t per_decade_ = 1, threads_ = 0;
  std::vector<std::size_t> elements_;
  std::vector<double> steps_;
  double budget_ = 60.0;
  bool derivatives_ = false;
};

class PrecisionCommand : public Command {
 public:
  explicit PrecisionCommand(CLI::App& app);
  int operator()() const override;

 private:
  SceneOptions scene_;
  PictureOptions output_;
  std::string tolerance_ = "1e-3:1e-10";
  std::vector<std::string> methods_;
  std::vector<std::size_t> elements_;
  std::size_t halvings_ = 9, repeat_ = 0, threads_ = 0;
  double seconds_ = 1.0;
};

class FitCommand : public Command {
 public:
  explicit FitCommand(CLI::App& app);
  int operator()() const override;

 private:
  SceneOptions scene_;
  PictureOptions output_;
  std::string data_, events_;
  std::vector<std::string> parameters_, bounds_, deviations_;
  std::size_t starts_ = 1, runs_ = 100;
};

class SweepCommand : public Command {
 public:
  explicit SweepCommand(CLI::App& app);
  int operator()() const override;

 private:
  std::string file_, error_;
  std::vector<std::string> overrides_;
  bool json_ = false;
  OutputOptions output_;
  std::size_t threads_ = 0;
};

class CheckCommand : public Command {
 public:
  explicit CheckCommand(CLI::App& app);
  int operator()() const override;

 private:
  SceneOptions scene_;
};

class ListCommand : public Command {
 public:
  explicit ListCommand(CLI::App& app);
  int operator()() const override;

 private:
  std::string what_;
  bool json_ = false, markdown_ = false;
};

class NewCommand : public Command {
 public:
  explicit NewCommand(CLI::App& app);
  int operator()() const override;

 private:
  std::string file_;
};

class InfoCommand : public Command {
 public:
  explicit InfoCommand(CLI::App& app);
  int operator()() const override;

 private:
  std::string directory_;
  bool json_ = false, verify_ = false;
};

class ExportCommand : public Command {
 public:
  explicit ExportCommand(CLI::App& app);
  int operator()() const override;

 private:
  std::string directory_, format_ = "csv", where_;
  bool quiet_ = false;
};

class CompletionCommand : public Command {
 public:
  explicit CompletionCommand(CLI::App& app);
  int operator()() const override;

 private:
  const CLI::App& app_;
  std::string shell_;
};

class ManCommand : public Command {
 public:
  explicit ManCommand(CLI::App& app);
  int operator()() const override;

 private:
  const CLI::App& app_;
};

class HelpCommand : public Command {
 public:
  explicit HelpCommand(CLI::App& app);
  int operator()() const override;

 private:
  CLI::App& app_;
  std::string topic_;
};

/// Warns of results of other commands in the directory that are of another bar, ends, initial data or load; `own` is
/// the summary that this command writes.
void warn_of_other_scenes(const std::filesystem::path& directory, const SceneFile& scene, std::string_view own);

/// Writes a study into DIR, NAME.json and NAME.html, and prints the one, or else `text` and where the pictures are.
/// @throws IoError
void finish_study(const std::string& name, const std::filesystem::path& directory, const SceneOptions& asked,
                  const PictureOptions& output, const SceneFile& scene, const std::string& json, PicturedPage page,
                  const std::string& text);

/// --figures, --json and --quiet, the same for all commands that have them.
void add_figures(CLI::App& command, bool& figures);
void add_json(CLI::App& command, bool& json);
void add_quiet(CLI::App& command, bool& quiet);

/// What follows "there is no such word": the nearest one of those that there are, or all of them.
template <class Names>
std::string instead_of(const std::string& word, const Names& known, std::string_view all = ", only ") {
  const auto nearest = nearest_name(word, known);
  return nearest ? fmt::format("; did you mean {}?", *nearest) : fmt::format("{}{}", all, fmt::join(known, ", "));
}

/// The setting of sensitivity.of that asks for these keys.
std::string sensitivities_of(const std::vector<std::string>& keys);

/// The methods that an option --methods names. @throws std::invalid_argument for an unknown one, with the nearest
std::vector<MethodName> methods_named(const std::vector<std::string>& words);

/// What "1e-2:1e-8", or one value, means to an option: numbers within [low, high], the larger first, `per_decade` in a
/// decade. @throws std::invalid_argument that names the option and says with `expected` what its numbers are
struct DecadeRange {
  std::string_view option, expected, example;
  double low, high;

  std::vector<double> operator()(const std::string& text, std::size_t per_decade = 1) const;

 private:
  double number(const std::string& word) const;
};

/// What lists and limits of numbers are checked by: finite, above 0; a number of elements that a mesh may have.
const CLI::Validator& positive_number();
const CLI::Validator& number_of_elements();

/// --threads N, the same for all commands that have it; 0 when it is not given, which means one a core.
void add_threads(CLI::App& command, std::size_t& threads, const std::string& what = "Runs at a time");

/// Writes to standard output, as printable(), and makes sure that it got there. @throws IoError
void print(std::string_view text);

/// A line "  name   value" of a table of results.
std::string row(std::string_view name, std::string_view value);

/// The title of a scene as the heading of a table, or something else where it has none.
std::string heading(const std::string& title, const std::string& otherwise);

}  // namespace viscobar::cli
