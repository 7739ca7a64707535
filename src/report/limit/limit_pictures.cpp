#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "report/limit/limit_tables.hpp"
#include "text/number.hpp"

namespace viscobar {

namespace {

using plot::Axis;
using plot::Figure;
using plot::Point;
using plot::Range;

NumberText on_page(const LimitStudy& study) { return NumberText::page(study.scene.scene); }

Axis epsilon_axis(const LimitStudy& study, const LimitResult& result) {
  const NumberText number = on_page(study);
  Range range;
  for (const LimitRow& row : result.rows) range.add(row.epsilon);
  Axis axis = range.decades(number.heading("penalty ε", number.of_epsilon));
  axis.link = "epsilon";
  return axis;
}

/// Light for the coarsest mesh, dark for the finest; a single one like the first series elsewhere.
std::string mesh_colour(const LimitResult& result, std::size_t mesh) {
  if (result.orders.size() == 1) return plot::series_colour(0);
  return plot::sequence_colour(static_cast<double>(mesh) / static_cast<double>(result.orders.size() - 1));
}

std::string mesh_label(const LimitResult& result, std::size_t mesh) {
  return fmt::format("{} elements", result.orders[mesh].elements);
}

template <class Value>
std::vector<Point> points_of(std::span<const LimitRow> rows, Value value) {
  std::vector<Point> points;
  for (const LimitRow& row : rows)
    if (const double y = value(row); y > 0.0) points.push_back({row.epsilon, y});
  return points;
}

using Lines = std::vector<std::vector<Point>>;

template <class Value>
Lines lines_of(const LimitResult& result, Value value) {
  Lines lines;
  for (std::size_t m = 0; m < result.orders.size(); ++m) lines.push_back(points_of(rows_of(result, m), value));
  return lines;
}

void draw_meshes(Figure& figure, const LimitResult& result, const Lines& lines) {
  for (std::size_t m = 0; m < lines.size(); ++m)
    figure.series(lines[m], {mesh_colour(result, m)}, mesh_label(result, m));
}

Axis decades_of(std::string label, const Lines& lines, const std::vector<double>& levels = {}) {
  Range range;
  for (const auto& line : lines) range.add(line);
  for (const double level : levels)
    if (level > 0.0) range.add(level);
  return range.decades(std::move(label));
}

std::string slope_name(double order) {
  if (order == 1.0) return "slope 1";
  return order == 0.5 ? "slope 1/2" : "slope 2/3";
}

/// A dashed line of the theory's slope over [low, high], below all that is measured there.
void slope_line(Figure& figure, const std::vector<Point>& points, double order, double low, double high) {
  constexpr double shift = 0.45;
  double least = std::numeric_limits<double>::infinity();
  for (const Point& point : points)
    if (point.x >= 0.99 * low && point.x <= 1.01 * high) least = std::min(least, point.y / std::pow(point.x, order));
  const auto at = [&](double x) { return Point{x, shift * least * std::pow(x, order)}; };
  if (std::isfinite(least))
    figure.line(std::vector<Point>{at(low), at(high)}, {"var(--soft)", true, 1.4}, slope_name(order));
}

/// Lines of theory for one curve: the node's power below the boundary of the regimes, the layer's above.
void theory_lines(Figure& figure, const std::vector<Point>& points, const Axis& x, std::optional<double> boundary,
                  std::optional<double> node, std::optional<double> layer) {
  const double border = std::clamp(boundary.value_or(x.high), x.low, x.high);
  if (node && border > 3.0 * x.low) slope_line(figure, points, *node, x.low, border);
  if (layer && border < x.high / 3.0) slope_line(figure, points, *layer, border, x.high);
}

bool inside(std::optional<double> boundary, const Axis& x) {
  return boundary && *boundary > x.low && *boundary < x.high;
}

void mark_boundaries(Figure& figure, const LimitResult& result, const LimitTheory& powers, const Axis& x) {
  for (std::size_t m = 0; m < result.orders.size(); ++m) {
    const auto& boundary = result.orders[m].boundary;
    if (!inside(boundary, x)) continue;
    figure.marker_line(*boundary, {mesh_colour(result, m), true, 1.0},
                       result.orders.size() == 1 ? fmt::format("ε = {}", powers.boundary)
                                                 : fmt::format("{}", result.orders[m].elements));
  }
}

}  // namespace

Picture penetration_picture(const LimitStudy& study, const LimitResult& result) {
  const Lines lines = lines_of(result, [](const LimitRow& row) { return row.max_penetration; });
  const Axis x = epsilon_axis(study, result);
  Figure figure(x, decades_of(on_page(study).heading("largest penetration", Dimension::length), lines), 380.0);
  const LimitTheory powers = theory(study);
  mark_boundaries(figure, result, powers, x);
  draw_meshes(figure, result, lines);
  const std::size_t best = finest(result);
  theory_lines(figure, lines[best], x, result.orders[best].boundary, powers.penetration, powers.layer);
  std::string caption =
      "How far the bar goes into the obstacles. Grey dashes: slopes of the theory, drawn below the measured line";
  if (const auto& boundary = result.orders[best].boundary; inside(boundary, x))
    caption += fmt::format(
        "; the upright line at <i>ε</i> = {} separates the regimes: left of it the contact node "
        "answers alone, right of it {}",
        powers.boundary,
        powers.layer ? "the mesh resolves the layer that a contact strains"
                     : "viscosity drags it along with its neighbours");
  else if (boundary)
    caption +=
        fmt::format("; the regimes meet at <i>ε</i> = {} = {}, {} the picture", powers.boundary,
                    on_page(study)(*boundary, on_page(study).of_epsilon), *boundary >= x.high ? "right of" : "left of");
  return {"Penetration", caption + ".", {{"penetration", "Largest penetration over the penalty", figure}}};
}

Picture difference_picture(const LimitStudy& study, const LimitResult& result) {
  const Axis x = epsilon_axis(study, result);
  const NumberText number = on_page(study);
  const LimitTheory powers = theory(study);
  std::vector<Panel> panels;
  for (std::size_t m = 0; m < result.orders.size(); ++m) {
    const LimitOrders& orders = result.orders[m];
    const auto rows = rows_of(result, m);
    const auto own = points_of(rows, [](const LimitRow&row) { return row.difference_to_own_limit.value_or(0.0); }),
               limit = points_of(rows, [](const LimitRow&row) { return row.difference_to_scheme_limit.value_or(0.0); });
    Lines schemes;  // at its first step, and at its smallest
    for (const SchemeRun& run : orders.scheme) {
      if (&run != &orders.scheme.front() && &run != &orders.scheme.back()) continue;
      std::vector<Point>& points = schemes.emplace_back();
      for (std::size_t i = 0; i < rows.size() && i < run.differences.size(); ++i)
        if (run.differences[i] > 0.0) points.push_back({rows[i].epsilon, run.differences[i]});
    }
    Lines all = schemes;
    all.push_back(own);
    all.push_back(limit);
    const Axis y = decades_of(number.heading("end difference", Dimension::length), all);
    Figure figure(x, y, 380.0);
    mark_boundaries(figure, {.rows = {}, .orders = {orders}, .failed = {}, .own_motion = {}, .left_out = {}}, powers,
                    x);
    if (result.orders.size() > 1) figure.legend_note(mesh_label(result, m));
    // Wide, to be seen below the others where they agree.
    if (!limit.empty() && orders.evidence.apart.value_or(0.0) > 0.0)
      figure.series(limit, {plot::series_colour(2), false, 4.0}, "to the scheme's limit");
    for (std::size_t k = 0; k < schemes.size(); ++k)
      figure.series(schemes[k], {plot::series_colour(1), k + 1 < schemes.size(), k + 1 < schemes.size() ? 1.2 : 2.0},
                    "to the scheme, dt = " +
                        number(k == 0 ? orders.scheme.front().step : orders.scheme.back().step, Dimension::time, 2));
    if (!own.empty()) figure.series(own, {plot::series_colour(0)}, "to its own limit");
    if (const auto& settled = orders.to_own_limit) {
      const std::vector<Point> range = {{rows[settled->first].epsilon, *rows[settled->first].difference_to_own_limit},
                                        {rows[settled->last].epsilon, *rows[settled->last].difference_to_own_limit}};
      figure.line(range, {plot::series_colour(0), false, 6.0}, fmt::format("settled, power {:.2f}", settled->order));
    }
    theory_lines(figure, own.empty() && !schemes.empty() ? schemes.back() : own, x, orders.boundary,
                 own.empty() && orders.verdict == Verdict::plateau ? std::nullopt : std::optional(powers.penetration),
                 powers.layer);
    panels.push_back({fmt::format("difference-{}", orders.elements),
                      fmt::format("Difference of the end traces over the penalty, {} elements", orders.elements),
                      figure});
  }
  return {
      "Difference to the limits",
      "Largest difference of the end traces over time: of the penalised bar to its own limit, to the fully discrete "
      "scheme at its first and its smallest step, and to the scheme's limit. Thick: the range in which the power of "
      "<i>ε</i> is settled. Grey dashes: slopes of the theory.",
      panels};
}

Picture events_picture(const LimitStudy& study, const LimitResult& result) {
  Lines lines(result.orders.size());
  std::vector<double> levels;
  Range penalised;
  for (std::size_t m = 0; m < lines.size(); ++m) {
    for (const LimitRow& row : rows_of(result, m)) lines[m].push_back({row.epsilon, static_cast<double>(row.events)});
    penalised.add(lines[m]);
    levels.push_back(static_cast<double>(result.orders[m].scheme_events));
  }
  constexpr double linear_up_to = 30.0;
  Range all = penalised;
  all.add(0.0);
  all.add(levels);
  Figure figure(epsilon_axis(study, result),
                penalised.high > linear_up_to && penalised.low > 0.0 ? decades_of("contact changes", lines, levels)
                                                                     : all.axis("contact changes"),
                260.0);
  for (std::size_t m = 0; m < lines.size(); ++m) {
    figure.series(lines[m], {mesh_colour(result, m)}, mesh_label(result, m));
    figure.level(levels[m], {mesh_colour(result, m), true, 1.2}, m + 1 == lines.size() ? "scheme" : "");
  }
  return {"Contact changes",
          "How often contacts close or open, penalised (marks) and in the scheme (dashed).",
          {{"contact-changes", "Number of contact changes over the penalty", figure}}};
}

Picture cost_picture(const LimitStudy& study, const LimitResult& result) {
  const Lines lines = lines_of(result, [](const LimitRow& row) { return static_cast<double>(row.steps); });
  Figure figure(epsilon_axis(study, result), decades_of("steps", lines), 260.0);
  draw_meshes(figure, result, lines);
  return {"Cost", "Steps of the penalised runs.", {{"cost", "Steps of the time integration over the penalty", figure}}};
}

}  // namespace viscobar
