#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "report/precision/precision_tables.hpp"

namespace viscobar {

namespace {

using plot::Axis;
using plot::Figure;
using plot::Point;
using plot::Range;
using plot::Style;

bool among(const auto& values, const auto& value) { return std::ranges::find(values, value) != values.end(); }

/// The same in every picture; schemes are dashed, so that the palette may come round.
Style style_of(const PrecisionResult& result, MethodName method) {
  const auto methods = values_in(result, &ErrorParts::method);
  const auto place = static_cast<std::size_t>(std::ranges::find(methods, method) - methods.begin());
  return {plot::series_colour(place), is_scheme(method), 1.8, place};
}

template <class X, class Y>
std::vector<Point> points_of(std::span<const PrecisionRow> rows, X x, Y y) {
  std::vector<Point> points;
  for (const PrecisionRow& row : rows) {
    const std::optional<double> value = y(row);
    if (row.failure.empty() && value && *value > 0.0 && x(row) > 0.0) points.push_back({x(row), *value});
  }
  return points;
}

double seconds(const PrecisionRow& row) { return row.seconds; }
double setting(const PrecisionRow& row) { return row.setting; }
std::optional<double> error(const PrecisionRow& row) { return row.error; }

/// Labels in the frame, those that would lie on each other joined.
void draw_labels(Figure& figure, const Axis& x, const Axis& y,
                 const std::vector<std::pair<Point, std::string>>& labels) {
  constexpr double close = 0.05;
  std::vector<std::pair<Point, std::string>> joined;
  for (const auto& [at, text] : labels) {
    const auto known = std::ranges::find_if(joined, [&, place = at](const auto& label) {
      return std::abs(x.position(label.first.x) - x.position(place.x)) < close &&
             std::abs(y.position(label.first.y) - y.position(place.y)) < close;
    });
    if (known == joined.end())
      joined.emplace_back(at, text);
    else if (!known->second.ends_with(text))
      known->second += ", " + text;
  }
  for (const auto& [at, text] : joined) figure.label(at, text);
}

/// A line for each method on each mesh, the mesh named at its end where there are several.
template <class Error>
std::optional<Figure> diagram(const PrecisionResult& result, std::span<const std::size_t> meshes,
                              const std::string& label, Error value, double floor) {
  Range x, y;
  for (const ErrorParts& parts : result.parts)
    for (const Point& point : points_of(rows_of(result, parts), seconds, value)) {
      x.add(point.x);
      if (among(meshes, parts.elements)) y.add(point.y);
    }
  if (!(y.low <= y.high)) return std::nullopt;
  if (meshes.size() > 1) x.add(3.0 * x.high);  // room for the labels
  const Axis along = x.decades("seconds"), up = y.decades(label);
  Figure figure(along, up, 420.0);
  std::vector<std::pair<Point, std::string>> labels;
  if (meshes.size() == 1 && meshes_in(result).size() > 1) figure.legend_note(fmt::format("{} elements", meshes[0]));
  if (floor > up.low && floor < up.high) figure.level(floor, {"var(--soft)", true, 1.2}, "reference's own");
  std::vector<MethodName> named;
  for (const ErrorParts& parts : result.parts) {
    if (!among(meshes, parts.elements)) continue;
    const auto points = points_of(rows_of(result, parts), seconds, value);
    if (points.empty()) continue;
    figure.series(points, style_of(result, parts.method),
                  among(named, parts.method) ? std::string_view() : name(parts.method));
    named.push_back(parts.method);
    if (meshes.size() > 1) labels.emplace_back(points.back(), fmt::format("{}", parts.elements));
  }
  draw_labels(figure, along, up, labels);
  return figure;
}

}  // namespace

Picture error_picture(const PrecisionResult& result, const NumberText& number) {
  if (!result.reference) return {};
  const auto meshes = meshes_in(result);
  const auto figure = diagram(result, meshes, number.heading("error: largest |u − u*|", Dimension::length), error,
                              result.reference->error);
  if (!figure) return {};
  std::string caption =
      "Largest |<i>u</i> − <i>u</i><sub>∗</sub>| over times and nodes, over the median time of the integration: "
      "the lower left is better. Where a line is flat, a smaller tolerance or step costs time without reducing the "
      "error.";
  if (meshes.size() > 1) caption += " Numbers: elements.";
  return {"Speed against error", caption, {{"error", "Error over seconds", *figure}}};
}

Picture time_error_picture(const PrecisionResult& result, const NumberText& number) {
  std::vector<Panel> panels;
  const auto resolved = [&](const PrecisionRow& row) { return resolved_time_error(result, row); };
  for (const std::size_t mesh : meshes_in(result))
    if (const auto figure =
            diagram(result, std::span(&mesh, 1), number.heading("time error", Dimension::length), resolved, 0.0))
      panels.push_back(
          {fmt::format("time-error-{}", mesh), fmt::format("Time error over seconds, {} elements", mesh), *figure});
  return {
      "Speed against the error of time integration",
      "The same runs against the exact solution of each method's own semi-discrete system: what the tolerance or the "
      "step does by itself. Errors that their reference cannot tell from its own are left out.",
      panels};
}

Picture parts_picture(const PrecisionResult& result, const NumberText& number) {
  const auto meshes = meshes_in(result);
  const std::size_t finest = std::ranges::max(meshes);
  const auto resolved = [&](const PrecisionRow& row) { return resolved_time_error(result, row); };
  std::vector<Panel> panels;
  for (const ErrorParts& parts : result.parts) {
    if (parts.elements != finest || !parts.space) continue;
    const auto rows = rows_of(result, parts);
    const auto total = points_of(rows, setting, error), time = points_of(rows, setting, resolved);
    if (total.size() < 2) continue;
    Range x, y;
    for (const Point& point : total) x.add(point.x);
    y.add(total);
    y.add(time);
    // A part far below all that the picture shows is left to the table.
    const double least = y.low / 100.0;
    for (const auto& level : {parts.space, parts.penalty})
      if (level && *level > least) y.add(*level);
    const std::string setting = is_scheme(parts.method) ? number.heading("step", Dimension::time) : "tolerance";
    Figure figure(x.decades(setting), y.decades(number.heading("error: largest |u − u*|", Dimension::length)), 300.0);
    figure.legend_note(name(parts.method));
    figure.line(total, {"var(--rule)", false, 7.0}, "in all");
    if (*parts.space > least) figure.level(*parts.space, {plot::series_colour(2), true, 1.8}, "space");
    if (parts.penalty && *parts.penalty > least)
      figure.level(*parts.penalty, {plot::series_colour(1), true, 1.8}, "penalty");
    figure.series(time, {plot::series_colour(0), false, 1.8}, "time");
    panels.push_back({fmt::format("parts-{}", name(parts.method)),
                      fmt::format("Parts of the error of {}", name(parts.method)), figure});
  }
  return {"What the error consists of",
          fmt::format("On {} elements. The error in all follows its largest part: with the tolerance or the step it "
                      "falls until space or penalty is left over.",
                      finest),
          panels};
}

}  // namespace viscobar
