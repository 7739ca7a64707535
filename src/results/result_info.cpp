#include "results/result_info.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "input/described_scene.hpp"
#include "input/input_text.hpp"
#include "input/seal.hpp"
#include "results/json.hpp"
#include "results/output_file.hpp"
#include "results/result_directory.hpp"
#include "results/result_kind.hpp"
#include "results/sweep_frame.hpp"
#include "text/printable_text.hpp"
#include "text/table.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

// The value at a path, whose parts are the names of members; of a list # its length, * what its entries have behind
// it, each once, and <NAME the entry whose member is smallest; of an object @ the names. Null where there is none.
Json found(const Json& at, std::string_view path) {
  if (path.empty()) return at;
  const std::size_t end = std::min(path.find('/', 1), path.size());
  const std::string part(path.substr(1, end - 1));
  const std::string_view rest = path.substr(end);
  if (part == "#") return at.size();
  Json all = Json::array();
  if (part == "@")
    for (const auto& [name, value] : at.items()) all.push_back(name);
  if (part == "*")
    for (const Json& entry : at)
      if (Json value = found(entry, rest); std::ranges::find(all, value) == all.end()) all.push_back(std::move(value));
  if (part == "@" || part == "*") return all;
  if (part.starts_with('<')) {
    const std::string member = part.substr(1);
    const Json* least = nullptr;
    for (const Json& entry : at)
      if (entry[member].is_number() && (!least || entry[member] < (*least)[member])) least = &entry;
    return least ? found(*least, rest) : nullptr;
  }
  const auto member = at.find(part);
  return member == at.end() ? nullptr : found(*member, rest);
}

Json facts(const ResultFiles& files, const fs::path& directory, const std::string& first) {
  Json result = {{"kind", files.kind}, {"file", first}};
  fs::path file = directory / first;
  if (files.table()) {  // may be under way: its summary comes at the end
    const auto frame = SweepFrame::read(file);
    if (!frame) throw IoError(file, "is of a version that made no checksums");
    const std::size_t done = check_rows(file, *frame).done, cases = frame->cases();
    result.update({{"cases", cases}, {"done", done}, {"remaining", cases - done}, {"completed", false}});
    file.replace_extension("json");
    if (!fs::exists(file)) return result;
  }
  const std::string text = file_content(file);
  try {
    const Json summary = parsed_json(text, "is no JSON");
    if (seal_of(text) == Seal::broken) result["damaged"] = "its checksum is not the one that was written";
    for (const std::string_view fact : split(files.facts, ' ')) {
      const std::size_t equals = fact.find('=');
      const std::string name(fact.substr(0, equals));
      Json value = found(summary, equals == fact.npos ? "/" + name : std::string(fact.substr(equals + 1)));
      if (!value.is_null()) result[name] = std::move(value);
    }
  } catch (const TextError& error) {
    throw IoError(fmt::format("{}:{}:{}", file.string(), error.at.line, error.at.column), error.what());
  } catch (const Json::exception&) {
    throw IoError(file, "is JSON, and no summary of viscobar: its members are others");
  }
  if (files.table()) result["completed"] = result["remaining"] == 0 && result["failed"] == 0;
  return result;
}

std::uintmax_t bytes(const fs::directory_entry& entry) {
  if (!entry.is_directory()) return entry.file_size();
  std::uintmax_t sum = 0;
  for (const auto& below : fs::recursive_directory_iterator(entry.path()))
    if (below.is_regular_file()) sum += below.file_size();
  return sum;
}

Json files_in(const fs::path& directory) {
  const std::set<fs::directory_entry> entries(fs::directory_iterator(directory), fs::directory_iterator{});
  Json files = Json::array();
  for (const auto& entry : entries)
    if (entry.is_regular_file() || entry.is_directory())
      files.push_back(
          {{"name", entry.path().filename().string() + (entry.is_directory() ? "/" : "")}, {"bytes", bytes(entry)}});
  return files;
}

Json describe(const fs::path& place) {
  std::vector<std::string> names;
  for (const ResultFiles& files : result_kinds()) names.emplace_back(files.first);
  names.emplace_back("unfinished/summary.json");  // of a run, beside a whole one
  if (!fs::exists(place)) throw std::invalid_argument(fmt::format("{} does not exist", place.string()));
  const bool one_file = !fs::is_directory(place);
  const fs::path directory = !one_file ? place : place.has_parent_path() ? place.parent_path() : fs::path(".");
  settle_result_directory(directory);
  Json results = Json::array();
  for (std::size_t k = 0; k < names.size(); ++k)
    if ((!one_file || place.filename() == names[k]) && fs::exists(directory / names[k]))
      results.push_back(facts(result_kinds()[k % result_kinds().size()], directory, names[k]));
  if (results.empty())
    throw std::invalid_argument(one_file ? fmt::format("{} is none of {}", place.string(), fmt::join(names, ", "))
                                         : fmt::format("{} holds no result of viscobar (none of {})",
                                                       directory.string(), fmt::join(names, ", ")));
  return {{"directory", directory.string()}, {"results", results}, {"files", files_in(directory)}};
}

std::string words(const Json& value) {
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  if (value.is_string()) return one_line(value.get<std::string>());
  if (!value.is_array()) return value.dump();
  std::vector<std::string> parts;
  for (const Json& part : value) parts.push_back(words(part));
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace

std::string result_json(const fs::path& place) { return json_text(describe(place)); }

std::string result_text(const fs::path& place) {
  const Json described = describe(place);
  std::string text;
  for (const Json& result : described["results"]) {
    text += fmt::format("{}: {}\n", words(described["directory"]), words(result["kind"]));
    for (const auto& [name, value] : result.items()) {
      if (name == "kind" || name == "file") continue;
      std::string label = name;
      std::replace(label.begin(), label.end(), '_', ' ');
      text += fmt::format("  {:<20} {}\n", label, words(value));
    }
    text += "\n";
  }
  Table table{{"file", "size"}, 1, {}};
  for (const Json& file : described["files"])
    table.rows.push_back({words(file["name"]), byte_number(file["bytes"].get<double>())});
  return text + viscobar::text(table);
}

}  // namespace viscobar
