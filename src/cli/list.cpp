#include <nlohmann/json.hpp>

#include "cli/commands.hpp"
#include "input/vocabulary.hpp"

namespace viscobar::cli {

namespace {

struct ListOptions {
  std::string what;
  bool json = false, markdown = false;
};

std::vector<Vocabulary> chosen_lists(const std::string& word) {
  if (word.empty()) return {std::begin(all_vocabularies), std::end(all_vocabularies)};
  std::vector<std::string_view> known;
  for (const Vocabulary list : all_vocabularies) {
    if (name(list) == word) return {list};
    known.push_back(name(list));
  }
  refuse("list: there is no list of \"{}\"{}", word, instead_of(word, known, ", only of "));
}

/// For the terminal, where backquotes mean nothing and the table of the keys would be too wide.
std::string terminal_text(Vocabulary list) {
  if (list == Vocabulary::keys) {
    std::string lines;
    for (const SceneKey* key : listed_keys())
      lines += fmt::format("  {}\n      {}\n      {}\n", listed_name(*key), key->meaning, facts(*key));
    return lines;
  }
  Table table = vocabulary_table(list);
  for (auto& row : table.rows)
    for (std::string& cell : row) std::erase(cell, '`');
  return text(table);
}

}  // namespace

Action list_command(CLI::App& command) {
  const auto asked = std::make_shared<ListOptions>();
  add(command, "what", "methods|masses|keys", asked->what, "One of the lists (default: all of them)");
  add_json(command, asked->json);
  command.add_flag("--markdown", asked->markdown, "Print the tables of docs/scene-file.md")->excludes("--json");
  return [asked] {
    nlohmann::ordered_json json;
    std::string text;
    for (const Vocabulary list : chosen_lists(asked->what)) {
      if (!text.empty()) text += "\n";
      text += asked->markdown ? markdown(vocabulary_table(list)) : terminal_text(list);
      if (asked->json) json[name(list)] = nlohmann::ordered_json::parse(vocabulary_json(list));
    }
    print(asked->json ? json.dump(2) + "\n" : text);
    return success;
  };
}

}  // namespace viscobar::cli
