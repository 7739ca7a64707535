#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <new>
#include <sstream>

#include "cli/commands.hpp"
#include "input/scene_keys.hpp"
#include "results/directory_lock.hpp"
#include "results/output_file.hpp"
#include "text/nearest_name.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar::cli {

namespace {

constexpr struct {
  const char *name, *description;
  Action (*add_options)(CLI::App& command);
} commands[] = {
    {"run", "Run a scene and write its results and a report with pictures", run_command},
    {"resume", "Continue a run that was stopped, from its last checkpoint", resume_command},
    {"check", "Validate a scene, describe its model and predict its first impacts", check_command},
    {"compare", "Run a scene by several methods and report their differences", compare_command},
    {"limit",
     "Study how the penalised bar tends to the fully discrete scheme as epsilon goes to 0: penetration, differences, "
     "orders, verdict",
     limit_command},
    {"precision",
     "Measure time against error for the methods that fit the scene, and split the error into space, penalty and time",
     precision_command},
    {"fit", "Fit values of a scene to measured traces and contact times, by least squares", fit_command},
    {"sweep",
     "Run a scene for many values of its keys, on all cores, or under mpirun on many machines; the same command goes "
     "on with a sweep that was stopped",
     sweep_command},
    {"list", "List the methods, the masses and the keys of a scene file", list_command},
    {"new", "Write a commented scene to start from", new_command},
    {"info", "List the contents of a directory of results, or of one summary", info_command},
    {"export", "Write the field and the end traces of a run as CSV or XDMF", export_command},
    {"help", "Print the help of a command", help_command},
};

/// Help in which an argument is SCENE, an option --starts N, and what has to be there or is the default stands behind
/// the meaning.
class HelpText : public CLI::Formatter {
  std::string make_option_name(const CLI::Option* option, bool positional) const override {
    return positional ? option->get_type_name() : CLI::Formatter::make_option_name(option, positional);
  }
  std::string make_option_opts(const CLI::Option* option) const override {
    return option->get_positional() || option->get_type_size() == 0 ? "" : " " + option->get_type_name();
  }
  std::string make_option_desc(const CLI::Option* option) const override {
    std::string text = option->get_description();
    if (option->get_required() && !option->get_positional()) text += " (required)";
    if (!option->get_default_str().empty()) text += fmt::format(" (default: {})", option->get_default_str());
    return text;
  }
};

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

/// The key of a scene that an option "--word" was meant to be: of that name, or of a name or table with a word that
/// begins so, such as --tol. Of several the one that has the value among its choices comes first.
const SceneKey* key_meant(std::string_view word, std::string_view value, bool whole) {
  const auto keys = scene_keys();
  const auto is_meant = [&](const SceneKey& key) {
    if (whole) return key.leaf() == word;
    const std::string name = "." + std::string(key.leaf());
    return word.size() > 2 &&
           (name.find("." + std::string(word)) != name.npos || name.find("_" + std::string(word)) != name.npos);
  };
  const auto has_value = [&](const SceneKey& key) {
    return is_meant(key) && std::ranges::find(key.choices, value, &Choice::name) != key.choices.end();
  };
  for (const auto found : {std::ranges::find_if(keys, has_value), std::ranges::find_if(keys, is_meant)})
    if (found != keys.end()) return &*found;
  return !whole && is_scene_table(word) ? find_scene_key(word, "name") : nullptr;
}

/// Suggestion for an unknown option: the option, or the key of the scene, that was probably meant.
std::string option_meant(const CLI::App& command, const std::string& option, std::string_view value) {
  const std::string word = plain_name(option.substr(option.find_first_not_of('-')));
  const bool takes_keys = command.get_option_no_throw("--set") != nullptr;
  const auto set = [](const SceneKey* key) {
    return fmt::format("; {0} is a key of the scene: --set {0}=VALUE", key->name);
  };
  if (const SceneKey* key = takes_keys ? key_meant(word, value, true) : nullptr) return set(key);
  std::vector<std::string> names = option_names(command);
  for (std::string& name : names) name.erase(0, 2);
  if (const auto nearest = nearest_name(word, names)) return fmt::format("; did you mean --{}?", *nearest);
  const auto begun = std::ranges::find_if(names, [&](const std::string& name) { return name.starts_with(word); });
  if (word.size() > 2 && begun != names.end()) return fmt::format("; did you mean --{}?", *begun);
  const SceneKey* key = takes_keys ? key_meant(word, value, false) : nullptr;
  return key ? set(key) : "";
}

std::string explanation(const CLI::App& app, const CLI::ParseError& error) {
  const auto chosen = app.get_subcommands();
  const CLI::App& command = chosen.empty() ? app : *chosen.front();
  if (!chosen.empty() && !app.remaining().empty())  // before the command, or behind --
    return fmt::format("unexpected argument {}", fmt::join(app.remaining(), " "));
  const std::vector<std::string> words = command.remaining();
  for (std::size_t k = 0; k < words.size(); ++k) {
    const std::string& word = words[k];
    const std::string bare = word.substr(0, word.find('='));
    const std::string value = bare != word ? word.substr(bare.size() + 1) : k + 1 < words.size() ? words[k + 1] : "";
    if (bare.starts_with('-')) return fmt::format("unknown option {}{}", bare, option_meant(command, bare, value));
    if (!chosen.empty()) return fmt::format("unexpected argument {}", word);
    std::vector<std::string> names = option_names(app);
    for (const CLI::App* known : app.get_subcommands({})) names.push_back(known->get_name());
    return fmt::format("unknown command {}{}", word, meant(word, names));
  }
  const std::string what = error.what();
  if (what.find("flag override") != what.npos)
    return fmt::format("--{} takes no value", what.substr(0, what.find(' ')));
  for (const CLI::Option* option : command.get_options())
    if (option->get_required() && option->count() == 0) return fmt::format("{} is required", option->get_name());
  if (!chosen.empty()) return what;
  std::vector<std::string_view> names;
  for (const auto& command_of_all : commands) names.push_back(command_of_all.name);
  return fmt::format("no command given; there are {}", fmt::join(names, ", "));
}

/// An option that took another one, or nothing, for its value: it was forgotten, or a variable of the shell was empty.
void check_values(const CLI::App& command, int argc, char** argv) {
  const auto option = [&](const char* word) { return word[0] == '-' ? command.get_option_no_throw(word) : nullptr; };
  for (int i = 2; i + 1 < argc && std::string_view(argv[i]) != "--"; ++i)
    if (const CLI::Option* taker = option(argv[i]); taker && taker->get_items_expected_max() > 0 && option(argv[i + 1]))
      refuse("{0} needs {1}, and {2} is an option; {0}={2} would take it for one", argv[i], taker->get_type_name(),
             argv[i + 1]);
  for (const CLI::Option* taker : command.get_options())
    if (!taker->get_positional() && taker->count() > 0 && taker->get_items_expected_max() > 0 &&
        std::ranges::any_of(taker->results(), [](const std::string& value) { return value.empty(); }))
      refuse("{}: is given no value", taker->get_name());
}

bool is_command(std::string_view word) {
  return std::ranges::any_of(commands, [&](const auto& command) { return command.name == word; });
}

/// True of a command that does not list the options of all: making those takes as long as a small run.
bool needs_no_other(std::string_view word) { return word != "help" && is_command(word); }

int run(int argc, char** argv) {
  CLI::App app("Motion of a viscoelastic bar against rigid obstacles", "viscobar");
  app.set_version_flag("-V,--version", version_text(), "Print the versions and exit");
  app.set_help_flag("-h,--help", "Print this help and exit");
  app.require_subcommand(1);
  app.formatter(std::make_shared<HelpText>());
  std::map<std::string, Action> actions;
  MessageOptions messages;
  const std::string_view called = argc > 1 ? argv[1] : "";
  for (const auto& [name, description, add_options] : commands) {
    CLI::App* const command = app.add_subcommand(name, description);
    if (needs_no_other(called) && name != called) continue;
    actions.emplace(name, add_options(*command));
    messages.add_to(*command);
    // A flag is given or not: --json=no would be read as --json.
    for (CLI::Option* option : command->get_options())
      if (option->get_expected_max() == 0) option->disable_flag_override();
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const bool known = called.empty() || called.starts_with('-') || is_command(called);
    if (error.get_exit_code() == success && known) {
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
  const CLI::App& chosen = *app.get_subcommands().front();
  check_values(chosen, argc, argv);
  messages.begin(argc, argv);
  end_on_interrupt();  // until a command has something to save
  try {
    return actions.at(chosen.get_name())();
  } catch (const DirectoryInUse& error) {
    if (!error.by_same_job) throw;
    // mpirun would end the one that does run.
    warn(fmt::format("{}; this process does nothing, for only sweep makes use of several", error.what()));
    return success;
  }
}

/// Where memory ends inside of what promised not to throw, as libraries do: with a message and without allocating one.
[[noreturn]] void end_without_memory() {
  // An exception that leaves a noexcept function may be gone here, as from those of std::filesystem.
  bool memory = !std::current_exception() && std::uncaught_exceptions() > 0;
  try {
    if (std::current_exception()) throw;
  } catch (const std::bad_alloc&) {
    memory = true;
  } catch (...) {
  }
  if (!memory) std::abort();
  constexpr std::string_view message = "viscobar: there is not enough memory\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, message.data(), message.size());
  std::_Exit(run_failed);
}

bool main_returns = false;

/// A library that ends the program itself, as HDF5 does where a table of its own cannot grow, does so without a word.
void end_by_library() {
  if (main_returns) return;
  constexpr std::string_view message = "viscobar: a library has ended the program: there may not be enough memory\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, message.data(), message.size());
  std::_Exit(run_failed);
}

}  // namespace

}  // namespace viscobar::cli

int main(int argc, char** argv) {
  using namespace viscobar;
  cli::open_standard_streams();
  // A limit on file sizes is an error like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  std::set_terminate(cli::end_without_memory);
  std::atexit(cli::end_by_library);
  int code = cli::run_failed;
  try {
    code = cli::run(argc, argv);
  } catch (const SceneError& error) {
    for (const Diagnostic& diagnostic : error.diagnostics) cli::say(diagnostic.text());
    code = cli::wrong_input;
  } catch (const std::invalid_argument& error) {
    cli::complain(error.what());
    code = cli::wrong_input;
  } catch (const std::bad_alloc&) {
    cli::complain("there is not enough memory");
  } catch (const std::filesystem::filesystem_error& error) {
    cli::complain(fmt::format("{}: cannot be used: {}", error.path1().string(), error.code().message()));
    if (error.code() == std::errc::filename_too_long) code = cli::wrong_input;
  } catch (const std::exception& error) {
    cli::complain(error.what());
  }
  code = cli::end_messages(code);
  if (hdf5_failed()) std::fflush(nullptr), std::_Exit(code);
  cli::main_returns = true;
  return code;
}
