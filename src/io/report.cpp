#include "io/report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "io/csv.hpp"
#include "io/plot/figure.hpp"
#include "viscobar/io/versions.hpp"

namespace viscobar {

namespace {

using plot::escaped;
using plot::readable;

constexpr std::string_view page_css = R"css(
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink); line-height: 1.5;
  font-family: system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "Liberation Sans", sans-serif; }
main { max-width: 1040px; margin: 0 auto; padding: 40px 24px 64px; }
header { margin-bottom: 28px; }
h1 { font-size: 1.75rem; line-height: 1.2; margin: 0 0 .5rem; font-weight: 650; letter-spacing: -.01em; }
h2 { font-size: 1.05rem; font-weight: 600; margin: 0 0 .75rem; }
.model { margin: 0; color: var(--soft); }
.model i, figcaption i { font-family: "STIX Two Text", "Cambria", "Liberation Serif", Georgia, serif; font-size: 1.05em; }
.failed { border-left: 4px solid var(--series-1); background: var(--paper); padding: 10px 16px; margin: 20px 0 0; }
section, figure { background: var(--paper); border: 1px solid var(--faint); border-radius: 8px; padding: 20px 24px;
  margin: 0 0 20px; }
figcaption { color: var(--soft); font-size: .875rem; margin-top: 8px; }
dl { display: grid; grid-template-columns: repeat(auto-fill, minmax(210px, 1fr)); gap: 14px 24px; margin: 0; }
dt { color: var(--soft); font-size: .8125rem; }
dd { margin: 0; font-size: 1.0625rem; font-variant-numeric: tabular-nums; }
dd small { display: block; line-height: 1.35; color: var(--soft); font-size: .8125rem; }
.tables { overflow-x: auto; }
table { border-collapse: collapse; font-size: .875rem; font-variant-numeric: tabular-nums; }
th { color: var(--soft); font-weight: 500; text-align: right; border-bottom: 1px solid var(--rule); }
th, td { padding: 4px 28px 4px 0; text-align: right; white-space: nowrap; }
th:first-child, td:first-child, .word { text-align: left; }
tbody tr + tr td { border-top: 1px solid var(--faint); }
p.note { color: var(--soft); font-size: .875rem; margin: 10px 0 0; }
footer { color: var(--soft); font-size: .8125rem; }
@media print { body { background: none; } main { padding: 0; max-width: none; } section, figure { break-inside: avoid; } }
)css";

std::string end_text(const EndCondition& end) {
  if (const auto* body = std::get_if<Obstacle>(&end))
    return fmt::format("an obstacle, <i>u</i>\u00a0≥\u00a0{}", readable(body->gap == 0.0 ? 0.0 : -body->gap));
  return is_fixed(end) ? "fixed" : "free";
}

std::string model(const Scene& scene) {
  const Bar& bar = scene.bar;
  const bool damped = bar.viscosity > 0.0;
  std::string load = "0";
  if (scene.load)
    load = std::holds_alternative<SteadyLoad>(*scene.load) ? "<i>f</i>(<i>x</i>)" : "<i>f</i>(<i>x</i>, <i>t</i>)";
  std::string text = fmt::format(
      "<i>ρ u<sub>tt</sub></i> − <i>E u<sub>xx</sub></i>{} = {} on 0 &lt; <i>x</i> &lt; {}, with <i>ρ</i> = {}, "
      "<i>E</i> = {}{}. "
      "Left end {}; right end {}",
      damped ? " − <i>η u<sub>xxt</sub></i>" : "", load, readable(bar.length), readable(bar.density),
      readable(bar.modulus), damped ? ", <i>η</i> = " + readable(bar.viscosity) : "", end_text(scene.left),
      end_text(scene.right));
  if (scene.span)
    text += fmt::format("; under the whole span <i>u</i>\u00a0≥\u00a0{}",
                        readable(scene.span->gap == 0.0 ? 0.0 : -scene.span->gap));
  return text + ".";
}

class Numbers {
 public:
  void add(std::string_view name, const std::string& value, std::string_view remark = {}) {
    html_ += fmt::format("<div><dt>{}</dt><dd>{}", name, value);
    if (!remark.empty()) html_ += fmt::format(" <small>{}</small>", remark);
    html_ += "</dd></div>\n";
  }
  void add(std::string_view name, std::size_t value) { add(name, grouped(value)); }
  std::string html() const { return "<section><h2>The run in numbers</h2>\n<dl>\n" + html_ + "</dl></section>\n"; }

 private:
  static std::string grouped(std::size_t value) {
    std::string digits = fmt::format("{}", value);
    for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, "\u2009");
    return digits;
  }
  std::string html_;
};

std::string seconds(double value) { return readable(value, 3) + " s"; }

