// Pictures of the stress: its map and the tractions of the ends.
#include <fmt/format.h>

#include <vector>

#include "report/run/run_page.hpp"
#include "report/scene_ends.hpp"
#include "text/number.hpp"

namespace viscobar {

namespace {

using plot::Point;
using plot::Range;

}  // namespace

FieldColours stress_colours(const Case& run, const ReportData& data) {
  return colours_of(data.stress, on_page(run).heading("stress s", Dimension::stress));
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
                        (end.obstacle() && system.inertia().massless(system.unknowns().end(right)));
  const EndInput& input = end.input;
  if (!end.obstacle() || !balanced || input.stiffness > 0.0 || input.dashpot > 0.0 || input.mass > 0.0) return line;
  return with_contacts(line, contacts_of(end.place(), outcome, data), [&](double t, double reaction) {
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
                         on_page(run)(ends.low < colours.range.low ? ends.low : ends.high, Dimension::stress));
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
            over_time(run, data, on_page(run).heading("stress s", Dimension::stress), 240.0, lines)}}};
}

}  // namespace viscobar
