#include <memory>
#include <regex>
#include <string_view>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "input/scene_keys.hpp"

namespace viscobar::cli {

namespace {

/// Completions of the values of an option in a shell, by their kind.
struct Completions {
  std::string_view keys, scene, directory, file, other;

  std::string_view of(const OptionText& option) const {
    if (option.repeatable) return keys;
    return option.type == "SCENE" ? scene : option.type == "DIR" ? directory : option.type == "FILE" ? file : other;
  }
};

/// Shell commands that fill COMPREPLY with what an option or argument may be; empty where nothing is known.
std::string bash_action(const OptionText& option) {
  constexpr Completions bash{"_viscobar_keys", "_viscobar_scenes", "_viscobar_files -d", "_viscobar_files -f", ":"};
  if (option.type.empty()) return "";
  const std::string words = option.words();
  return words.empty() ? std::string(bash.of(option))
                       : fmt::format("_viscobar_{} \"{}\"", option.takes_list() ? "list" : "words", words);
}

std::string bash_case(const CLI::App& command) {
  std::string options, argument = ":", lines;
  for (const OptionText& option : options_of(command)) {
    const std::string action = bash_action(option);
    if (option.is_argument()) {
      argument = action;
      continue;
    }
    for (const std::string& name : option.names) options += " " + name;
    if (!action.empty()) lines += fmt::format("        {}) {}; return ;;\n", fmt::join(option.names, "|"), action);
  }
  return fmt::format(
      "    {})\n      case $before in\n{}      esac\n"
      "      if [[ $word == -* ]]; then _viscobar_words \"{}\"; else {}; fi ;;\n",
      command.get_name(), lines, options.substr(1), argument);
}

std::string bash_completion(const CLI::App& app) {
  std::string names, cases, keys, values;
  for (const CLI::App* command : app.get_subcommands({})) {
    names += command->get_name() + " ";
    cases += bash_case(*command);
  }
  for (const SceneKey& key : scene_keys()) {
    keys += fmt::format("{}= ", key.name);
    if (!key.choices.empty())
      values += fmt::format("    {}) _viscobar_words \"{}\" ;;\n", key.name, fmt::join(key.choice_names(), " "));
  }
  keys.pop_back();
  return fmt::format(R"(# bash completion of viscobar; made by: viscobar completion bash
_viscobar_words() {{ COMPREPLY=($(compgen -W "$1" -- "$word")); }}
_viscobar_list() {{  # words with commas between them
  local done=
  [[ $word == *,* ]] && done=${{word%,*}},
  COMPREPLY=($(compgen -P "$done" -W "$1" -- "${{word##*,}}"))
}}
_viscobar_files() {{
  local IFS=$'\n'
  compopt -o filenames 2>/dev/null
  COMPREPLY=($(compgen "$1" -- "$word"))
}}
_viscobar_scenes() {{
  local IFS=$'\n'
  compopt -o filenames 2>/dev/null
  COMPREPLY=($(compgen -d -- "$word"; compgen -f -X '!*.toml' -- "$word"))
}}
_viscobar_keys() {{
  compopt -o nospace 2>/dev/null
  _viscobar_words "{keys}"
}}
_viscobar_value() {{  # of the key $1; bash takes "=" for a word of its own
  [[ $word == = ]] && word=
  case $1 in
{values}  esac
}}
_viscobar() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}}
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    _viscobar_words "{names}--help --version -V"
    return
  fi
  if [[ $word == = ]]; then
    _viscobar_value "$before"
    return
  elif [[ $before == = ]]; then
    _viscobar_value "${{COMP_WORDS[COMP_CWORD - 2]}}"
    return
  fi
  case ${{COMP_WORDS[1]}} in
{cases}  esac
}}
complete -F _viscobar viscobar
)",
                     fmt::arg("keys", keys), fmt::arg("values", values), fmt::arg("names", names),
                     fmt::arg("cases", cases));
}

// A word quoted for fish, in which a backslash and a quote stand for themselves.
std::string fish_quoted(const std::string& text) {
  return "'" + std::regex_replace(text, std::regex(R"(['\\])"), R"(\$&)") + "'";
}

std::string fish_completion(const CLI::App& app) {
  constexpr Completions fish{"-x -a \"$__viscobar_keys\"", "-k -x -a '(__fish_complete_suffix .toml)'",
                             "-x -a '(__fish_complete_directories)'", "-r -F", "-x"};
  std::string lines, keys;
  for (const SceneKey& key : scene_keys()) {
    if (key.choices.empty() || key.type == KeyType::list) keys += fmt::format("{}= ", key.name);
    if (key.type == KeyType::choice)
      for (const std::string_view word : key.choice_names()) keys += fmt::format("{}={} ", key.name, word);
  }
  keys.pop_back();
  for (const CLI::App* command : app.get_subcommands({})) {
    lines += fmt::format("complete -c viscobar -n __fish_use_subcommand -f -a {} -d {}\n", command->get_name(),
                         fish_quoted(command->get_description()));
    for (const OptionText& option : options_of(*command)) {
      const std::string words = option.words();
      const std::string action = option.type.empty() ? "-f"
                                 : words.empty()     ? std::string(fish.of(option))
                                                     : "-x -a " + fish_quoted(words);
      std::string names;
      for (const std::string& name : option.names)
        names += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      lines += fmt::format("complete -c viscobar -n '__fish_seen_subcommand_from {}'{} {} -d {}\n", command->get_name(),
                           names, action, fish_quoted(option.description));
    }
  }
  return fmt::format(
      "# fish completion of viscobar; made by: viscobar completion fish\ncomplete -c viscobar -f\n"
      "set -g __viscobar_keys {}\n{}",
      fish_quoted(keys), lines);
}

}  // namespace

Action completion_command(CLI::App& command) {
  const auto shell = std::make_shared<std::string>();
  add(command, "shell", "bash|fish", *shell, "The shell")->required();
  return [shell, &app = *command.get_parent()] {
    if (*shell != "bash" && *shell != "fish")
      refuse("completion: there is none for {}, only for bash and fish", *shell);
    print(*shell == "bash" ? bash_completion(app) : fish_completion(app));
    return success;
  };
}

}  // namespace viscobar::cli
