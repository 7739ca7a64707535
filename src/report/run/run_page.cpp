#include "report/run/run_page.hpp"

#include <fmt/format.h>

#include "case/regime.hpp"
#include "report/number_text.hpp"
#include "results/csv.hpp"
#include "text/number.hpp"
#include "text/table.hpp"

namespace viscobar {

namespace {

constexpr const char* how_far = "How far from the bar itself";

/// Stands where tell_whole_run() puts the time.
constexpr std::string_view whole_run = "<!--whole run-->";

std::string seconds(double value) { return readable(value, 3) + " s"; }

/// True if anything does work on the bar: a load, a force on an end, or what moves ends and obstacles.
bool worked_on(const Scene& scene) {
  const auto drives = [](const EndInput& input) { return input.force || input.motion; };
  return scene.load || drives(scene.left_input) || drives(scene.right_input);
}

std::string numbers(const Setup& setup, const BarSystem& system, const Outcome& outcome, const ReportData& data) {
  const Case& run = setup.run;
  Numbers all;
  const NumberText number = on_page(run);
  const auto with = [&](double value, Dimension quantity, int digits = 4) { return number(value, quantity, digits); };
  all.add("Method", method_words(run));
  if (is_adaptive(run.method)) {
    const Allowance absolute = allowance(run.tolerance, system, run.end);
    all.add("Tolerances", readable(run.tolerance.relative),
            fmt::format("relative; absolute {} of u, {} of v", with(absolute.displacement, Dimension::length),
                        with(absolute.velocity, Dimension::velocity)));
  }
  if (is_scheme(run.method)) all.add("Time step", with(setup.step, Dimension::time));
  if (data.has_springs() && has_penalty(setup.run.scene)) all.add("Penalty ε", number.epsilon(setup.epsilon, 4));
  if (run.restitution && !system.contacts().empty()) all.add("Restitution", readable(*run.restitution));
  all.add("Elements", fmt::format("{}", system.mesh().elements_of_bars()),
          fmt::format("{}, {} mass", element_size(system.mesh(), number), name(system.mass())));
  if (outcome.statistics) all.add("Unknowns", outcome.statistics->unknowns);
  all.add("Simulated time", with(outcome.reached_time, Dimension::time),
          outcome.ending == Ending::completed ? std::string() : "of " + with(run.end, Dimension::time));
  all.add("Steps", outcome.steps);
  if (!system.contacts().empty()) all.add("Contact changes", outcome.events);
  if (const auto& statistics = outcome.statistics) {
    all.add("Evaluations", statistics->rhs_evaluations);
    all.add("Linear solves", statistics->linear_solves);
    all.add("Factorisations", statistics->matrix_factorisations);
    if (!system.contacts().empty())
      all.add("Largest penetration",
              with(above_rounding(statistics->max_penetration, data.field.range().largest()), Dimension::length, 3));
    if (const auto& energy = statistics->energy) {
      const auto add = [&](const char* what, double value, int digits = 4) {
        all.add(what, with(value, Dimension::energy, digits));
      };
      add("Energy at the start", energy->initial);
      add("Energy at the end", energy->final);
      add("Dissipated", energy->dissipated);
      if (energy->end_inertia != 0.0) add("Of it by the mass's end rows", energy->end_inertia);
      if (worked_on(run.scene)) add("Work done on the bar", energy->work);
      add("Energy balance error", energy->balance_error(), 2);
    }
    all.add("Integration", seconds(statistics->integration_seconds));
  }
  all.add("Whole run", std::string(whole_run));
  return all.html("The run in numbers");
}

std::string contact_section(const Setup& setup, const BarSystem& system, const Outcome& outcome) {
  const Case& run = setup.run;
  if (!outcome.statistics || !outcome.statistics->account) return {};
  const RunAccount& account = *outcome.statistics->account;
  const NumberText number = on_page(run);
  Table table{{"where", "closings", number.heading("time in contact", Dimension::time),
               number.heading("impulse of the reaction", Dimension::impulse),
               number.heading("peak reaction", Dimension::force)},
              1,
              {}};
  std::size_t closings = 0;
  for (const ContactPlace& place : contact_places(run.scene)) {
    const ContactAccount of = place.account(account);
    table.rows.push_back({place.joint > 0              ? fmt::format("joint {}", place.joint)
                          : place.where == Where::span ? "span, its nodes together"
                                                       : fmt::format("{} end", name(place.where)),
                          fmt::format("{}", of.closings), readable(of.contact.total(outcome.reached_time)),
                          readable(of.impulse), readable(of.peak_reaction)});
    closings += of.closings;
  }
  if (table.rows.empty()) return {};
  std::vector<std::string> notes;
  const auto remark = peak_remark(setup, system);
  if (remark && closings > 0) notes.push_back("Peak reaction: " + *remark);
  return section_html("Contact", html(table) + notes_html(notes));
}

std::string event_section(const NumberText& number, const Outcome& outcome, const ReportData& data) {
  if (data.first_events.empty()) return {};
  Table table{
      {number.heading("time", Dimension::time), "where", "change", number.heading("velocity", Dimension::velocity)},
      3,
      {}};
  for (const Event& event : data.first_events)
    table.rows.push_back({readable(event.time, 8), place(event), event.change == Change::closing ? "closes" : "opens",
                          readable(event.velocity)});
  std::string rest;
  if (outcome.events > data.first_events.size())
    rest = fmt::format("<p class=\"note\">and {} more, in events.csv</p>", outcome.events - data.first_events.size());
  return fmt::format("<section id=\"events\"><h2>Contact changes</h2>\n<div class=\"still\">{}{}</div></section>\n",
                     html(table), rest);
}

std::string_view of_words(Goal goal) {
  switch (goal) {
    case Goal::displacement: return "of displacements";
    case Goal::end_traces: return "of the ends' displacements";
    case Goal::contact_times: return "of contact times";
    case Goal::impulse: return "of impulses";
    case Goal::peak_reaction: return "of peak reactions";
    case Goal::end_velocity: return "of the ends' velocities";
  }
  return {};
}

Dimension dimension_of(Goal goal) {
  switch (goal) {
    case Goal::contact_times: return Dimension::time;
    case Goal::impulse: return Dimension::impulse;
    case Goal::peak_reaction: return Dimension::force;
    case Goal::end_velocity: return Dimension::velocity;
    default: return Dimension::length;
  }
}

std::string estimate_section(const Case& run, const ErrorEstimate& estimate) {
  Numbers all;
  const auto with = [&](double value, int digits = 2) {
    return on_page(run)(value, dimension_of(estimate.of), digits);
  };
  all.add("Error, estimated", with(estimate.total), of_words(estimate.of));
  all.add("of the mesh", with(estimate.space),
          estimate.order ? fmt::format("observed power {:.2g} of the mesh", *estimate.order) : std::string());
  all.add("of the penalty", with(estimate.penalty));
  all.add("of the time integration", with(estimate.time));
  if (estimate.requested) all.add("asked for", with(*estimate.requested), estimate.kept ? "kept" : "not kept");
  all.add("Largest value", with(estimate.largest, 4));
  if (!estimate.runs.empty()) all.add("Runs for the estimate", estimate.runs.size());
  std::string list;
  for (const std::string& reason : estimate.reasons) list += fmt::format("<li>{}</li>\n", sentence_html(reason));
  return section_html(how_far, all.list() + (list.empty() ? "" : fmt::format("<ul class=\"note\">\n{}</ul>\n", list)));
}

}  // namespace

std::string element_size(const Mesh& mesh, const NumberText& number) {
  const std::string mean = "h = " + number(mesh.spacing(), Dimension::length, 4);
  if (mesh.uniform()) return mean;
  // Given nodes, and those of bars in line, need not be closest at a contact.
  return fmt::format("{} on average, {} {}", mean, number(mesh.smallest(), Dimension::length, 4),
                     mesh.given ? "the least" : "at the contacts");
}

std::vector<std::pair<std::string, std::string>> estimate_rows(const Scene& scene, const ErrorEstimate& estimate) {
  const auto with = [&](double value) { return NumberText::terminal(scene)(value, dimension_of(estimate.of), 2); };
  const std::string_view what = of_words(estimate.of).substr(std::string_view("of ").size());
  std::string text = fmt::format("{} in {}", with(estimate.total), what);
  if (estimate.largest > 0.0) text += " up to " + with(estimate.largest);
  text += fmt::format(" (space {:.2g}, penalty {:.2g}, time {:.2g})", estimate.space, estimate.penalty, estimate.time);
  if (estimate.requested)
    text += fmt::format("; {} asked for: {}", with(*estimate.requested), estimate.kept ? "kept" : "not kept");
  std::vector<std::pair<std::string, std::string>> rows = {{"error, estimated", text}};
  for (const std::string& reason : estimate.reasons) rows.emplace_back("", reason);
  return rows;
}

Page report_page(const Setup& setup, const BarSystem& system, const Outcome& outcome, const ReportData& data) {
  const Case& run = setup.run;
  Page page(run.scene.title.empty() ? "A run of viscobar" : run.scene.title, run.scene);
  if (!outcome.error.empty())
    page.add_head(fmt::format("<p class=\"failed\"><b>The run did not complete.</b> It reached t = {}: {}</p>\n",
                              on_page(run)(outcome.reached_time, Dimension::time, 4), sentence_html(outcome.error)));
  for (const std::string& warning : outcome.warnings)
    page.add_head(fmt::format("<p class=\"warning\"><b>Warning.</b> {}</p>\n", sentence_html(warning)));
  if (data.field.rows() >= 2) {
    const FieldColours colours = field_colours(run, data);
    const FieldColours of_stress = stress_colours(run, data);
    page.add(profiles(run, data));
    page.add(axial_bar(run, data, of_stress));
    page.add(displacement_map(run, data, colours));
    page.add(stress_map(run, system, outcome, data, of_stress));
    page.add(end_traces(run, outcome, data));
    page.add(reactions(run, outcome, data));
    page.add(joint_forces(run, outcome, data));
    page.add(end_tractions(run, system, outcome, data));
    page.add(energies(run, data));
    page.add(gauges(run, data));
    page.add(sensitivities(run, data));
    page.add_data("field", field_json(data.field, colours));
    page.add_data("stress", field_json(data.stress, of_stress));
    page.add_data("axial", axial_json(run, outcome, data));
    page.add_data("units", units_json(run.scene.units));
    page.add_data("events", events_json(data, outcome.events));
    page.add_data("supports", supports_json(run.scene, outcome, data));
  }
  page.add(numbers(setup, system, outcome, data));
  if (outcome.error_estimate) page.add(estimate_section(run, *outcome.error_estimate));
  if (!outcome.no_estimate.empty())
    page.add(
        section_html(how_far, fmt::format("<p>There is no estimate: {}</p>\n", sentence_html(outcome.no_estimate))));
  page.add(contact_section(setup, system, outcome));
  page.add(event_section(on_page(run), outcome, data));
  return page;
}

void tell_whole_run(Page& page, double wall_seconds) { page.fill_in(whole_run, seconds(wall_seconds)); }

}  // namespace viscobar
