#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "report/obstacle_levels.hpp"
#include "report/plot/figure.hpp"
#include "report/plot/png.hpp"
#include "report/plot/range.hpp"
#include "report/run/run_page.hpp"
#include "text/number.hpp"

namespace viscobar {

namespace {

using plot::Axis;
using plot::Figure;
using plot::fitted;
using plot::Interval;
using plot::Point;
using plot::Range;

Axis time_axis(const ReportData& data) {
  return {.label = "time t", .low = data.field.time(0), .high = data.field.time(data.field.rows() - 1), .link = "t"};
}

Range field_range(const ReportData& data) {
  Range range;
  for (std::size_t row = 0; row < data.field.rows(); ++row)
    for (const double u : data.field.row(row)) range.add(u);
  return range;
}

double mixed(double a, double b, double weight) { return a + weight * (b - a); }

/// Where a position lies among increasing values: the index below it and the part of the way to the next.
struct Place {
  std::size_t index;
  double weight;
};
template <class Values>
Place locate(const Values& values, std::size_t count, double at, std::size_t from) {
  std::size_t i = from;
  while (i + 2 < count && values(i + 1) <= at) ++i;
  return {i, std::clamp((at - values(i)) / (values(i + 1) - values(i)), 0.0, 1.0)};
}

std::string obstacle_text(const ObstacleLevel& level) { return "obstacle " + readable(level.u); }

const Obstacle* obstacle(const EndCondition& end) { return std::get_if<Obstacle>(&end); }

// Of an obstacle that moves; none of one that does not.
std::vector<Point> moving_surface(const EndCondition& end, const EndInput& input, const ReportData& data) {
  std::vector<Point> surface;
  if (!is_obstacle(end) || !input.motion) return surface;
  for (std::size_t row = 0; row < data.field.rows(); ++row) {
    const double t = data.field.time(row);
    surface.push_back({t, surface_at(*obstacle(end), input, t)});
  }
  return surface;
}

}  // namespace

FieldColours field_colours(const Case& run, const ReportData& data) {
  Range range = field_range(data);
  const double size = range.high - range.low, smaller_part = std::min(range.high, -range.low);
  const bool two_signs = smaller_part > 0.1 * std::max(range.high, -range.low);
  if (two_signs) {
    range.add(-range.low);
    range.add(-range.high);
  }
  Axis values{"displacement u", range.low, range.high};
  if (!(range.high - range.low > 1e-12 * std::max(std::abs(range.low), std::abs(range.high))))
    values = range.axis(values.label);
  // Rounding apart, a constrained node lies on the obstacle and a penalised one in it.
  FieldColours colours{two_signs ? plot::diverging() : plot::sequential(), values};
  for (const ObstacleLevel& level : levels_of(run.scene.span ? &*run.scene.span : nullptr))
    (level.above ? colours.contact_from : colours.contact_up_to) = level.u + (level.above ? -1e-9 : 1e-9) * size;
  return colours;
}

Picture displacement_map(const Case& run, const ReportData& data, const FieldColours& colours_of) {
  constexpr std::size_t width = 480, height = 300, colours = 255, touching = 255;
  const ThinnedField& field = data.field;
  const auto& [map, values, contact_up_to, contact_from] = colours_of;

  std::array<plot::Colour, 256> palette{};
  for (std::size_t i = 0; i < colours; ++i) palette[i] = map.at(static_cast<double>(i) / (colours - 1));
  palette[touching] = FieldColours::touching;
  bool touched = false;
  std::vector<std::uint8_t> pixels(width * height);
  const Axis time = time_axis(data);
  Place in_time{0, 0.0};
  for (std::size_t i = 0; i < width; ++i) {
    const double t = mixed(time.low, time.high, (static_cast<double>(i) + 0.5) / width);
    in_time = locate([&](std::size_t k) { return field.time(k); }, field.rows(), t, in_time.index);
    const auto before = field.row(in_time.index), after = field.row(in_time.index + 1);
    Place in_space{0, 0.0};
    for (std::size_t j = 0; j < height; ++j) {
      const double x = run.scene.bar.length * (static_cast<double>(j) + 0.5) / height;
      in_space = locate([&](std::size_t k) { return field.x()[k]; }, field.x().size(), x, in_space.index);
      const auto at = [&](std::span<const double> row) {
        return mixed(row[in_space.index], row[in_space.index + 1], in_space.weight);
      };
      const double u = mixed(at(before), at(after), in_time.weight);
      std::uint8_t& pixel = pixels[(height - 1 - j) * width + i];
      pixel = static_cast<std::uint8_t>(std::lround(std::clamp(values.position(u), 0.0, 1.0) * (colours - 1)));
      if (u <= contact_up_to || u >= contact_from) {
        pixel = touching;
        touched = true;
      }
    }
  }

  const Axis position{.label = "position x", .low = 0.0, .high = run.scene.bar.length, .link = "x"};
  Figure figure(time, position, 400.0);
  figure.image(plot::png_data_uri(width, height, palette, pixels), {time.low, 0.0}, {time.high, run.scene.bar.length});
  figure.colour_bar(map, values);
  if (touched) figure.legend_box(plot::hex(palette[touching]), "in contact");
  figure.live_layer(R"({"kind":"map"})");
  std::string caption = "Displacement <i>u</i>(<i>x</i>, <i>t</i>).";
  if (values.low == -values.high) caption += " The pale middle of the scale is zero.";
  const auto every = [](std::size_t stride, const char* what) {
    return stride == 1 ? fmt::format("every {}", what) : fmt::format("every {} {}", ordinal(stride), what);
  };
  if (field.time_stride() > 1 || field.node_stride() > 1)
    caption += fmt::format(" Drawn from {} and {}; field.h5 has them all.", every(field.time_stride(), "output time"),
                           every(field.node_stride(), "node"));
  return {"Displacement over space and time",
          caption,
          {{"displacement", "Displacement over time and space as a colour map", figure}}};
}

Picture profiles(const Case& run, const ReportData& data) {
  constexpr std::size_t count = 6;
  const ThinnedField& field = data.field;
  const double length = run.scene.bar.length;
  std::vector<std::size_t> rows;
  const Axis time = time_axis(data);
  for (std::size_t k = 0, row = 0; k < count; ++k) {
    const double t = mixed(time.low, time.high, static_cast<double>(k) / (count - 1));
    while (row + 1 < field.rows() && std::abs(field.time(row + 1) - t) <= std::abs(field.time(row) - t)) ++row;
    if (rows.empty() || rows.back() != row) rows.push_back(row);
  }
  Range of_few;
  for (const std::size_t row : rows)
    for (const double u : field.row(row)) of_few.add(u);
  const double depth = 0.03 * length;
  const Axis position{.label = "position x", .low = -depth, .high = length + depth, .link = "x"};

  // The obstacles, and what is said of those that lie outside.
  std::string hidden;
  bool has_bodies = false;
  const auto with_obstacles = [&](Range range, double height, double room_below) {
    std::vector<std::pair<ObstacleLevel, Interval>> bodies;
    hidden.clear();
    bool moves = false;
    const auto place_moving = [&](const EndCondition& end, const EndInput& input, const char* where) {
      const std::vector<Point> surface = moving_surface(end, input, data);
      if (surface.empty()) return false;
      Range way;
      way.add(surface);
      Range with_it = range;
      const bool near = with_it.reach(way.low) && with_it.reach(way.high);
      if (near) range = with_it, moves = true;
      hidden += fmt::format(" The obstacle {} moves{}, between {} and {}.", where, near ? "" : " outside",
                            readable(way.low), readable(way.high));
      return true;
    };
    const auto place = [&](const Obstacle* body, Interval part, const char* where) {
      for (const ObstacleLevel& level : levels_of(body))
        if (range.reach(level.u))
          bodies.push_back({level, part});
        else
          hidden += fmt::format(" The obstacle {} lies outside, at {}.", where, readable(level.u));
    };
    if (!place_moving(run.scene.left, run.scene.left_input, "at the left end"))
      place(obstacle(run.scene.left), {-depth, depth}, "at the left end");
    if (!place_moving(run.scene.right, run.scene.right_input, "at the right end"))
      place(obstacle(run.scene.right), {length - depth, length + depth}, "at the right end");
    place(run.scene.span ? &*run.scene.span : nullptr, {-depth, length + depth}, "of the span");
    has_bodies = moves || !bodies.empty();
    const double room = room_below * (range.high - range.low), low = range.low, high = range.high;
    const auto any = [&](bool above) {
      return std::ranges::any_of(bodies, [&](const auto& body) { return body.first.above == above; });
    };
    if (moves || any(false)) range.add(low - room);
    if (moves || any(true)) range.add(high + room);
    Figure figure(position, range.axis("displacement u"), height);
    for (const auto& [level, part] : bodies) figure.body(level.u, part, level.above);
    return figure;
  };

  Figure live = with_obstacles(field_range(data), 340.0, 0.2);  // for gap and reaction below the obstacles
  live.live_layer(R"({"kind":"bar"})");
  const std::string live_caption =
      std::string(
          "The bar at the time of the slider, its displacement drawn upwards and coloured as in the picture below; "
          "shaded: where it has been and will be.") +
      (has_bodies ? " Hatched: obstacles, with the gap left and the reaction while in contact." : "") + hidden;

  Figure figure = with_obstacles(of_few, 320.0, 0.0);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    std::vector<Point> line;
    const auto u = field.row(rows[k]);
    for (std::size_t j = 0; j < u.size(); ++j) line.push_back({field.x()[j], u[j]});
    const double part = rows.size() > 1 ? static_cast<double>(k) / static_cast<double>(rows.size() - 1) : 0.0;
    figure.line(line, {plot::sequence_colour(part), false, 1.8}, "t = " + readable(field.time(rows[k])));
  }
  const std::string still_caption =
      "The bar's displacement <i>u</i>(<i>x</i>, ·) at a few times, from the first (light) to the last (dark)." +
      std::string(has_bodies ? " Grey: obstacles." : "") + hidden;
  return {"The bar",
          fmt::format("<span class=\"still\">{}</span><span class=\"live\">{}</span>", still_caption, live_caption),
          {{"bar", "Displacement over space at a few times", figure, live}}};
}