std::string numbers(const Case& run, const BarSystem& system, const Outcome& outcome, const ReportData& data) {
  Numbers all;
  all.add("Method", std::string(name(run.method)));
  if (is_adaptive(run.method))
    all.add("Tolerances", readable(run.tolerance.relative),
            "relative, " + readable(run.tolerance.absolute) + " absolute");
  if (is_scheme(run.method) && run.step) all.add("Time step", readable(*run.step));
  if (data.has_springs()) all.add("Penalty ε", readable(*run.epsilon));
  if (run.restitution && !system.contacts().empty()) all.add("Restitution", readable(*run.restitution));
  all.add("Elements", fmt::format("{}", system.mesh().elements),
          fmt::format("h = {}, {} mass", readable(system.mesh().spacing()), name(system.mass())));
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
      all.add("Energy", readable(energy->initial) + " → " + readable(energy->final), "from the start to the end");
      all.add("Dissipated", readable(energy->dissipated), "work of the load " + readable(energy->work));
      all.add("Energy balance error", readable(energy->balance_error(), 2));
    }
    all.add("Integration", seconds(statistics->integration_seconds));
  }
  all.add("Whole run", seconds(outcome.wall_seconds));
  return all.html();
}

std::string contact_table(const Outcome& outcome, const ContactSummary& contact) {
  std::string rows;
  const auto add = [&](const char* where, const std::optional<ContactAccount>& account) {
    if (account)
      rows += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", where,
                          account->closings(), readable(account->duration(outcome.reached_time)),
                          readable(account->impulse()), readable(account->max_reaction()));
  };
  add("left end", contact.left);
  add("right end", contact.right);
  std::string html;
  if (!rows.empty())
    html =
        "<table><thead><tr><th>Obstacle</th><th>closings</th><th>time in contact</th><th>impulse of the reaction</th>"
        "<th>greatest reaction</th></tr></thead><tbody>\n" +
        rows + "</tbody></table>\n";
  if (contact.span)
    html += fmt::format("<p class=\"note\">Under the span: nodes closed {} times and opened {} times.</p>\n",
                        contact.span->closings, contact.span->openings);
  return html.empty() ? html : "<section><h2>Contact</h2>\n<div class=\"tables\">" + html + "</div></section>\n";
}

std::string event_table(const Outcome& outcome, const ReportData& data) {
  if (data.first_events.empty()) return {};
  std::string rows;
  for (const Event& event : data.first_events)
    rows += fmt::format("<tr><td>{}</td><td class=\"word\">{}</td><td class=\"word\">{}</td><td>{}</td></tr>\n",
                        readable(event.time, 8), place(event), event.change == Change::closing ? "closes" : "opens",
                        readable(event.velocity));
  std::string rest;
  if (outcome.events > data.first_events.size())
    rest = fmt::format("<p class=\"note\">and {} more, in events.csv</p>", outcome.events - data.first_events.size());
  return "<section><h2>Contact changes</h2>\n<div class=\"tables\"><table><thead><tr><th>time</th><th "
         "class=\"word\">where</th>"
         "<th class=\"word\">change</th><th>velocity</th></tr></thead><tbody>\n" +
         rows + "</tbody></table>" + rest + "</div></section>\n";
}

}  // namespace

std::string report_html(const Case& run, const BarSystem& system, const Outcome& outcome, const ContactSummary& contact,
                        const ReportData& data) {
  const std::string title = escaped(run.scene.title.empty() ? "A run of viscobar" : run.scene.title);
  std::string pictures;
  if (data.field.rows() >= 2)
    pictures = displacement_map(run, data) + profiles(run, data) + end_traces(run, outcome, contact, data) +
               reactions(run, contact, data) + energies(data);
  const std::string failure =
      outcome.error.empty()
          ? ""
          : fmt::format("<p class=\"failed\"><b>The run did not complete.</b> It reached t = {}: {}</p>\n",
                        readable(outcome.reached_time), escaped(outcome.error));
  const Versions used = versions();
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light "
      "dark\">\n<title>{0}</title>\n<style>{1}{2}</style>\n</head>\n<body>\n<main>\n"
      "<header>\n<h1>{0}</h1>\n<p class=\"model\">{3}</p>\n{4}</header>\n{5}{6}{7}{8}"
      "<footer>viscobar {9}, SUNDIALS {10}, HDF5 {11}, Eigen {12}; {13}. All quantities in the units of the "
      "scene.</footer>\n"
      "</main>\n</body>\n</html>\n",
      title, plot::figure_css(), page_css, model(run.scene), failure, numbers(run, system, outcome, data), pictures,
      contact_table(outcome, contact), event_table(outcome, data), used.viscobar, used.sundials, used.hdf5, used.eigen,
      escaped(used.platform));
}

}  // namespace viscobar
