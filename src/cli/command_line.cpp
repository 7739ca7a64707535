#include "cli/command_line.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "input/scene_keys.hpp"

namespace viscobar::cli {

namespace {

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

std::string OptionText::words() const {
  const auto has = [&](const char* name) { return std::ranges::find(names, name) != names.end(); };
  if (const char* key = has("--mass") ? "mesh.mass" : has("--methods") ? "method.name" : nullptr)
    return fmt::format("{}", fmt::join(find_scene_key(key)->choice_names(), " "));
  if (type.find('|') == type.npos) return "";
  std::string words = type;
  std::ranges::replace(words, '|', ' ');
  return words;
}

std::vector<OptionText> options_of(const CLI::App& command) {
  std::vector<OptionText> options;
  for (const CLI::Option* option : command.get_options()) options.push_back(text_of(*option));
  return options;
}

}  // namespace viscobar::cli
