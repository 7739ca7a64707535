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
#include "results/sweep_frame.hpp"
#include "text/printable_text.hpp"
#include "text/table.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;
/// A kind of result, its summary, and the facts that are worth knowing: NAME, which with spaces is its name on the
/// terminal, of a member of the summary, or NAME=PATH.
struct Kind {
  std::string_view name, summary, facts;
};

constexpr std::string_view of_run =
    "title method elements=/scene/mesh/elements mass epsilon=/scene/contact/epsilon completed error reached_time "
    "end_time=/scene/time/end output_every=/scene/output/every steps contact_changes=/events "
    "largest_penetration=/max_penetration energy_initial=/energy/initial energy_final=/energy/final "
    "energy_balance_error=/energy/balance_error integration_seconds wall_seconds version=/versions/viscobar";

constexpr Kind kinds[] = {
    {"run", "summary.json", of_run},
    {"compare", "compare.json",
     "title methods=/methods/*/method reference completed left_out=/skipped/# "
     "nearest_to_reference=/pairs/<end_trace/other its_end_difference=/pairs/<end_trace/end_trace version"},
    {"limit", "limit.json",
     "title mass elements=/rows/*/elements rows=/rows/# completed verdict reason order_penetration order_to_rigid "
     "order_to_scheme version"},
    {"precision", "precision.json",
     "title methods=/rows/*/method elements=/rows/*/elements rows=/rows/# completed reference=/reference/description "
     "reference_error=/reference/error smallest_error=/rows/<error/error by=/rows/<error/method "
     "with=/rows/<error/label in_seconds=/rows/<error/seconds version"},
    {"sweep", "sweep.h5", "title keys failed=/failed/# integration_seconds wall_seconds"},
    {"fit", "fit.json", "title parameters=/parameters/@ measured converged runs residual version"},
    {"judge", "judge.json", "title judged=/judged/*/label missed=/judged/*/missed made_up=/judged/*/made_up version"},
    {"run", "unfinished/summary.json", of_run},  // beside a whole one
};

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

Json facts(const Kind& kind, fs::path file) {
  Json result = {{"kind", kind.name}, {"file", kind.summary}};
  if (kind.name == "sweep") {  // may be under way: its summary comes at the end
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
    for (const std::string_view fact : split(kind.facts, ' ')) {
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
  if (kind.name == "sweep") result["completed"] = result["remaining"] == 0 && result["failed"] == 0;
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
  std::string names;
  for (const Kind& kind : kinds) names += fmt::format("{}{}", names.empty() ? "" : ", ", kind.summary);
  if (!fs::exists(place)) throw std::invalid_argument(fmt::format("{} does not exist", place.string()));
  const bool one_file = !fs::is_directory(place);
  const fs::path directory = !one_file ? place : place.has_parent_path() ? place.parent_path() : fs::path(".");
  settle_result_directory(directory);
  Json results = Json::array();
  for (const Kind& kind : kinds)
    if ((!one_file || place.filename() == kind.summary) && fs::exists(directory / kind.summary))
      results.push_back(facts(kind, directory / kind.summary));
  if (results.empty())
    throw std::invalid_argument(
        one_file ? fmt::format("{} is none of {}", place.string(), names)
                 : fmt::format("{} holds no result of viscobar (none of {})", directory.string(), names));
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
