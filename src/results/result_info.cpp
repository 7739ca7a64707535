#include "results/result_info.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <span>
#include <stdexcept>

#include "results/json.hpp"
#include "results/result_directory.hpp"
#include "results/sweep_frame.hpp"
#include "text/printable_text.hpp"
#include "text/table.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;
using Pointer = Json::json_pointer;

/// One thing worth knowing: its name in JSON, which with spaces is its name on the terminal, and how a summary tells
/// it.
struct Fact {
  std::string_view name;
  Json (*value)(const Json& summary);
};

Json at(const Json& summary, const char* pointer) { return summary.value(Pointer(pointer), Json(nullptr)); }

/// The row of a list whose member is smallest; null where no row has one.
Json smallest(const Json& rows, const char* member) {
  const Json* best = nullptr;
  for (const Json& row : rows)
    if (row[member].is_number() && (!best || row[member] < (*best)[member])) best = &row;
  return best ? *best : Json(nullptr);
}

Json each(const Json& rows, const char* member) {
  Json values = Json::array();
  for (const Json& row : rows)
    if (std::find(values.begin(), values.end(), row[member]) == values.end()) values.push_back(row[member]);
  return values;
}

Json named(const Json& row) {
  return row.is_null() ? row : Json(row["method"].get<std::string>() + ", " + row["label"].get<std::string>());
}

constexpr Fact run_facts[] = {
    {"title", [](const Json& s) { return at(s, "/title"); }},
    {"method", [](const Json& s) { return at(s, "/method"); }},
    {"elements", [](const Json& s) { return at(s, "/scene/mesh/elements"); }},
    {"mass", [](const Json& s) { return at(s, "/mass"); }},
    {"epsilon", [](const Json& s) { return at(s, "/scene/contact/epsilon"); }},
    {"completed", [](const Json& s) { return at(s, "/completed"); }},
    {"error", [](const Json& s) { return at(s, "/error"); }},
    {"reached_time", [](const Json& s) { return at(s, "/reached_time"); }},
    {"end_time", [](const Json& s) { return at(s, "/scene/time/end"); }},
    {"output_every", [](const Json& s) { return at(s, "/scene/output/every"); }},
    {"steps", [](const Json& s) { return at(s, "/steps"); }},
    {"contact_changes", [](const Json& s) { return at(s, "/events"); }},
    {"largest_penetration", [](const Json& s) { return at(s, "/max_penetration"); }},
    {"energy_initial", [](const Json& s) { return at(s, "/energy/initial"); }},
    {"energy_final", [](const Json& s) { return at(s, "/energy/final"); }},
    {"energy_balance_error", [](const Json& s) { return at(s, "/energy/balance_error"); }},
    {"integration_seconds", [](const Json& s) { return at(s, "/integration_seconds"); }},
    {"wall_seconds", [](const Json& s) { return at(s, "/wall_seconds"); }},
    {"version", [](const Json& s) { return at(s, "/versions/viscobar"); }},
};

constexpr Fact compare_facts[] = {
    {"title", [](const Json& s) { return at(s, "/title"); }},
    {"methods", [](const Json& s) { return each(s["methods"], "method"); }},
    {"reference", [](const Json& s) { return at(s, "/reference"); }},
    {"completed", [](const Json& s) { return at(s, "/completed"); }},
    {"left_out", [](const Json& s) { return Json(s["skipped"].size()); }},
    {"nearest_to_reference", [](const Json& s) { return at(smallest(s["pairs"], "end_trace"), "/other"); }},
    {"its_end_difference", [](const Json& s) { return at(smallest(s["pairs"], "end_trace"), "/end_trace"); }},
    {"version", [](const Json& s) { return at(s, "/version"); }},
};

constexpr Fact limit_facts[] = {
    {"title", [](const Json& s) { return at(s, "/title"); }},
    {"mass", [](const Json& s) { return at(s, "/mass"); }},
    {"elements", [](const Json& s) { return each(s["rows"], "elements"); }},
    {"rows", [](const Json& s) { return Json(s["rows"].size()); }},
    {"completed", [](const Json& s) { return Json(s["failed"].empty()); }},
    {"verdict", [](const Json& s) { return at(s, "/verdict"); }},
    {"reason", [](const Json& s) { return at(s, "/reason"); }},
    {"order_penetration", [](const Json& s) { return at(s, "/order_penetration"); }},
    {"order_to_rigid", [](const Json& s) { return at(s, "/order_to_rigid"); }},
    {"order_to_scheme", [](const Json& s) { return at(s, "/order_to_scheme"); }},
    {"version", [](const Json& s) { return at(s, "/version"); }},
};

