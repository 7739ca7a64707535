#include <fmt/format.h>

#include <algorithm>

#include "input/unit_of_key.hpp"
#include "report/run/run_page.hpp"
#include "report/scene_ends.hpp"
#include "scene/unit_names.hpp"
#include "text/number.hpp"

namespace viscobar {

namespace {

using plot::Axis;
using plot::Figure;
using plot::Interval;
using plot::Point;
using plot::Range;

std::string length_text(const Case& run, double value) { return on_page(run)(value, Dimension::length, 4); }
std::string time_text(const Case& run, double value) { return "t = " + on_page(run)(value, Dimension::time, 4); }
std::string obstacle_text(const Case& run, const ObstacleLevel& level) {
  return "obstacle " + length_text(run, level.u);
}

std::string displacement_label(const Case& run, std::string_view words) {
  return on_page(run).heading(words, Dimension::length);
}

}  // namespace

FieldColours field_colours(const Case& run, const ReportData& data) {
  FieldColours colours = colours_of(data.field, displacement_label(run, "displacement u"));
  // Rounding apart, a constrained node lies on the obstacle and a penalised one in it.
  const double size = colours.range.high - colours.range.low;
  for (const ObstacleLevel& level : levels_of(run.scene.span))
    (level.above ? colours.contact_from : colours.contact_up_to) = level.u + (level.above ? -1e-9 : 1e-9) * size;
  return colours;
}

Picture displacement_map(const Case& run, const ReportData& data, const FieldColours& colours) {
  return {"Displacement over space and time",
          "Displacement <i>u</i>(<i>x</i>, <i>t</i>)." + map_remark(run, data.field, colours, "node"),
          {{"displacement", "Displacement over time and space as a colour map",
            map_figure(run, data.field, colours, "u")}}};
}

Picture profiles(const Case& run, const ReportData& data) {
  const ThinnedField& field = data.field;
  const double length = run.scene.bar.length, depth = 0.03 * length;
  const Axis position{
      .label = displacement_label(run, "position x"), .low = -depth, .high = length + depth, .link = "x"};

  // The obstacles, and what is said of those that lie outside.
  Range range = field.range();
  std::string hidden;
  std::vector<std::pair<ObstacleLevel, Interval>> bodies;
  bool moves = false;
  const auto place = [&](const std::vector<ObstacleLevel>& levels, Interval part, const std::string& where) {
    for (const ObstacleLevel& level : levels)
      if (range.reach(level.u))
        bodies.push_back({level, part});
      else
        hidden += fmt::format(" The obstacle {} lies outside, at {}.", where, length_text(run, level.u));
  };
  for (const SceneEnd& end : ends_of(run.scene)) {
    const std::string where = fmt::format("at the {} end", end.name);
    Range way;
    way.add(end.surface(field.times()));
    if (!(way.low <= way.high)) {
      place(levels_of(end.obstacle()), {end.x - depth, end.x + depth}, where);
      continue;
    }
    Range with_it = range;
    const bool near = with_it.reach(way.low) && with_it.reach(way.high);
    if (near) range = with_it, moves = true;
    hidden += fmt::format(" The obstacle {} moves{}, between {} and {}.", where, near ? "" : " outside",
                          length_text(run, way.low), length_text(run, way.high));
  }
  place(levels_of(run.scene.span), {-depth, length + depth}, "of the span");
  // Room for what the script says of gap and reaction on the far side of the obstacles.
  const double room = 0.2 * (range.high - range.low), low = range.low, high = range.high;
  const auto any = [&](bool above) {
    return std::ranges::any_of(bodies, [&](const auto& body) { return body.first.above == above; });
  };
  if (moves || any(false)) range.add(low - room);
  if (moves || any(true)) range.add(high + room);

  Figure figure(position, range.axis(displacement_label(run, "displacement u")), 340.0);
  const auto [lowest, highest] = field.envelope();
  constexpr double thickness = 9.0;  // of the bar that the script draws
  figure.area(plot::points_of(field.x(), lowest), plot::points_of(field.x(), highest), thickness);
  for (const auto& [level, part] : bodies) figure.body(level.u, part, level.above);
  for (std::size_t m = 1; m < field.parts().size(); ++m)
    figure.marker_line(field.x()[field.parts()[m].first], {"var(--soft)", true, 1.0}, "");
  const std::vector<std::size_t> rows = rows_of_few_times(field, 6);
  figure.begin_still();
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double part = rows.size() > 1 ? static_cast<double>(k) / static_cast<double>(rows.size() - 1) : 0.0;
    for (const ThinnedField::Part& member : field.parts())
      if (member.count > 1)
        figure.line(plot::points_of(std::span(field.x()).subspan(member.first, member.count),
                                    field.row(rows[k]).subspan(member.first, member.count)),
                    {plot::sequence_colour(part), false, 1.8},
                    &member == &field.parts().front() ? time_text(run, field.time(rows[k])) : "");
  }
  figure.end_still();
  return {"The bar",
          fmt::format(
              "<span class=\"still\">The bar's displacement <i>u</i>(<i>x</i>, ·) at a few times, from the "
              "first (light) to the last (dark).{0}</span><span class=\"live\">The bar at the time of the "
              "slider, its displacement drawn upwards and coloured as in its map.{1}</span> Shaded: where it "
              "is during the run.{2}{3}",
              bodies.empty() ? "" : " Grey: obstacles.",
              bodies.empty() && !moves ? "" : " Grey: obstacles, with the gap left and the reaction while in contact.",
              hidden, field.parts().size() > 1 ? " Upright dashes: joints." : ""),
          {{"bar", "Displacement over space at a few times", figure}}};
}