Picture end_traces(const Case& run, const Outcome& outcome, const ReportData& data) {
  std::vector<Panel> panels;
  const auto panel = [&](const char* name, const EndCondition& end, const EndInput& input, const ReportData::End& trace,
                         std::size_t colour, const char* label) {
    if (is_fixed(end) && !input.motion) return;
    const std::vector<Point> points = trace.displacement.points();
    Range range;
    range.add(points);
    const Obstacle* body = obstacle(end);
    const std::vector<Point> surface = moving_surface(end, input, data);
    range.add(surface);
    std::vector<ObstacleLevel> shown, span_shown;
    for (const ObstacleLevel& level : levels_of(surface.empty() ? body : nullptr))
      if (range.reach(level.u)) shown.push_back(level);
    for (const ObstacleLevel& level : levels_of(run.scene.span ? &*run.scene.span : nullptr))
      if (range.reach(level.u)) span_shown.push_back(level);
    Figure figure(time_axis(data), range.axis(label), 220.0);
    if (body) figure.shade(trace.in_contact(outcome.reached_time), plot::series_colour(colour), "in contact");
    for (const ObstacleLevel& level : shown) figure.level(level.u, {"var(--ink)", true, 1.2}, obstacle_text(level));
    if (!surface.empty()) figure.line(surface, {"var(--ink)", true, 1.2}, "obstacle");
    if (body && surface.empty() && shown.empty())
      figure.legend_note(obstacle_text(levels_of(body).front()) + " (outside)");
    for (const ObstacleLevel& level : span_shown)
      figure.level(level.u, {"var(--soft)", true, 1.2}, "span at " + readable(level.u));
    figure.line(points, {plot::series_colour(colour)}, label);
    panels.push_back({name, std::string("Displacement over time: ") + label, figure});
  };
  panel("left-end", run.scene.left, run.scene.left_input, data.left, 0, "u(0, t)");
  panel("right-end", run.scene.right, run.scene.right_input, data.right, 1, "u(L, t)");
  return {
      "Ends",
      std::string(panels.size() < 2 ? "Displacement of the end that moves." : "Displacement of the two ends.") +
          (is_obstacle(run.scene.left) || is_obstacle(run.scene.right) ? " Dashed: obstacle; shaded: times in contact."
                                                                       : ""),
      panels};
}