constexpr Fact fit_facts[] = {
    {"title", [](const Json& s) { return at(s, "/title"); }},
    {"parameters",
     [](const Json& s) {
       Json names = Json::array();
       for (const auto& [key, value] : s["parameters"].items()) names.push_back(key);
       return names;
     }},
    {"measured", [](const Json& s) { return at(s, "/measured"); }},
    {"converged", [](const Json& s) { return at(s, "/converged"); }},
    {"runs", [](const Json& s) { return at(s, "/runs"); }},
    {"residual", [](const Json& s) { return at(s, "/residual"); }},
    {"version", [](const Json& s) { return at(s, "/version"); }},
};

constexpr Fact judge_facts[] = {
    {"title", [](const Json& s) { return at(s, "/title"); }},
    {"judged", [](const Json& s) { return each(s["judged"], "label"); }},
    {"missed", [](const Json& s) { return each(s["judged"], "missed"); }},
    {"made_up", [](const Json& s) { return each(s["judged"], "made_up"); }},
    {"version", [](const Json& s) { return at(s, "/version"); }},
};

constexpr Fact precision_facts[] = {
    {"title", [](const Json& s) { return at(s, "/title"); }},
    {"methods", [](const Json& s) { return each(s["rows"], "method"); }},
    {"elements", [](const Json& s) { return each(s["rows"], "elements"); }},
    {"rows", [](const Json& s) { return Json(s["rows"].size()); }},
    {"completed", [](const Json& s) { return Json(each(s["rows"], "failure") == Json::array({nullptr})); }},
    {"reference", [](const Json& s) { return at(s, "/reference/description"); }},
    {"reference_error", [](const Json& s) { return at(s, "/reference/error"); }},
    {"smallest_error", [](const Json& s) { return at(smallest(s["rows"], "error"), "/error"); }},
    {"by", [](const Json& s) { return named(smallest(s["rows"], "error")); }},
    {"in_seconds", [](const Json& s) { return at(smallest(s["rows"], "error"), "/seconds"); }},
    {"version", [](const Json& s) { return at(s, "/version"); }},
};

struct Kind {
  std::string_view name, summary;
  std::span<const Fact> facts;  // none: the summary is the table of a sweep
};

constexpr Kind kinds[] = {
    {"run", "summary.json", run_facts},
    {"compare", "compare.json", compare_facts},
    {"limit", "limit.json", limit_facts},
    {"precision", "precision.json", precision_facts},
    {"sweep", "sweep.h5", {}},
    {"fit", "fit.json", fit_facts},
    {"judge", "judge.json", judge_facts},
    {"run", "unfinished/summary.json", run_facts},  // beside a whole one
};

Json facts(const Kind& kind, const fs::path& file) {
  Json result = {{"kind", kind.name}, {"file", kind.summary}};
  if (kind.facts.empty()) {
    result.update(sweep_facts(file));
    return result;
  }
  std::ifstream stream(file);
  if (!stream) throw IoError(file, "cannot be read");
  try {
    const Json summary = Json::parse(stream);
    for (const Fact& fact : kind.facts)
      if (Json value = fact.value(summary); !value.is_null()) result[fact.name] = std::move(value);
  } catch (const Json::exception& error) {
    throw IoError(file, fmt::format("is no summary of viscobar: {}", error.what()));
  }
  return result;
}

// Bytes of a file, or of all files below a directory.
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

// Counts and ranges, line by line below the facts.
std::string sweep_text(const Json& result) {
  std::string text;
  for (const Json& error : result["errors"])
    text += fmt::format("  {} failed: {}\n", words(error["rows"]), words(error["text"]));
  Table table{{"column", "rows", "from", "to"}, 1, {}};
  for (const Json& column : result["columns"]) {
    if (const auto values = column.find("values"); values != column.end()) {
      for (const Json& value : *values)
        table.rows.push_back(
            {fmt::format("{} = {}", words(column["name"]), words(value["text"])), words(value["rows"]), "", ""});
    } else if (column["rows"] != 0) {
      table.rows.push_back({words(column["name"]), words(column["rows"]), words(column["from"]), words(column["to"])});
    }
  }
  return text + "\n" + viscobar::text(table);
}

}  // namespace

std::string result_json(const fs::path& place) { return json_text(describe(place)); }

std::string result_text(const fs::path& place) {
  const Json described = describe(place);
  std::string text;
  for (const Json& result : described["results"]) {
    text += fmt::format("{}: {}\n", words(described["directory"]), words(result["kind"]));
    for (const auto& [name, value] : result.items()) {
      if (name == "kind" || name == "file" || name == "errors" || name == "columns") continue;
      std::string label = name;
      std::replace(label.begin(), label.end(), '_', ' ');
      text += fmt::format("  {:<20} {}\n", label, words(value));
    }
    if (result.contains("columns")) text += sweep_text(result);
    text += "\n";
  }
  Table table{{"file", "size"}, 1, {}};
  for (const Json& file : described["files"])
    table.rows.push_back({words(file["name"]), byte_number(file["bytes"].get<double>())});
  return text + viscobar::text(table);
}

}  // namespace viscobar