Picture end_traces(const Case& run, const Outcome& outcome, const ReportData& data) {
  const std::vector<double> times = data.field.times();
  std::vector<Panel> panels;
  for (const SceneEnd& end : ends_of(run.scene)) {
    if (is_fixed(end.condition) && !end.input.motion) continue;
    const bool is_left = end.name == "left";
    const ReportData::End& trace = is_left ? data.left : data.right;
    const std::size_t colour = is_left ? 0 : 1;
    const std::string label = is_left ? "u(0, t)" : "u(L, t)";
    const std::vector<Point> points = trace.displacement.points();
    Range range;
    range.add(points);
    const Obstacle* body = end.obstacle();
    const std::vector<Point> surface = plot::points_of(times, end.surface(times));
    range.add(surface);
    std::vector<ObstacleLevel> shown = levels_of(surface.empty() ? body : nullptr), span = levels_of(run.scene.span);
    for (std::vector<ObstacleLevel>* levels : {&shown, &span})
      std::erase_if(*levels, [&](const ObstacleLevel& level) { return !range.reach(level.u); });
    Figure figure(time_axis(data.field, on_page(run)), range.axis(displacement_label(run, label)), 220.0);
    if (body || run.scene.span)
      figure.shade(contacts_of(end.place(), outcome, data), plot::series_colour(colour), "in contact");
    for (const ObstacleLevel& level : shown)
      figure.level(level.u, {"var(--ink)", true, 1.2}, obstacle_text(run, level));
    if (!surface.empty()) figure.line(surface, {"var(--ink)", true, 1.2}, "obstacle");
    if (body && surface.empty() && shown.empty())
      figure.legend_note(obstacle_text(run, levels_of(body).front()) + " (outside)");
    for (const ObstacleLevel& level : span)
      figure.level(level.u, {"var(--soft)", true, 1.2}, "span at " + length_text(run, level.u));
    figure.line(points, {plot::series_colour(colour)}, label);
    panels.push_back({fmt::format("{}-end", end.name), "Displacement over time: " + label, figure});
  }
  const bool obstacles = meets_obstacle(run.scene);
  return {"Ends",
          fmt::format("Displacement of the {}.{}", panels.size() < 2 ? "end that moves" : "two ends",
                      obstacles ? " Dashed: obstacle; shaded: times in contact." : ""),
          panels};
}

plot::Figure over_time(const Case& run, const ReportData& data, const std::string& axis, double height,
                       const std::vector<TimeLine>& lines) {
  Range range;
  range.add(0.0);
  for (const TimeLine& line : lines) range.add(line.points);
  Figure figure(time_axis(data.field, on_page(run)), range.axis(axis), height);
  for (const TimeLine& line : lines) figure.line(line.points, line.style, line.name);
  return figure;
}

Picture sensitivities(const Case& run, const ReportData& data) {
  Picture picture{"Sensitivities", "Derivatives of the ends' displacements with respect to numbers of the scene.", {}};
  for (std::size_t k = 0; k < data.sensitivities.size() && k < run.directions.size(); ++k) {
    const auto& [left, right] = data.sensitivities[k];
    const std::string& key = run.directions[k].key;
    picture.panels.push_back({fmt::format("sensitivity-{}", k + 1), "Sensitivity of the ends to " + key,
                              over_time(run, data,
                                        with_unit("du / d " + key, squares(unit_name(run.scene.units, Dimension::length,
                                                                                     unit_of_key(key, run.scene)))),
                                        220.0,
                                        {{left.points(), {plot::series_colour(0)}, "left end"},
                                         {right.points(), {plot::series_colour(1)}, "right end"}})});
  }
  return picture;
}

Picture gauges(const Case& run, const ReportData& data) {
  Picture picture{"Gauges", "Displacement and stress at the places of output.gauges. gauges.csv has the numbers."};
  if (data.readings.empty()) return picture;
  constexpr std::size_t most = 8;  // colours
  if (data.readings.size() > most) picture.caption += fmt::format(" The first {} are drawn.", most);
  std::vector<std::string> names;
  for (const double x : run.gauges) names.push_back("x = " + length_text(run, x));
  std::vector<TimeLine> displacements, stresses;
  for (std::size_t k = 0; k < std::min(most, names.size()); ++k) {
    const plot::Style style{plot::series_colour(k)};
    displacements.push_back({data.readings[k].displacement.points(), style, names[k]});
    stresses.push_back({data.readings[k].stress.points(), style, names[k]});
  }
  picture.panels = {{"gauge-displacements", "Displacement at the gauges",
                     over_time(run, data, on_page(run).heading("u", Dimension::length), 220.0, displacements)},
                    {"gauge-stresses", "Stress at the gauges",
                     over_time(run, data, on_page(run).heading("stress", Dimension::stress), 220.0, stresses)}};
  return picture;
}

