#include "input/trace_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "input/input_text.hpp"
#include "text/nearest_name.hpp"
#include "text/number.hpp"
#include "text/printable_text.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {

namespace {

std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells;
  for (const std::string_view cell : split(line, ',')) cells.emplace_back(trimmed(cell));
  return cells;
}

bool contains(const std::vector<std::string>& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

}  // namespace

const TraceFile::Column* TraceFile::column(std::string_view name) const {
  const auto found = std::ranges::find(columns, name, &Column::name);
  return found == columns.end() ? nullptr : &*found;
}

TraceFile read_traces(const std::filesystem::path& file, const std::vector<std::string>& known,
                      const std::vector<std::string>& required, const std::vector<std::string>& words) {
  const std::string text = input_text(file);
  TraceFile table;
  std::vector<Diagnostic> found;
  constexpr std::size_t most_faults = 20;
  const auto report = [&](std::size_t line, std::size_t column, const std::string& key, const std::string& what) {
    if (found.size() < most_faults) found.push_back({file.string(), line, column, one_line(key), one_line(what)});
  };
  std::size_t number = 0;
  std::vector<std::size_t> number_of_row;
  std::string_view lines = text;
  if (lines.ends_with('\n')) lines.remove_suffix(1);
  for (const std::string_view line : split(lines, '\n')) {
    ++number;
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() == 1 && cells.front().empty()) continue;
    if (table.columns.empty()) {
      for (std::size_t k = 0; k < cells.size(); ++k) {
        const auto nearest = nearest_name(cells[k], known);
        if (!contains(known, cells[k]))
          report(number, k + 1, cells[k],
                 nearest ? fmt::format("unknown column; nearest is \"{}\"", *nearest)
                         : fmt::format("unknown column; known are {}", fmt::join(known, ", ")));
        else if (table.column(cells[k]))
          report(number, k + 1, cells[k], "is there twice");
        table.columns.push_back({cells[k], {}, {}});
      }
      for (const std::string& name : required)
        if (!table.column(name)) report(number, 1, name, "is missing: the first line names the columns");
      continue;
    }
    if (cells.size() != table.columns.size()) {
      report(number, 1, "", fmt::format("has {} values for {} columns", cells.size(), table.columns.size()));
      continue;
    }
    ++table.rows;
    number_of_row.push_back(number);
    for (std::size_t k = 0; k < cells.size(); ++k) {
      TraceFile::Column& column = table.columns[k];
      double value = std::numeric_limits<double>::quiet_NaN();
      const std::string& cell = cells[k];
      if (!contains(words, column.name) && !cell.empty()) {
        value = number_in<double>(std::string_view(cell).substr(cell.front() == '+' ? 1 : 0)).value_or(HUGE_VAL);
        if (std::isinf(value)) report(number, k + 1, column.name, fmt::format("\"{}\" is no number", cell));
      }
      column.cells.push_back(cell);
      column.values.push_back(value);
    }
  }
  if (found.empty() && table.rows == 0) report(number, 1, "", "holds no data");
  if (const auto* t = table.column("t"); t && found.empty())
    for (std::size_t k = 0; k < t->values.size(); ++k) {
      const std::string& cell = t->cells[k];
      if (!(t->values[k] >= 0.0))
        report(number_of_row[k], 1, "t", fmt::format("must be a time, not negative, is {}", cell));
      else if (k > 0 && t->values[k] < t->values[k - 1])
        report(number_of_row[k], 1, "t", fmt::format("must not fall, is {} after {}", cell, t->cells[k - 1]));
      if (!found.empty()) break;
    }
  if (!found.empty()) throw SceneError(std::move(found));
  return table;
}

}  // namespace viscobar
