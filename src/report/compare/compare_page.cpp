#include <fmt/format.h>

#include <set>

#include "case/method_table.hpp"
#include "report/compare/compare_tables.hpp"
#include "report/page.hpp"
#include "report/run/run_data.hpp"
#include "report/run/run_page.hpp"
#include "report/scene_ends.hpp"
#include "results/csv.hpp"
#include "results/json.hpp"
#include "studies/touch.hpp"
#include "text/printable_text.hpp"
#include "viscobar/report/reports.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar {

namespace {

using plot::Axis;
using plot::Figure;
using plot::Interval;
using plot::Point;
using plot::Range;

/// A method has the same colour and dashes in every picture, whatever else is there. No two methods have both alike.
std::size_t series(const MethodRun& run) {
  return run.built_in ? static_cast<std::size_t>(run.setup.run.method) : std::size(all_methods) + run.index;
}
bool plain(const MethodRun& run) { return !run.built_in && run.index == 0; }
std::string colour(const MethodRun& run) { return plain(run) ? "var(--ink)" : plot::series_colour(series(run)); }
plot::Style style(const MethodRun& run, double width) {
  return {colour(run), false, width, plain(run) ? 0 : series(run)};
}

const std::string& label(const MethodRun& run) { return run.label; }

std::vector<const MethodRun*> finished(const Comparison& check) {
  std::vector<const MethodRun*> runs;
  for (const MethodRun& run : check.runs)
    if (run.recording) runs.push_back(&run);
  return runs;
}

template <class Value>
std::vector<Point> trace(const Recording& recording, Value value) {
  plot::ThinnedLine line(240);  // eight methods, five pictures
  for (std::size_t k = 0; k < recording.times.size(); ++k) line.add({recording.times[k], value(k)});
  return line.points();
}

std::string in_unit(const Comparison& check, std::string_view words, auto quantity) {
  return NumberText::page(check.runs[*check.reference].setup.run.scene).heading(words, quantity);
}

Axis time_axis(const Comparison& check) {
  const std::vector<double>& times = check.runs[*check.reference].recording->times;
  return {.label = in_unit(check, "time t", Dimension::time), .low = times.front(), .high = times.back(), .link = "t"};
}

/// A line of each method and the range of them all.
struct Traces {
  std::vector<const MethodRun*> runs;
  std::vector<std::vector<Point>> lines{};
  Range range{};

  template <class Value>
  Traces(std::vector<const MethodRun*> of, Value value) : runs(std::move(of)) {
    for (const MethodRun* run : runs) {
      lines.push_back(trace(*run->recording, [&](std::size_t k) { return value(*run->recording, k); }));
      range.add(lines.back());
    }
  }