std::vector<Interval> contacts_of(const ContactPlace& place, const Outcome& outcome, const ReportData& data) {
  const RunAccount account = outcome.statistics ? outcome.statistics->account.value_or(RunAccount()) : RunAccount();
  return data.at(place).in_contact(outcome.reached_time, place.account(account).latest);
}

std::vector<Point> with_contacts(const std::vector<Point>& line, const std::vector<Interval>& contacts,
                                 const std::function<double(double, double)>& value) {
  std::vector<Point> known;
  for (const auto& [begin, end, peak] : contacts) {
    if (line.empty() || begin > line.front().x) known.push_back({begin, value(begin, 0.0)});
    if (peak.y != 0.0) known.push_back({std::clamp(peak.x, begin, end), value(peak.x, peak.y)});
    if (line.empty() || end < line.back().x) known.push_back({end, value(end, 0.0)});
  }
  std::vector<Point> all;
  std::ranges::merge(line, known, std::back_inserter(all), {}, &Point::x, &Point::x);
  return all;
}

Picture reactions(const Case& run, const Outcome& outcome, const ReportData& data) {
  std::vector<TimeLine> lines;
  const auto add = [&](const ReportData::End& trace, const std::vector<Interval>& contacts, plot::Style style,
                       const char* name) {
    lines.push_back(
        {with_contacts(trace.reaction.points(), contacts, [](double, double r) { return r; }), std::move(style), name});
  };
  // Dashed, to be seen where both are equal.
  if (is_obstacle(run.scene.left))
    add(data.left, contacts_of({Where::left}, outcome, data), {plot::series_colour(0), false, 2.4}, "left end");
  if (is_obstacle(run.scene.right))
    add(data.right, contacts_of({Where::right}, outcome, data), {plot::series_colour(1), !lines.empty(), 1.6},
        "right end");
  if (run.scene.span)
    add(data.span, contacts_of({Where::span}, outcome, data), {plot::series_colour(2), false, 1.8}, "span");
  if (lines.empty()) return {};
  return {"Reactions",
          fmt::format(
              "Force of the obstacle on {}, at the output times, and of each contact at its closing, its peak and its "
              "opening.",
              !run.scene.span     ? "each end"
              : lines.size() == 1 ? "the whole span"
                                  : "each end and on the whole span"),
          {{"reactions", "Reactions of the obstacles over time",
            over_time(run, data, on_page(run).heading("reaction R", Dimension::force), 240.0, lines)}}};
}

Picture joint_forces(const Case& run, const Outcome& outcome, const ReportData& data) {
  std::vector<TimeLine> lines;
  for (std::size_t number = 1; number < run.scene.chain.size(); ++number) {
    const JointKind kind = run.scene.chain[number - 1].joint.kind;
    if (kind == JointKind::bonded) continue;
    const std::size_t k = lines.size();
    std::vector<Point> points = data.joints[k].reaction.points();
    if (kind == JointKind::contact)
      points =
          with_contacts(points, contacts_of({Where::joint, number}, outcome, data), [](double, double n) { return n; });
    lines.push_back({std::move(points), {plot::series_colour(k), k % 2 == 1, 1.8}, fmt::format("joint {}", number)});
  }
  if (lines.empty()) return {};
  return {
      "Forces at joints",
      "Force that pushes the two sides of a joint apart, at the output times, and of each contact at its closing, its "
      "peak and its opening.",
      {{"joints", "Forces at joints over time",
        over_time(run, data, on_page(run).heading("force N", Dimension::force), 240.0, lines)}}};
}

Picture energies(const Case& run, const ReportData& data) {
  if (data.energy.front().empty()) return {};
  std::vector<TimeLine> lines;
  for (std::size_t k = 0; k < data.energy.size(); ++k) {
    const auto& [name, drawn, value] = ReportData::energy_columns[k];
    std::vector<Point> points = data.energy[k].points();
    const bool zero = std::ranges::all_of(points, [](const Point& point) { return point.y == 0.0; });
    if (drawn == ReportData::Drawn::with_springs ? data.has_springs() : drawn == ReportData::Drawn::always || !zero)
      lines.push_back({std::move(points), {plot::series_colour(k)}, name});
  }
  lines.back().style = {"var(--ink)", true, 1.6};  // the total
  return {"Energy",
          fmt::format("{} The sum of the total and the dissipated energy changes by the work done on the bar only.{}",
                      data.has_springs() ? "Energy of the bar and that stored in the springs of the contacts."
                                         : "Kinetic and elastic energy of the bar.",
                      run.files.energy ? " energy.csv has the numbers." : ""),
          {{"energy", "Energy over time",
            over_time(run, data, on_page(run).heading("energy", Dimension::energy), 280.0, lines)}}};
}

}  // namespace viscobar
