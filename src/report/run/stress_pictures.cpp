// Pictures of the stress: its map, the tractions of the ends, and the bar as it lies, coloured by it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "report/run/run_page.hpp"
#include "report/scene_ends.hpp"
#include "scene/unit_names.hpp"
#include "text/number.hpp"

namespace viscobar {

namespace {

using plot::Axis;
using plot::Figure;
using plot::Point;
using plot::Range;

/// 1, 2 or 5 times a power of ten, not above `most`.
double rounded_down(double most) {
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  for (const double digit : {5.0, 2.0})
    if (digit * power <= most) return digit * power;
  return power;
}

struct Moving {
  Figure::Wall wall;
  std::vector<double> places;
};

}  // namespace

FieldColours stress_colours(const Case& run, const ReportData& data) {
  return colours_of(data.stress, with_unit("stress s", run.scene.units, Dimension::stress));
}

namespace {

/// Stress of the first or the last element at the output times, and of each contact what the balance of its end gives,
/// s = -+ (R + F). A penalty, or a step of a scheme, that stops the mass of a node has another R, and a spring, a
/// dashpot or a mass at the end takes a part of it.
std::vector<Point> traction(const Case& run, const BarSystem& system, const Outcome& outcome, const ReportData& data,
                            bool right) {
  const SceneEnd end = ends_of(run.scene)[right];
  std::vector<Point> line = (right ? data.right : data.left).traction.points();
  const bool balanced = run.method == MethodName::characteristics || run.method == MethodName::rigid ||
                        (end.obstacle() && system.massless(system.end(right)));
  const EndInput& input = end.input;
  if (!end.obstacle() || !balanced || input.stiffness > 0.0 || input.dashpot > 0.0 || input.mass > 0.0) return line;
  return with_contacts(line, contacts_of(end.name, outcome, data), [&](double t, double reaction) {
    const double force = reaction + (input.force ? input.force->value(t) : 0.0);
    return right ? force : -force;
  });
}

}  // namespace

Picture stress_map(const Case& run, const BarSystem& system, const Outcome& outcome, const ReportData& data,
                   const FieldColours& colours) {
  const char* formula =
      run.scene.bar.viscosity > 0.0 ? "<i>E u<sub>x</sub></i> + <i>η u<sub>xt</sub></i>" : "<i>E u<sub>x</sub></i>";
  Range ends;
  for (const bool right : {false, true}) ends.add(traction(run, system, outcome, data, right));
  std::string beyond;
  if (ends.low < colours.range.low || ends.high > colours.range.high)
    beyond = fmt::format(" Between the output times the stress of the ends came to {}, beyond the scale.",
                         readable(ends.low < colours.range.low ? ends.low : ends.high, 3));
  return {"Stress over space and time",
          fmt::format("Mean stress <i>s</i> = {} of each element at the output times; tension is positive.{}{}",
                      formula, beyond, map_remark(run, data.stress, colours, "element")),
          {{"stress", "Stress over time and space as a colour map", map_figure(run, data.stress, colours, "s")}}};
}

Picture end_tractions(const Case& run, const BarSystem& system, const Outcome& outcome, const ReportData& data) {
  const std::vector<TimeLine> lines = {
      {traction(run, system, outcome, data, false), {plot::series_colour(0), false, 2.4}, "s(0, t)"},
      {traction(run, system, outcome, data, true), {plot::series_colour(1), true, 1.6}, "s(L, t)"}};
  const bool with = lines[0].points.size() > data.left.traction.points().size() ||
                    lines[1].points.size() > data.right.traction.points().size();
  return {"End tractions",
          fmt::format("Mean stress of the first and of the last element at the output times{}; tension is positive.",
                      with ? ", and the stress at the end where a contact closes, has its peak, and opens" : ""),
          {{"end-stress", "Stress of the first and the last element over time",
            over_time(run, data, with_unit("stress s", run.scene.units, Dimension::stress), 240.0, lines)}}};
}

double axial_magnification(const Case& run, const ReportData& data) {
  const ThinnedField& field = data.field;
  const double length = run.scene.bar.length;
  double largest = 0.0, strain = 0.0;
  for (std::size_t row = 0; row < field.rows(); ++row) {
    const auto u = field.row(row);
    for (std::size_t j = 0; j < u.size(); ++j) {
      if (std::isfinite(u[j])) largest = std::max(largest, std::abs(u[j]));
      if (j > 0 && std::isfinite(u[j] - u[j - 1]))
        strain = std::max(strain, std::abs(u[j] - u[j - 1]) / (field.x()[j] - field.x()[j - 1]));
    }
  }
  // Walls are to be seen, too, as far as they are near.
  for (const SceneEnd& end : ends_of(run.scene))
    if (const Obstacle* wall = end.obstacle()) {
      double far = wall->gap;
      for (const double place : end.surface(field.times())) far = std::max(far, std::abs(place));
      largest = std::max(largest, std::min(far, 3.0 * largest));
    }
  if (!(largest > 0.0)) return 1.0;
  // The order of the points stays, and the bar keeps most of the picture.
  const double most = std::min(0.2 * length / largest, strain > 0.0 ? 0.6 / strain : 1e300);
  return std::isfinite(most) && most > 0.0 ? rounded_down(most) : 1.0;
}

Picture axial_bar(const Case& run, const ReportData& data, const FieldColours& colours) {
  const ThinnedField &field = data.field, &stress = data.stress;
  const double length = run.scene.bar.length, s = axial_magnification(run, data);
  Range range;
  for (std::size_t row = 0; row < field.rows(); ++row) {
    const auto u = field.row(row);
    for (const std::size_t j : {std::size_t{0}, u.size() - 1}) range.add(field.x()[j] + s * u[j]);
  }
  std::vector<Figure::Wall> walls;
  std::vector<Moving> moving;
  std::string hidden;
  for (const SceneEnd& end : ends_of(run.scene)) {
    const Obstacle* obstacle = end.obstacle();
    if (!obstacle) continue;
    const bool above = obstacle->side == Side::above;
    // A wall that bounds the end on its outer side stands there whole; one on the inner side lets the bar pass.
    const Figure::Wall wall{end.x + s * (above ? obstacle->gap : -obstacle->gap), above, above != (end.x > 0.0)};
    std::vector<double> places = end.surface(field.times());
    for (double& place : places) place = end.x + s * place;
    if (places.empty()) places.push_back(wall.at);
    const auto [least, greatest] = std::ranges::minmax(places);
    Range with_it = range;
    if (!with_it.reach(least) || !with_it.reach(greatest)) {
      hidden += fmt::format(" The wall of the {} end lies outside.", end.name);
      continue;
    }
    range = with_it;
    if (end.input.motion)
      moving.push_back({wall, std::move(places)});
    else
      walls.push_back(wall);
  }
  const double room = 0.05 * (range.high - range.low);
  const Axis place{.label = with_unit(s == 1.0 ? "place x + u" : fmt::format("place x + {} u", readable(s)),
                                      run.scene.units, Dimension::length),
                   .low = range.low - room,
                   .high = range.high + room};
  const std::vector<std::size_t> rows = rows_of_few_times(field, 6);
  const Axis down{.label = "", .low = static_cast<double>(rows.size()) - 0.5, .high = -0.5, .bare = true};
  Figure figure(place, down, 60.0 + 42.0 * static_cast<double>(rows.size()));
  const auto place_at = [&](std::size_t row, double x) {  // linear between the nodes
    const auto u = field.row(row);
    const auto& nodes = field.x();
    const auto above = std::upper_bound(nodes.begin(), nodes.end() - 1, x);
    const auto j = static_cast<std::size_t>(std::max<std::ptrdiff_t>(above - nodes.begin(), 1));
    const double part = (x - nodes[j - 1]) / (nodes[j] - nodes[j - 1]);
    return x + s * (u[j - 1] + part * (u[j] - u[j - 1]));
  };
  figure.begin_still();
  for (std::size_t k = 0; k < rows.size(); ++k) {
    std::vector<Figure::ColourStop> stops;
    const auto values = stress.row(rows[k]);
    const std::size_t stride = std::max<std::size_t>(1, values.size() / 60);
    for (std::size_t j = 0; j < values.size(); j += stride)
      stops.push_back({place_at(rows[k], stress.x()[j]), colours.map.at(colours.values.position(values[j]))});
    figure.strip(place_at(rows[k], 0.0), place_at(rows[k], length), static_cast<double>(k), stops,
                 "t = " + readable(field.time(rows[k])));
    for (auto& [wall, places] : moving) {
      wall.at = places[rows[k]];
      wall.part = {static_cast<double>(k) - 0.5, static_cast<double>(k) + 0.5};
      figure.walls(std::span(&wall, 1));
    }
  }
  figure.end_still();
  figure.walls(walls);
  figure.set_live_height(150.0);
  const std::string said = s == 1.0  ? "Displacements are drawn as they are."
                           : s < 1.0 ? fmt::format("Displacements are drawn {} times smaller.", readable(1.0 / s))
                                     : fmt::format("Displacements are magnified by {}.", readable(s));
  std::string hatched;
  for (const auto& [wall, places] : moving) walls.push_back(wall);
  if (!walls.empty()) hatched = " Hatched: walls.";
  if (std::ranges::any_of(walls, &Figure::Wall::open))
    hatched += " A dashed one lets the bar pass and holds its end back.";
  return {"The bar as it lies",
          fmt::format("<span class=\"still\">The bar along its axis at a few times, time downwards, coloured by the "
                      "stress. {0}{1}{2}</span><span class=\"live\">The bar along its axis at the time of the "
                      "slider, coloured by the stress. {0}{1}{2}</span>",
                      said, hatched, hidden),
          {{"axial", "The bar along its axis, coloured by its stress", figure}}};
}

}  // namespace viscobar
