#include "report/run/run_page.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "case/regime.hpp"
#include "results/csv.hpp"
#include "text/number.hpp"
#include "text/printable_text.hpp"
#include "text/table.hpp"

namespace viscobar {

namespace {

constexpr const char* how_far = "How far from the bar itself";

std::string seconds(double value) { return readable(value, 3) + " s"; }

std::string numbers(const Case& run, const BarSystem& system, const Outcome& outcome, const ReportData& data) {
  Numbers all;
  all.add("Method", method_words(run));
  if (is_adaptive(run.method)) {
    const Allowance absolute = allowance(run.tolerance, system, run.end);
    all.add("Tolerances", readable(run.tolerance.relative),
            fmt::format("relative; absolute {} of u, {} of v", readable(absolute.displacement),
                        readable(absolute.velocity)));
  }
  if (is_scheme(run.method)) all.add("Time step", readable(scheme_step(run)));
  if (data.has_springs()) all.add("Penalty ε", readable(effective_epsilon(run)));
  if (run.restitution && !system.contacts().empty()) all.add("Restitution", readable(*run.restitution));
  all.add("Elements", fmt::format("{}", system.mesh().elements),
          fmt::format("h = {}{}, {} mass", readable(system.mesh().spacing()),
                      system.mesh().uniform()
                          ? ""
                          : fmt::format(" on average, {} at the contacts", readable(system.mesh().smallest())),
                      name(system.mass())));
  if (outcome.statistics) all.add("Unknowns", outcome.statistics->unknowns);
  all.add("Simulated time", readable(outcome.reached_time),
          outcome.ending == Ending::completed ? std::string() : "of " + readable(run.end));
  all.add("Steps", outcome.steps);
  if (!system.contacts().empty()) all.add("Contact changes", outcome.events);
  if (const auto& statistics = outcome.statistics) {
    all.add("Evaluations", statistics->rhs_evaluations);
    all.add("Linear solves", statistics->linear_solves);
    all.add("Factorisations", statistics->matrix_factorisations);
    if (!system.contacts().empty()) all.add("Largest penetration", readable(statistics->max_penetration, 3));
    if (const auto& energy = statistics->energy) {
      all.add("Energy at the start", readable(energy->initial));
      all.add("Energy at the end", readable(energy->final));
      all.add("Dissipated", readable(energy->dissipated), "work of the load " + readable(energy->work));
      if (energy->end_inertia != 0.0) all.add("Of it by the mass's end rows", readable(energy->end_inertia));
      all.add("Energy balance error", readable(energy->balance_error(), 2));
    }
    all.add("Integration", seconds(statistics->integration_seconds));
  }
  all.add("Whole run", seconds(outcome.wall_seconds));
  return all.html("The run in numbers");
}

std::string contact_section(const Case& run, const BarSystem& system, const Outcome& outcome) {
  if (!outcome.statistics || !outcome.statistics->account) return {};
  const RunAccount& account = *outcome.statistics->account;
  Table table{{"Obstacle", "closings", "time in contact", "impulse of the reaction", "peak reaction"}, 1, {}};
  const auto add = [&](const char* where, bool there, const auto& obstacle) {
    if (there)
      table.rows.push_back({where, fmt::format("{}", obstacle.closings),
                            readable(obstacle.contact.total(outcome.reached_time)), readable(obstacle.impulse),
                            readable(obstacle.peak_reaction)});
  };
  add("left end", is_obstacle(run.scene.left), account.left);
  add("right end", is_obstacle(run.scene.right), account.right);
  add("span, its nodes together", run.scene.span.has_value(), account.span);
  if (table.rows.empty()) return {};
  std::vector<std::string> notes;
  const auto remark = peak_remark(run, system);
  if (remark && account.left.closings + account.right.closings + account.span.closings > 0)
    notes.push_back("Peak reaction: " + *remark);
  return section_html("Contact", html(table) + notes_html(notes));
}

std::string event_section(const Outcome& outcome, const ReportData& data) {
  if (data.first_events.empty()) return {};
  Table table{{"time", "where", "change", "velocity"}, 3, {}};
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

std::string verdict(const ErrorEstimate& estimate) {
  if (!estimate.requested) return "";
  return fmt::format("; {:.2g} asked for: {}", *estimate.requested, estimate.kept ? "kept" : "not kept");
}

std::string estimate_section(const ErrorEstimate& estimate) {
  Numbers all;
  all.add("Error, estimated", readable(estimate.total, 2), of_words(estimate.of));
  all.add("of the mesh", readable(estimate.space, 2),
          estimate.order ? fmt::format("observed power {:.2g} of the mesh", *estimate.order) : std::string());
  all.add("of the penalty", readable(estimate.penalty, 2));
  all.add("of the time integration", readable(estimate.time, 2));
  if (estimate.requested) all.add("asked for", readable(*estimate.requested, 2), estimate.kept ? "kept" : "not kept");
  all.add("Largest value", readable(estimate.largest));
  if (!estimate.runs.empty()) all.add("Runs for the estimate", estimate.runs.size());
  std::string list;
  for (const std::string& reason : estimate.reasons) list += fmt::format("<li>{}</li>\n", escaped(reason));
  return all.html(how_far) + (list.empty() ? "" : fmt::format("<ul class=\"note\">\n{}</ul>\n", list));
}

}  // namespace

std::vector<std::pair<std::string, std::string>> estimate_rows(const ErrorEstimate& estimate) {
  std::vector<std::pair<std::string, std::string>> rows;
  rows.emplace_back("error, estimated", fmt::format("{:.2g} {} (space {:.2g}, penalty {:.2g}, time {:.2g}){}",
                                                    estimate.total, of_words(estimate.of), estimate.space,
                                                    estimate.penalty, estimate.time, verdict(estimate)));
  for (const std::string& reason : estimate.reasons) rows.emplace_back("", reason);
  return rows;
}

Page report_page(const Case& run, const BarSystem& system, const Outcome& outcome, const ReportData& data) {
  Page page(run.scene.title.empty() ? "A run of viscobar" : run.scene.title, run.scene);
  if (!outcome.error.empty())
    page.add_head(fmt::format("<p class=\"failed\"><b>The run did not complete.</b> It reached t = {}: {}</p>\n",
                              readable(outcome.reached_time), escaped(outcome.error)));
  for (const std::string& warning : outcome.warnings)
    page.add_head(fmt::format("<p class=\"warning\"><b>Warning.</b> {}</p>\n", escaped(warning)));
  if (data.field.rows() >= 2) {
    const FieldColours colours = field_colours(run, data);
    const FieldColours of_stress = stress_colours(run, data);
    page.add(profiles(run, data));
    page.add(axial_bar(run, data, of_stress));
    page.add(displacement_map(run, data, colours));
    page.add(stress_map(run, data, of_stress));
    page.add(end_traces(run, outcome, data));
    page.add(reactions(run, data));
    page.add(end_tractions(run, data));
    page.add(energies(run, data));
    page.add(sensitivities(run, data));
    page.add_data("field", field_json(data.field, colours));
    page.add_data("stress", field_json(data.stress, of_stress));
    page.add_data("magnification", fmt::format("{}", axial_magnification(run, data)));
    page.add_data("events", events_json(data, outcome.events));
    page.add_data("supports", supports_json(run.scene, outcome, data));
  }
  page.add(numbers(run, system, outcome, data));
  if (outcome.error_estimate) page.add(estimate_section(*outcome.error_estimate));
  if (!outcome.no_estimate.empty())
    page.add(section_html(how_far, fmt::format("<p>There is no estimate: {}</p>\n", escaped(outcome.no_estimate))));
  page.add(contact_section(run, system, outcome));
  page.add(event_section(outcome, data));
  return page;
}

}  // namespace viscobar