Picture sensitivities(const Case& run, const ReportData& data) {
  Picture picture{"Sensitivities", "Derivatives of the ends' displacements with respect to numbers of the scene.", {}};
  for (std::size_t k = 0; k < data.sensitivities.size() && k < run.directions.size(); ++k) {
    const std::vector<Point> left = data.sensitivities[k].left.points(), right = data.sensitivities[k].right.points();
    Range range;
    range.add(0.0);
    range.add(left);
    range.add(right);
    const std::string& key = run.directions[k].key;
    Figure figure(time_axis(data), range.axis("du / d " + key), 220.0);
    figure.line(left, {plot::series_colour(0)}, "left end");
    figure.line(right, {plot::series_colour(1)}, "right end");
    picture.panels.push_back({fmt::format("sensitivity-{}", k + 1), "Sensitivity of the ends to " + key, figure});
  }
  return picture;
}

Picture reactions(const Case& run, const ReportData& data) {
  const bool span = run.scene.span.has_value();
  const std::vector<Point> left = data.left.reaction.points(), right = data.right.reaction.points();
  const bool with_left = span || is_obstacle(run.scene.left), with_right = span || is_obstacle(run.scene.right);
  if (!with_left && !with_right) return {};
  Range range;
  range.add(0.0);
  if (with_left) range.add(left);
  if (with_right) range.add(right);
  Figure figure(time_axis(data), range.axis("reaction R"), 240.0);
  if (with_left) figure.line(left, {plot::series_colour(0)}, "left end");
  if (with_right) figure.line(right, {plot::series_colour(1)}, "right end");
  return {"Reactions",
          "Force of the obstacle on each end, at the output times.",
          {{"reactions", "Reactions of the obstacles over time", figure}}};
}

Picture energies(const ReportData& data) {
  const auto& energy = data.energy;
  const std::vector<Point> total = energy.total.points(), kinetic = energy.kinetic.points(),
                           elastic = energy.elastic.points(), contact = energy.contact.points();
  Range range;
  range.add(0.0);
  range.add(total);
  Figure figure(time_axis(data), range.axis("energy"), 260.0);
  figure.line(kinetic, {plot::series_colour(0)}, "kinetic");
  figure.line(elastic, {plot::series_colour(1)}, "elastic");
  if (data.has_springs()) figure.line(contact, {plot::series_colour(2)}, "contact springs");
  figure.line(total, {"var(--ink)", true, 1.6}, "total");
  return {"Energy",
          data.has_springs()
              ? "Energy of the bar and, counted in the total, that stored in the penalty springs of the contacts."
              : "Kinetic and elastic energy of the bar.",
          {{"energy", "Energy over time", figure}}};
}

}  // namespace viscobar
