#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "cli/commands.hpp"
#include "input/vocabulary.hpp"

namespace viscobar::cli {

namespace {

constexpr Vocabulary all[] = {Vocabulary::methods, Vocabulary::masses, Vocabulary::keys};

std::vector<Vocabulary> chosen_lists(const std::string& word) {
  if (word.empty()) return {std::begin(all), std::end(all)};
  std::vector<std::string_view> known;
  for (const Vocabulary list : all) {
    if (name(list) == word) return {list};
    known.push_back(name(list));
  }
  throw std::invalid_argument(
      fmt::format("list: there is no list of \"{}\"{}", word, instead_of(word, known, ", only of ")));
}

/// For the terminal, where backquotes mean nothing and the table of the keys would be too wide.
std::string terminal_text(Vocabulary list) {
  Table table = vocabulary_table(list);
  for (auto& row : table.rows)
    for (std::string& cell : row) std::erase(cell, '`');
  if (list != Vocabulary::keys) return text(table);
  std::string lines;
  for (const auto& row : table.rows) {
    const std::string unit = row[3].empty() || row[3] == "1" ? "" : "; unit: " + row[3];
    const std::string fallback = row[2].starts_with("required") || row[2] == "none" ? row[2] : "default " + row[2];
    lines += fmt::format("  {}\n      {}\n      {}; {}{}\n", row[0], row[4], row[1],
                         row[2] == "none" ? "no default" : fallback, unit);
  }
  return lines;
}

}  // namespace

ListCommand::ListCommand(CLI::App& app)
    : Command(app, "list", "List the methods, the masses and the keys of a scene file") {
  command_.add_option("what", what_, "One of the lists (default: all of them)")->type_name("methods|masses|keys");
  add_json(command_, json_);
  command_.add_flag("--markdown", markdown_, "Print the tables of docs/scene-file.md")->excludes("--json");
}

int ListCommand::operator()() const {
  nlohmann::ordered_json json;
  std::string text;
  for (const Vocabulary list : chosen_lists(what_)) {
    if (!text.empty()) text += "\n";
    text += markdown_ ? markdown(vocabulary_table(list)) : terminal_text(list);
    if (json_) json[name(list)] = nlohmann::ordered_json::parse(vocabulary_json(list));
  }
  print(json_ ? json.dump(2) + "\n" : text);
  return success;
}

}  // namespace viscobar::cli
