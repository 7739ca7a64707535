#include "report/measured.hpp"

#include <fmt/format.h>

#include <optional>
#include <stdexcept>

#include "scene/unit_names.hpp"

namespace viscobar {

void convert(TraceFile& table, TraceFile::Column& column, const std::string& unit, const std::string& file) {
  if (column.unit.empty() || unit.empty()) return;
  const auto ratio = unit_ratio(column.unit, unit);
  if (!ratio)
    throw std::invalid_argument(fmt::format("{}: {} is in {}, and the scene's unit of it is {}: convert one of them",
                                            file, column.name, column.unit, unit));
  for (double& value : column.values) value *= *ratio;
  if (*ratio != 1.0) table.understood += fmt::format("; {} converted to {}", column.name, unit);
}

std::vector<std::string> names_of_traces() {
  std::vector<std::string> names = {"t"};
  for (const TraceColumn column : all_trace_columns) names.push_back(name(column));
  names.insert(names.end(), {"u@", "v@", "strain@", "stress@"});
  return names;
}

TraceFile read_measured(const SceneFile& scene, const std::string& file, const std::vector<std::string>& known,
                        const std::vector<std::string>& required, const std::vector<std::string>& words) {
  TraceFile table = read_traces(file, known, required, words);
  TraceFile::Column& t = *table.column("t");
  convert(table, t, scene.run.scene.units.time, file);
  constexpr double far = 100.0;
  const double last = t.values.back(), end = scene.run.end;
  if (last > far * end || (last > 0.0 && far * last < end))
    throw std::invalid_argument(
        fmt::format("{}: the last time is {:.6g}{}, and the scene ends at {:.6g}: are they in different units, such as "
                    "milliseconds and seconds? If they are not, say --set time.end={:.6g}",
                    file, last, t.unit.empty() ? "" : " " + t.unit, end, last));
  return table;
}

std::string unit_of(TraceColumn column, const Units& units) {
  constexpr std::optional<Dimension> dimensions[] = {
      Dimension::length, Dimension::velocity, Dimension::stress,   Dimension::length, Dimension::velocity,
      Dimension::stress, Dimension::length,   Dimension::velocity, std::nullopt,      Dimension::stress};
  const auto dimension = dimensions[static_cast<std::size_t>(column)];
  return dimension ? unit_name(units, *dimension) : "";
}

}  // namespace viscobar
