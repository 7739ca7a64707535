#include "report/measured.hpp"

#include <fmt/format.h>

#include <optional>
#include <stdexcept>
#include <string_view>

#include "input/described_scene.hpp"
#include "scene/unit_names.hpp"
#include "text/number.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar {

namespace {

Event change_of(const std::string& file, double t, const std::string& where, const std::string& change) {
  Event event;
  event.time = t;
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(fmt::format("{}: at t = {}: {}", file, t, what));
  };
  if (where == "left" || where == "right") {
    event.where = where == "left" ? Where::left : Where::right;
  } else if (where.starts_with("span:")) {
    event.where = Where::span;
    const auto node = number_in<std::size_t>(std::string_view(where).substr(5));
    if (!node) refuse(fmt::format("where is \"{}\", and no number of a node is behind span:", where));
    event.node = *node;
  } else if (where.starts_with("joint:")) {
    event.where = Where::joint;
    const auto number = number_in<std::size_t>(std::string_view(where).substr(6));
    if (!number || *number == 0)
      refuse(fmt::format("where is \"{}\", and no number of a joint is behind joint:", where));
    event.node = *number;
  } else {
    refuse(fmt::format("where is \"{}\", not left, right, span:NODE or joint:NUMBER", where));
  }
  if (change != "closing" && change != "opening")
    refuse(fmt::format("change is \"{}\", not closing or opening", change));
  event.change = change == "closing" ? Change::closing : Change::opening;
  return event;
}

UnitPowers unit_of(TraceColumn column) {
  constexpr std::optional<Dimension> dimensions[] = {
      Dimension::length, Dimension::velocity, Dimension::force,    Dimension::length, Dimension::velocity,
      Dimension::force,  Dimension::length,   Dimension::velocity, std::nullopt,      Dimension::stress,
      Dimension::length, Dimension::length,   Dimension::force};
  const auto dimension = dimensions[static_cast<std::size_t>(column)];
  return dimension ? unit_powers(*dimension) : UnitPowers{};
}

// Values in the unit of the scene, where both have one. No unit is told that the scene has not named.
void convert(TraceFile& table, TraceFile::Column& column, const std::string& unit, const std::string& file) {
  if (column.unit.empty()) return;
  if (unit.empty()) {
    table.understood += fmt::format("; {} taken as it stands, for the scene names no unit of it", column.name);
    return;
  }
  const auto ratio = unit_ratio(column.unit, unit);
  if (!ratio)
    throw std::invalid_argument(fmt::format("{}: {} is in {}, and the scene's unit of it is {}: convert one of them",
                                            file, column.name, column.unit, unit));
  column.factor = *ratio;
  for (double& value : column.values) value *= *ratio;
  if (*ratio != 1.0) table.understood += fmt::format("; {} converted to {}", column.name, unit);
}

}  // namespace

UnitPowers unit_of_trace(const std::string& column) {
  const auto trace = trace_column(column);
  return trace ? unit_of(trace->first) : UnitPowers{};
}

std::vector<Event> changes_in(const TraceFile& table, const std::string& file) {
  std::vector<Event> changes;
  for (std::size_t k = 0; k < table.rows; ++k)
    changes.push_back(change_of(file, table.column("t")->values[k], table.column("where")->cells[k],
                                table.column("change")->cells[k]));
  return changes;
}

std::vector<std::string> names_of_traces() {
  std::vector<std::string> names = {"t"};
  names.insert(names.end(), trace_column_names().begin(), trace_column_names().end());
  return names;
}

TraceFile read_measured(const SceneFile& scene, const std::string& file, const std::vector<std::string>& known,
                        const std::vector<std::string>& required, const std::vector<std::string>& words) {
  TraceFile table = read_traces(file, known, required, words);
  if (table.columns.size() == 1)
    throw std::invalid_argument(fmt::format("{}: has no column of values beside t; known are {}", file,
                                            fmt::join(known.begin() + 1, known.end(), ", ")));
  TraceFile::Column& t = *table.column("t");
  convert(table, t, scene.run.scene.units.time, file);
  for (TraceFile::Column& column : table.columns)
    if (const auto trace = trace_column(column.name))
      convert(table, column, unit_name(scene.run.scene.units, unit_of(trace->first)), file);
  // Data may be a part of the run, or a record that goes on behind it; units differ by sixty times or more.
  constexpr double most = 5.0, least = 0.01;
  const double last = t.values.empty() ? 0.0 : t.values.back(), end = scene.run.end;
  if (last == 0.0 && !table.column("where")) throw std::invalid_argument(file + ": has no time after 0");
  const bool late = last > most * end;
  // The last contact may be early.
  if (late || (last > 0.0 && last < least * end && !table.column("where")))
    throw std::invalid_argument(fmt::format(
        "{}:{}: the last time is {:.6g}, and the scene ends at {:.6g}: is it in another unit{}? If it is not, say "
        "--set time.end={:.6g}",
        file, table.lines.back(), last, end,
        !t.unit.empty() && scene.run.scene.units.time.empty()
            ? fmt::format(" (the file says {}, and the scene has no units.time)", t.unit)
            : fmt::format(", such as {} ({:.6g})", late ? "milliseconds for seconds" : "seconds for milliseconds",
                          late ? 1e-3 * last : 1e3 * last),
        last));
  return table;
}

std::string study_json(Json json, const std::vector<std::string>& warnings, const SceneFile& scene) {
  json["warnings"] = warnings;
  json["scene"] = complete(scene);
  json["version"] = versions().viscobar;
  json["platform"] = versions().platform;
  return json_text(json);
}

}  // namespace viscobar
