#include <fmt/format.h>

#include <stdexcept>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "input/scene_keys.hpp"

namespace viscobar::cli {

namespace {

/// Shell commands that fill COMPREPLY with what an option or argument may be; empty where nothing is known.
std::string bash_action(const OptionText& option) {
  if (const auto words = option.words(); !words.empty())
    return fmt::format("_viscobar_{} \"{}\"", option.type.find(',') == std::string::npos ? "words" : "list",
                       fmt::join(words, " "));
  if (option.repeatable) return "_viscobar_keys";
  if (option.type == "SCENE") return "_viscobar_scenes";
  if (option.type == "DIR") return "_viscobar_files -d";
  if (option.type == "FILE") return "_viscobar_files -f";
  return option.type.empty() ? "" : ":";
}

std::string bash_case(const CommandText& command) {
  std::string options, argument = ":", lines;
  for (const OptionText& option : command.options) {
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
      command.name, lines, options.substr(1), argument);
}

/// What a description may hold in an argument of zsh's _arguments, within single quotes.
std::string zsh_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\'')
      out += "'\\''";
    else if (c == '[' || c == ']' || c == ':' || c == '\\')
      out += fmt::format("\\{}", c);
    else
      out += c;
  }
  return out;
}

std::string zsh_action(const OptionText& option) {
  if (const auto words = option.words(); !words.empty()) {
    const std::string known = fmt::format("{}", fmt::join(words, " "));
    return option.type.find(',') == std::string::npos ? "(" + known + ")" : "_sequence compadd - " + known;
  }
  if (option.repeatable) return "_viscobar_keys";
  if (option.type == "SCENE") return "_files -g \"*.toml\"";
  if (option.type == "DIR") return "_files -/";
  return option.type == "FILE" ? "_files" : " ";
}

std::string zsh_spec(const OptionText& option) {
  const std::string value = option.type.empty() ? "" : fmt::format(":{}:{}", zsh_text(option.type), zsh_action(option));
  // An optional argument has two colons.
  if (option.is_argument()) return fmt::format("'1{}{}'", option.required ? "" : ":", value);
  const std::string description = fmt::format("[{}]", zsh_text(option.description));
  if (option.repeatable) return fmt::format("'*{}{}{}'", option.names.front(), description, value);
  if (option.names.size() == 1) return fmt::format("'{}{}{}'", option.names.front(), description, value);
  return fmt::format("'({})'{{{}}}'{}{}'", fmt::join(option.names, " "), fmt::join(option.names, ","), description,
                     value);
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
  std::string names, cases, keys, values;
  for (const CommandText& command : command_texts(app)) {
    names += command.name + " ";
    cases += bash_case(command);
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

std::string zsh_completion(const CLI::App& app) {
  std::string commands, cases, keys, values;
  for (const CommandText& command : command_texts(app)) {
    commands += fmt::format("    '{}:{}'\n", command.name, zsh_text(command.description));
    cases += fmt::format("    {})\n      _arguments", command.name);
    for (const OptionText& option : command.options) cases += fmt::format(" \\\n        {}", zsh_spec(option));
    cases += " ;;\n";
  }
  for (const SceneKey& key : scene_keys()) {
    keys += fmt::format(" {}", key.name);
    if (!key.choices.empty())
      values += fmt::format("    {}) compadd - {} ;;\n", key.name, fmt::join(key.choice_names(), " "));
  }
  return fmt::format(R"(#compdef viscobar
# zsh completion of viscobar; made by: viscobar completion zsh
_viscobar_keys() {{
  if compset -P '*='; then
    case ${{IPREFIX%=}} in
{values}    esac
  else
    compadd -S = -{keys}
  fi
}}
_viscobar() {{
  local -a commands
  commands=(
{commands}  )
  if ((CURRENT == 2)); then
    _describe -t commands command commands
    _arguments '--help[Print this help and exit]' '(-V --version)'{{-V,--version}}'[Print the versions and exit]'
    return
  fi
  shift words
  ((CURRENT--))
  case $words[1] in
{cases}  esac
}}
if [[ $zsh_eval_context[-1] == loadautofunc ]]; then _viscobar "$@"; else compdef _viscobar viscobar; fi
)",
                     fmt::arg("keys", keys), fmt::arg("values", values), fmt::arg("commands", commands),
                     fmt::arg("cases", cases));
}

// Of fish: a quoted word, in which a backslash and a quote stand for themselves.
static std::string fish_quoted(std::string_view text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out + "'";
}

std::string fish_completion(const CLI::App& app) {
  std::string lines, keys;
  for (const SceneKey& key : scene_keys()) {
    if (key.choices.empty() || key.type == KeyType::list) keys += fmt::format("{}= ", key.name);
    if (key.type == KeyType::choice)
      for (const std::string_view word : key.choice_names()) keys += fmt::format("{}={} ", key.name, word);
  }
  keys.pop_back();
  for (const CommandText& command : command_texts(app)) {
    lines += fmt::format("complete -c viscobar -n __fish_use_subcommand -f -a {} -d {}\n", command.name,
                         fish_quoted(command.description));
    for (const OptionText& option : command.options) {
      const auto words = option.words();
      std::string action = "-f";
      if (!words.empty())
        action = fmt::format("-x -a {}", fish_quoted(fmt::format("{}", fmt::join(words, " "))));
      else if (option.repeatable)
        action = "-x -a \"$__viscobar_keys\"";
      else if (option.type == "SCENE")
        action = "-k -x -a '(__fish_complete_suffix .toml)'";
      else if (option.type == "DIR")
        action = "-x -a '(__fish_complete_directories)'";
      else if (!option.type.empty())
        action = option.type.find("FILE") == std::string::npos ? "-x" : "-r -F";
      std::string names;
      for (const std::string& name : option.names)
        names += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      lines += fmt::format("complete -c viscobar -n '__fish_seen_subcommand_from {}'{} {} -d {}\n", command.name, names,
                           action, fish_quoted(option.description));
    }
  }
  return fmt::format(
      "# fish completion of viscobar; made by: viscobar completion fish\ncomplete -c viscobar -f\n"
      "set -g __viscobar_keys {}\n{}",
      fish_quoted(keys), lines);
}

CompletionCommand::CompletionCommand(CLI::App& app)
    : Command(app, "completion", "Print the completions for a shell"), app_(app) {
  command_.add_option("shell", shell_, "The shell")->required()->type_name("bash|zsh|fish");
}

int CompletionCommand::operator()() const {
  if (shell_ != "bash" && shell_ != "zsh" && shell_ != "fish")
    throw std::invalid_argument(fmt::format("completion: there is none for {}, only for bash, zsh and fish", shell_));
  print(shell_ == "bash" ? bash_completion(app_) : shell_ == "zsh" ? zsh_completion(app_) : fish_completion(app_));
  return success;
}

}  // namespace viscobar::cli
