#include "cli/command_line.hpp"

#include <algorithm>

#include "input/input_text.hpp"
#include "input/scene_keys.hpp"

namespace viscobar::cli {

namespace {

std::vector<std::string> choices_of(const char* key) {
  const auto names = find_scene_key(key)->choice_names();
  return {names.begin(), names.end()};
}

OptionText text_of(const CLI::Option& option) {
  OptionText text;
  for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
  if (option.get_expected_max() > 0 && option.get_type_size_max() > 0) text.type = option.get_type_name();
  text.description = option.get_description();
  text.fallback = option.get_default_str();
  text.required = option.get_required();
  text.repeatable = text.type == "TABLE.KEY=VALUE";
  return text;
}

}  // namespace

std::vector<std::string> OptionText::words() const {
  if (std::find(names.begin(), names.end(), "--mass") != names.end()) return choices_of("mesh.mass");
  if (std::find(names.begin(), names.end(), "--methods") != names.end()) return choices_of("method.name");
  if (type.find('|') == type.npos) return {};
  const auto words = split(type, '|');
  return {words.begin(), words.end()};
}

std::vector<CommandText> command_texts(const CLI::App& app) {
  std::vector<CommandText> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App* one) { return !one->get_group().empty(); })) {
    CommandText text{command->get_name(), command->get_description(), {}};
    for (const CLI::Option* option : command->get_options()) text.options.push_back(text_of(*option));
    commands.push_back(std::move(text));
  }
  return commands;
}

}  // namespace viscobar::cli
