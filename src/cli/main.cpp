#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <memory>
#include <new>
#include <sstream>
#include <vector>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "cli/messages.hpp"
#include "results/directory_lock.hpp"
#include "text/nearest_name.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar::cli {

namespace {

std::string version_text() {
  const Versions used = versions();
  return fmt::format("viscobar {} (SUNDIALS {}, HDF5 {}, Eigen {})", used.viscobar, used.sundials, used.hdf5,
                     used.eigen);
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string meant(const std::string& word, const std::vector<std::string>& known) {
  const auto nearest = nearest_name(word, known);
  return nearest ? fmt::format("; did you mean {}?", *nearest) : "";
}

/// What the user got wrong, with the nearest thing that exists.
std::string explanation(const CLI::App& app, const CLI::ParseError& error) {
  const auto chosen = app.get_subcommands();
  const CLI::App& command = chosen.empty() ? app : *chosen.front();
  for (const std::string& word : command.remaining()) {
    const std::string bare = word.substr(0, word.find('='));
    if (bare.starts_with('-')) return fmt::format("unknown option {}{}", bare, meant(bare, option_names(command)));
    if (!chosen.empty()) return fmt::format("unexpected argument {}", word);
    std::vector<std::string> names = option_names(app);
    for (const CLI::App* known : app.get_subcommands({})) names.push_back(known->get_name());
    return fmt::format("unknown command {}{}", word, meant(word, names));
  }
  const std::string what = error.what();
  if (what.find("flag override") != what.npos)
    return fmt::format("--{} takes no value", what.substr(0, what.find(' ')));
  if (!chosen.empty()) return what;
  std::vector<std::string> names;
  for (const CommandText& known : command_texts(app)) names.push_back(known.name);
  return fmt::format("no command given; there are {}", fmt::join(names, ", "));
}

/// An option that took another one, or nothing, for its value: it was forgotten, or a variable of the shell was empty.
void check_values(const CLI::App& command, int argc, char** argv) {
  const auto option = [&](const char* word) { return word[0] == '-' ? command.get_option_no_throw(word) : nullptr; };
  for (int i = 2; i + 1 < argc && std::string_view(argv[i]) != "--"; ++i)
    if (const CLI::Option* taker = option(argv[i]); taker && taker->get_items_expected_max() > 0 && option(argv[i + 1]))
      throw std::invalid_argument(fmt::format("{0} needs {1}, and {2} is an option; {0}={2} would take it for one",
                                              argv[i], taker->get_type_name(), argv[i + 1]));
  for (const CLI::Option* taker : command.get_options())
    if (!taker->get_positional() && taker->count() > 0 && taker->get_items_expected_max() > 0 &&
        std::ranges::any_of(taker->results(), [](const std::string& value) { return value.empty(); }))
      throw std::invalid_argument(taker->get_name() + ": is given no value");
}

template <class... Commands>
std::vector<std::unique_ptr<const Command>> add_commands(CLI::App& app) {
  std::vector<std::unique_ptr<const Command>> commands;
  (commands.push_back(std::make_unique<Commands>(app)), ...);
  return commands;
}

int run(int argc, char** argv) {
  CLI::App app("Motion of a viscoelastic bar against rigid obstacles", "viscobar");
  app.set_version_flag("-V,--version", version_text(), "Print the versions and exit");
  app.set_help_flag("-h,--help", "Print this help and exit");
  app.require_subcommand(1);
  const auto commands = add_commands<RunCommand, ResumeCommand, CheckCommand, CompareCommand, LimitCommand,
                                     PrecisionCommand, FitCommand, SweepCommand, ListCommand, NewCommand, InfoCommand,
                                     ExportCommand, CompletionCommand, ManCommand, HelpCommand>(app);
  MessageOptions messages;
  for (CLI::App* command : app.get_subcommands({})) {
    messages.add_to(*command);
    // A flag is given or not: --json=no would be read as --json.
    for (CLI::Option* option : command->get_options())
      if (option->get_expected_max() == 0) option->disable_flag_override();
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == success) {
      std::ostringstream text;
      app.exit(error, text);
      print(text.str());
      return success;
    }
    complain(explanation(app, error));
    const auto chosen = app.get_subcommands();
    say(fmt::format("viscobar {}--help says more.", chosen.empty() ? "" : chosen.front()->get_name() + " "));
    return wrong_input;
  }
  check_values(*app.get_subcommands().front(), argc, argv);
  messages.begin(argc, argv);
  const auto chosen = std::ranges::find_if(commands, [](const auto& command) { return command->chosen(); });
  try {
    return (**chosen)();
  } catch (const DirectoryInUse& error) {
    if (!error.by_same_job) throw;
    // mpirun would end the one that does run.
    warn(fmt::format("{}; this process does nothing, for only sweep makes use of several", error.what()));
    return success;
  }
}

/// Where memory ends inside of what promised not to throw, as libraries do: with a message and without allocating one.
[[noreturn]] void end_without_memory() {
  try {
    if (std::current_exception()) throw;
  } catch (const std::bad_alloc&) {
    constexpr std::string_view message = "viscobar: there is not enough memory\n";
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, message.data(), message.size());
    std::_Exit(run_failed);
  } catch (...) {
  }
  std::abort();
}

}  // namespace

}  // namespace viscobar::cli

int main(int argc, char** argv) {
  using namespace viscobar;
  cli::open_standard_streams();
  // A limit on file sizes is an error like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  std::set_terminate(cli::end_without_memory);
  try {
    return cli::end_messages(cli::run(argc, argv));
  } catch (const SceneError& error) {
    for (const Diagnostic& diagnostic : error.diagnostics) cli::say(diagnostic.text());
    return cli::end_messages(cli::wrong_input);
  } catch (const std::invalid_argument& error) {
    cli::complain(error.what());
    return cli::end_messages(cli::wrong_input);
  } catch (const std::bad_alloc&) {
    cli::complain("there is not enough memory");
    return cli::end_messages(cli::run_failed);
  } catch (const std::exception& error) {
    cli::complain(error.what());
    return cli::end_messages(cli::run_failed);
  } catch (...) {  // muParser's are none of the above; a formula that has been understood fails for want of memory only
    cli::complain("a formula cannot be evaluated");
    return cli::end_messages(cli::run_failed);
  }
}