  /// Over each other, each thinner than the one below, so that all show where they coincide.
  void draw(Figure& figure) const {
    for (std::size_t i = 0; i < runs.size(); ++i)
      figure.line(lines[i], style(*runs[i], 1.4 + 1.1 * static_cast<double>(runs.size() - 1 - i)), label(*runs[i]));
  }
};

Picture ends_picture(const Scene& scene, const Comparison& check) {
  std::vector<Panel> panels;
  for (const SceneEnd& end : ends_of(scene)) {
    const bool left = end.name == "left";
    Traces traces(finished(check), [&](const Recording& recording, std::size_t k) {
      return left ? recording.displacement(k).front() : recording.displacement(k).back();
    });
    const std::vector<double>& times = traces.runs.front()->recording->times;
    const std::vector<Point> surface = plot::points_of(times, end.surface(times));
    traces.range.add(surface);
    const std::vector<ObstacleLevel> levels = levels_of(surface.empty() ? end.obstacle() : nullptr);
    const bool shown = !levels.empty() && traces.range.reach(levels.front().u);
    const std::string axis = left ? "u(0, t)" : "u(L, t)";
    Figure figure(time_axis(check), traces.range.axis(in_unit(check, axis, Dimension::length)), 240.0);
    if (shown) figure.level(levels.front().u, {"var(--ink)", true, 1.2}, "obstacle");
    if (!surface.empty()) figure.line(surface, {"var(--ink)", true, 1.2}, "obstacle");
    traces.draw(figure);
    panels.push_back(
        {fmt::format("displacement-{}", end.name), "Displacement over time by each method: " + axis, figure});
  }
  return {
      "Ends",
      "Displacement of the left and of the right end. Lines lie over each other from wide to narrow, so that all show "
      "where the methods agree.",
      panels};
}

Picture differences_picture(const Comparison& check) {
  const MethodRun& reference = check.runs[*check.reference];
  const Recording& r = *reference.recording;
  std::vector<const MethodRun*> runs;
  std::vector<std::vector<Point>> lines;
  double low = std::numeric_limits<double>::infinity(), high = 0.0;
  std::vector<double> difference(r.mesh.nodes());
  for (std::size_t i = 0; i < check.runs.size(); ++i) {
    const Difference* known = check.to_reference(i);
    if (!known || !known->displacement_l2) continue;  // a scheme that gives its ends only has no field to show
    runs.push_back(&check.runs[i]);
    lines.push_back(trace(r, [&](std::size_t k) {
      const auto u = r.displacement(k), other = check.runs[i].recording->displacement(k);
      for (std::size_t j = 0; j < u.size(); ++j) difference[j] = u[j] - other[j];
      const double size = l2_norm(r.mesh, difference);
      if (size > 0.0) low = std::min(low, size), high = std::max(high, size);
      return size;
    }));
  }
  if (!(high > 0.0)) return {};
  // Equal but for rounding at the start: the picture needs not show how equal.
  Figure figure(time_axis(check),
                plot::fitted_decades(in_unit(check, "difference, L2 norm", u_norm), std::max(low, 1e-9 * high), high),
                300.0);
  for (std::size_t i = 0; i < runs.size(); ++i) figure.line(lines[i], style(*runs[i], 1.6), label(*runs[i]));
  return {"Difference to " + label(reference),
          "‖<i>u</i> − <i>u</i><sub>" + label(reference) + "</sub>‖ in <i>L</i>² over the bar, at the output times.",
          {{"difference", "Difference of each method to the reference over time", figure}}};
}

/// Times with at least one contact closed there.
std::vector<Interval> contact_intervals(const Recording& recording, const ContactPlace& place) {
  plot::ThinnedIntervals all;
  const auto changes = changes_at(recording.events, place.where, place.joint);
  for (const Touch& touch : touches(changes, [](auto&&...) { return false; }))
    all.add({touch.begin(), touch.end(recording.times.back())});
  return all.intervals();
}

Picture contacts_picture(const Scene& scene, const Comparison& check) {
  const auto runs = finished(check);
  std::vector<Panel> panels;
  for (const ContactPlace& place : contact_places(scene)) {
    const std::string of(name(place.where)), number = place.joint > 0 ? std::to_string(place.joint) : "";
    const bool at_end = place.where == Where::left || place.where == Where::right;
    const std::string axis = at_end ? of + " end" : number.empty() ? of : of + " " + number;
    const double rows = static_cast<double>(runs.size());
    Axis down{.label = axis, .low = rows - 0.5, .high = -0.5, .bare = true};
    for (const MethodRun* run : runs) down.rows.push_back(label(*run));
    Figure figure(time_axis(check), std::move(down), plot::height_of_bars(runs.size()));
    for (std::size_t i = 0; i < runs.size(); ++i)
      figure.bars(contact_intervals(*runs[i]->recording, place), static_cast<double>(i), colour(*runs[i]),
                  label(*runs[i]));
    panels.push_back(
        {"contact-" + of + (number.empty() ? "" : "-" + number), "Times in contact by each method: " + axis, figure});
  }
  return {"Contact",
          std::string("Times in contact. A bar broken into short pieces is a node that chatters.") +
              (scene.span ? " Under the span: times when any node is in contact." : ""),
          panels};
}

Picture reactions_picture(const Scene& scene, const Comparison& check) {
  std::vector<Panel> panels;
  for (const SceneEnd& end : ends_of(scene)) {
    if (!scene.span && !end.obstacle()) continue;
    const auto reaction = end.name == "left" ? &Recording::reaction_left : &Recording::reaction_right;
    std::vector<const MethodRun*> runs = finished(check);
    std::erase_if(runs, [&](const MethodRun* run) { return ((*run->recording).*reaction).empty(); });
    if (runs.empty()) continue;
    Traces traces(std::move(runs), [&](const Recording& recording, std::size_t k) { return (recording.*reaction)[k]; });
    traces.range.add(0.0);
    const std::string axis = fmt::format("reaction, {}", end.name);
    Figure figure(time_axis(check), traces.range.axis(in_unit(check, axis, Dimension::force)), 240.0);
    traces.draw(figure);
    panels.push_back({fmt::format("reaction-{}", end.name), "Reaction over time by each method: " + axis, figure});
  }
  return {"Reactions",
          "Force of the obstacle on each end, at the output times: of a node that chatters, single samples.", panels};
}

Picture difference_map(const Comparison& check) {
  const auto runs = finished(check);
  if (runs.size() != 2 || !check.pairs.front().difference.displacement_l2 || runs[0]->recording->mesh.elements == 1)
    return {};
  const Recording &first = *runs[0]->recording, &other = *runs[1]->recording;
  ThinnedField field(first.mesh);
  for (std::size_t k = 0; k < first.times.size(); ++k)
    field.add_each(first.times[k],
                   [a = first.displacement(k), b = other.displacement(k)](std::size_t j) { return b[j] - a[j]; });
  const FieldColours colours = colours_of(field, in_unit(check, "difference", Dimension::length), true);
  const Case& run = runs[0]->setup.run;
  return {"Difference over space and time",
          fmt::format("<i>u</i> of {} less that of {}.", escaped(label(*runs[1])), escaped(label(*runs[0]))) +
              map_remark(run, field, colours, "node"),
          {{"difference-map", "Difference of the two runs over time and space as a colour map",
            map_figure(run, field, colours, "difference")}}};
}

Json to_json(const ContactPeriod& period) {
  return {{"begin", period.begin},
          {"end", period.end},
          {"impulse", period.impulse ? Json(*period.impulse) : Json(nullptr)},
          {"bounces", period.bounces}};
}

Json to_json(const MethodRun& run) {
  const Case& of = run.setup.run;
  Json json = {{"method", run.label}, {"mass", name(run.setup.mass)}};
  if (run.built_in && is_scheme(of.method)) json["step"] = run.setup.step;
  if (run.built_in && is_adaptive(of.method)) {
    json["relative_tolerance"] = of.tolerance.relative;
    json["absolute_tolerance"] = to_json(allowance(of.tolerance, run.setup.system(), of.end));
  }
  if (run.built_in && is_penalised(of.method) && has_penalty(of.scene)) json["epsilon"] = run.setup.epsilon;
  if (of.restitution) json["restitution"] = *of.restitution;
  json["completed"] = run.recording.has_value();
  json["error"] = run.recording ? Json(nullptr) : Json(run.error);
  if (!run.recording) return json;
  const Statistics& s = run.recording->statistics;
  json["unknowns"] = s.unknowns;
  json["steps"] = s.steps;
  json["integration_seconds"] = s.integration_seconds;
  json["events"] = run.recording->events.size();
  json["max_penetration"] = s.max_penetration;
  if (s.energy) json["energy"] = to_json(*s.energy);
  json["contacts"] = Json::array();
  for (const ContactPeriod& period : run.contacts) {
    Json contact = {{"where", place(period)}};
    contact.update(to_json(period));
    json["contacts"].push_back(std::move(contact));
  }
  return json;
}

std::string json_text_of(const SceneFile& scene, const MethodChoice& choice, const Comparison& check) {
  const auto method = [&](std::size_t i) { return Json(check.runs[i].label); };
  Json json = Json::object();
  json["title"] = scene.run.scene.title;
  json["reference"] = check.reference ? method(*check.reference) : Json(nullptr);
  json["completed"] = check.completed();
  json["methods"] = Json::array();
  for (const MethodRun& run : check.runs) json["methods"].push_back(to_json(run));
  json["pairs"] = Json::array();
  for (const auto& [first, other, d] : check.pairs) {
    Json pair = {{"first", method(first)},
                 {"other", method(other)},
                 {"displacement_l2", d.displacement_l2},
                 {"displacement_h1", d.displacement_h1},
                 {"velocity_l2", d.velocity_l2},
                 {"end_trace", d.end_trace},
                 {"events_first", d.events},
                 {"events_other", d.events_other},
                 {"events_matched", d.events_matched},
                 {"largest_event_shift", d.largest_event_shift},
                 {"energy_final", d.energy_final},
                 {"contacts", Json::array()}};
    for (const auto& [a, b] : d.contacts)
      pair["contacts"].push_back({{"where", place(a)}, {"first", to_json(a)}, {"other", to_json(b)}});
    json["pairs"].push_back(std::move(pair));
  }
  json["skipped"] = Json::array();
  for (const auto& [skipped, reason] : choice.skipped)
    json["skipped"].push_back({{"method", name(skipped)}, {"reason", reason}});
  json["remarks"] = remarks(choice, check);
  tell(json, scene);
  // A mass that the scene leaves open is the one of all methods that have a choice, where they have one.
  std::set<Mass> masses;
  for (const MethodRun& run : check.runs)
    if (run.built_in && !method_row(run.setup.run.method).mass) masses.insert(run.setup.mass);
  if (masses.size() == 1 && json["chosen"].contains("mesh") && json["chosen"]["mesh"].contains("mass"))
    json["chosen"]["mesh"]["mass"] = json["scene"]["mesh"]["mass"] = name(*masses.begin());
  json["version"] = versions().viscobar;
  return json_text(json);
}

std::string terminal_text(const MethodChoice& choice, const Comparison& check) {
  const NumberText number = NumberText::terminal(check.runs.front().setup.run.scene);
  std::string out = "Methods\n" + text(method_table(check, number));
  if (const Table differences = difference_table(check, number); !differences.rows.empty())
    out +=
        fmt::format("\nDifference to {}: largest over time\n", label(check.runs[*check.reference])) + text(differences);
  out += contact_text(check, number);
  out += "\n";
  for (const std::string& remark : remarks(choice, check)) out += fmt::format("  note: {}\n", remark);
  return out;
}

PicturedPage page_of(const Scene& scene, const MethodChoice& choice, const Comparison& check) {
  const NumberText number = NumberText::page(scene);
  Page page = Page::of_study(scene, choice.cases.empty() ? ", results beside each other" : ", by several methods");
  for (const MethodRun& run : check.runs)
    if (!run.recording)
      page.add_head(fmt::format("<p class=\"failed\"><b>{} did not complete.</b> {}</p>\n", escaped(label(run)),
                                sentence_html(run.error)));
  page.add_section(choice.cases.empty() ? "Runs" : "Methods", html(method_table(check, number)));
  if (!check.reference) return page.with_figures();
  if (const Table differences = difference_table(check, number); !differences.rows.empty())
    page.add_section("Difference to " + label(check.runs[*check.reference]),
                     html(differences) +
                         "<p class=\"note\">Largest over the output times; changes matched: place by place and in "
                         "order of time, of those of the reference and of the method.</p>\n" +
                         notes_html(remarks(choice, check)));
  page.add(ends_picture(scene, check));
  page.add(differences_picture(check));
  page.add(difference_map(check));
  page.add(contacts_picture(scene, check));
  page.add(reactions_picture(scene, check));
  if (const Table contacts = contact_table(check, number); !contacts.rows.empty())
    page.add_section("Contact periods",
                     html(contacts) +
                         "<p class=\"note\">Bounces within a hundredth of the run count as one contact. "
                         "The impulse is that of the reaction.</p>\n");
  return page.with_figures();
}

}  // namespace

StudyReport compare_report(const SceneFile& scene, const MethodChoice& choice, const Comparison& check) {
  return {json_text_of(scene, choice, check), page_of(scene.run.scene, choice, check), terminal_text(choice, check),
          csv_of(pick(compare_columns(), {"method", "mass", "step", "relative_tolerance", "epsilon", "steps", "seconds",
                                          "events", "max_penetration", "energy_final", "energy_dissipated",
                                          "displacement_l2", "displacement_h1", "velocity_l2", "end_trace",
                                          "events_matched", "largest_event_shift", "energy_difference", "error"}),
                 compared_runs(check, [&](std::size_t run) { return check.to_reference(run); }))};
}

}  // namespace viscobar
