#include "report/compare/compare_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "case/massless.hpp"
#include "report/plot/axis.hpp"
#include "results/csv.hpp"
#include "text/number.hpp"

namespace viscobar {

namespace {

std::string count(std::size_t value) { return fmt::format("{}", value); }

std::string settings(const MethodRun& method, const NumberText& number) {
  const Case& run = method.setup.run;
  if (!method.built_in) return "";
  if (is_scheme(run.method)) return "step " + number(method.setup.step, Dimension::time);
  if (is_adaptive(run.method)) return "tolerance " + number(run.tolerance.relative);
  return "";
}

}  // namespace

std::string place(const ContactPeriod& period) { return place(Event{period.begin, period.where, period.node}); }

namespace {

std::function<Cell(const ComparedRun&)> of_recording(auto value) {
  return [value](const ComparedRun& row) { return row.run->recording ? cell(value(*row.run->recording)) : Cell(); };
}
/// A setting of the built-in methods that have it.
Column<ComparedRun> of_setup(const char* key, bool has(MethodName), auto value) {
  return {key, key, [=](const ComparedRun& row) {
            const Setup& of = row.run->setup;
            return row.run->built_in && has(of.run.method) ? cell(value(of)) : Cell();
          }};
}
std::function<Cell(const ComparedRun&)> of_energy(double EnergyAccount::*member) {
  return of_recording([member](const Recording& recording) {
    const auto& energy = recording.statistics.energy;
    return energy ? std::optional((*energy).*member) : std::nullopt;
  });
}
/// For people: nothing that is rounding of the ends' displacements.
std::string penetration(const ComparedRun& row, const NumberText& number) {
  const auto& recording = row.run->recording;
  if (!recording) return "";
  plot::Range ends;
  for (std::size_t k = 0; k < recording->times.size(); ++k)
    for (const double u : {recording->displacement(k).front(), recording->displacement(k).back()}) ends.add(u);
  return number(above_rounding(recording->statistics.max_penetration, ends.largest()));
}
std::function<Cell(const ComparedRun&)> of_difference(auto Difference::*member) {
  return [member](const ComparedRun& row) { return row.difference ? cell((*row.difference).*member) : Cell(); };
}

}  // namespace

const std::vector<Column<ComparedRun>>& compare_columns() {
  using Row = ComparedRun;
  const auto energy = [](const char* key, const char* heading, double EnergyAccount::*member) {
    Column<Row> column{key, heading, of_energy(member)};
    column.digits = 5;
    return std::move(column).in(Dimension::energy);
  };
  const auto difference = [](const char* key, const char* heading, auto Difference::*member) {
    return Column<Row>{key, heading, of_difference(member)};
  };
  static const std::vector<Column<Row>> columns = {
      {"method", "method", [](const Row& row) { return cell(row.run->label); }},
      {"mass", "mass", [](const Row& row) { return cell(name(row.run->setup.mass)); }},
      {"settings", "settings", [](const Row&) { return Cell(); },
       [](const Row& row, const NumberText& number) { return settings(*row.run, number); }, true},
      of_setup("step", is_scheme, [](const Setup& of) { return of.step; }),
      of_setup("relative_tolerance", is_adaptive, [](const Setup& of) { return of.run.tolerance.relative; }),
      of_setup("epsilon", is_penalised,
               [](const Setup& of) { return has_penalty(of.run.scene) ? std::optional(of.epsilon) : std::nullopt; }),
      {"steps", "steps", of_recording([](const Recording& of) { return of.statistics.steps; })},
      {"seconds", "seconds", of_recording([](const Recording& of) { return of.statistics.integration_seconds; })},
      {"events", "changes", of_recording([](const Recording& of) { return of.events.size(); })},
      Column<Row>{"max_penetration", "penetration",
                  of_recording([](const Recording& of) { return of.statistics.max_penetration; }), penetration}
          .in(Dimension::length),
      energy("energy_final", "final energy", &EnergyAccount::final),
      energy("energy_dissipated", "dissipated", &EnergyAccount::dissipated),
      difference("displacement_l2", "u, L2", &Difference::displacement_l2).in(u_norm),
      difference("displacement_h1", "u, H1", &Difference::displacement_h1).in(strain_norm),
      difference("velocity_l2", "v, L2", &Difference::velocity_l2).in(v_norm),
      difference("end_trace", "end trace", &Difference::end_trace).in(Dimension::length),
      {"events_matched", "changes matched", of_difference(&Difference::events_matched),
       [](const Row& row, const NumberText&) {
         const Difference& d = *row.difference;
         return fmt::format("{} of {} and {}", d.events_matched, d.events, d.events_other);
       }},
      difference("largest_event_shift", "largest shift", &Difference::largest_event_shift).in(Dimension::time),
      difference("energy_difference", "final energy", &Difference::energy_final).in(Dimension::energy),
      {"error", "error", [](const Row& row) { return cell(row.run->error); }}};
  return columns;
}

std::vector<ComparedRun> compared_runs(const Comparison& check, const DifferenceOf& difference) {
  std::vector<ComparedRun> rows;
  for (std::size_t i = 0; i < check.runs.size(); ++i) rows.push_back({&check.runs[i], difference(i)});
  return rows;
}

Table method_table(const Comparison& check, const NumberText& number) {
  Table table = table_of(pick(compare_columns(), {"method", "mass", "settings", "steps", "seconds", "events",
                                                  "max_penetration", "energy_final", "energy_dissipated"}),
                         compared_runs(check, [](std::size_t) { return nullptr; }), number, 3);
  for (std::size_t i = 0; i < check.runs.size(); ++i)
    if (!check.runs[i].recording) end_row(table, i, "failed");
  return table;
}

Table difference_table(const Comparison& check, const NumberText& number) {
  return difference_table(check, number, "method", [&](std::size_t run) { return check.to_reference(run); });
}

Table difference_table(const Comparison& check, const NumberText& number, const std::string& what,
                       const DifferenceOf& difference) {
  std::vector<ComparedRun> rows = compared_runs(check, difference);
  std::erase_if(rows, [](const ComparedRun& row) { return !row.difference; });
  Table table =
      table_of(pick(compare_columns(), {"method", "mass", "displacement_l2", "displacement_h1", "velocity_l2",
                                        "end_trace", "events_matched", "largest_event_shift", "energy_difference"}),
               rows, number, 2);
  table.header.front() = what;
  return table;
}

Table contact_table(const Comparison& check, const NumberText& number) {
  Table table{{"where", "method", number.heading("begin", Dimension::time), number.heading("end", Dimension::time),
               number.heading("impulse", Dimension::impulse), "bounces"},
              2,
              {}};
  if (!check.reference) return table;
  // Each period of the reference with those that match it; what has no match stands alone, where its time puts it.
  struct Group {
    ContactPeriod first;
    std::vector<std::vector<std::string>> rows;
  };
  using Key = std::tuple<Where, std::size_t, double>;
  const auto key = [](const ContactPeriod& period) { return Key{period.where, period.node, period.begin}; };
  std::vector<Group> groups;
  std::map<Key, std::size_t> of_reference;
  for (std::size_t i = 0; i < check.runs.size(); ++i) {
    const MethodRun& run = check.runs[i];
    std::map<Key, std::size_t> matched;
    if (const Difference* difference = check.to_reference(i))
      for (const auto& [first, other] : difference->contacts) matched[key(other)] = of_reference.at(key(first));
    for (const ContactPeriod& period : run.contacts) {
      const auto found = matched.find(key(period));
      const std::size_t group = found == matched.end() ? groups.size() : found->second;
      if (group == groups.size()) groups.push_back({period, {}});
      if (i == *check.reference) of_reference[key(period)] = group;
      groups[group].rows.push_back({place(period), run.label, number(period.begin, 6), number(period.end, 6),
                                    period.impulse ? number(*period.impulse) : "", count(period.bounces)});
    }
  }
  std::ranges::stable_sort(groups, {}, [](const Group& group) { return group.first.begin; });
  if (groups.size() > most_contacts) groups.resize(most_contacts);
  for (Group& group : groups)
    for (auto& row : group.rows) table.rows.push_back(std::move(row));
  return table;
}

std::string contact_text(const Comparison& check, const NumberText& number) {
  const Table contacts = contact_table(check, number);
  if (contacts.rows.empty()) return {};
  return "\nContact periods, bounces within a hundredth of the run counted as one\n" + text(contacts);
}

std::vector<std::string> remarks(const MethodChoice& choice, const Comparison& check) {
  std::vector<std::string> found = choice.remarks;
  for (const MethodRun& run : check.runs)
    if (!run.recording) found.push_back(fmt::format("{} failed: {}", run.label, run.error));
  for (const MethodName method : choice.default_step)
    for (const Case& run : choice.cases)
      if (run.method == method)
        found.push_back(fmt::format("{} took the step {}: the scene has no method.step", name(method),
                                    NumberText::terminal(run.scene)(*run.step, Dimension::time, 4)));
  for (const auto& [method, reason] : choice.skipped)
    found.push_back(fmt::format("{} was left out: {}", name(method), reason));
  std::map<Mass, std::string> masses;
  for (const MethodRun& run : check.runs)
    if (run.built_in) masses[run.setup.mass] += (masses[run.setup.mass].empty() ? "" : ", ") + run.label;
  if (masses.size() > 1) {
    std::string each;
    for (const auto& [mass, methods] : masses)
      each += fmt::format("{}{} by {}", each.empty() ? "" : "; ", name(mass), methods);
    found.push_back(
        "The masses differ, so a difference is also one between semi-discretisations of the same bar, "
        "which only a finer mesh removes: " +
        each);
  }
  const bool penalty = std::ranges::any_of(check.runs, [](const MethodRun& run) {
    return run.built_in && is_penalised(run.setup.run.method) && meets_obstacle(run.setup.run.scene);
  });
  const bool exact = std::ranges::any_of(check.runs, [](const MethodRun& run) {
    const auto& [label, built_in, setup, recording, contacts, error, index] = run;
    return built_in && (is_scheme(setup.run.method) ||
                        (setup.run.method == MethodName::rigid && !are_massless(setup.run.scene, setup.mass)));
  });
  const Case& first = check.runs.front().setup.run;
  if (penalty && exact && !first.restitution && !are_massless(first.scene, resolve(first).mass))
    found.push_back(
        std::string("Contact nodes with mass rebound from an undamped penalty and do not from an exact constraint; "
                    "contact.restitution gives both the same law") +
        (may_be_massless(first) ? ", mesh.mass = \"redistributed\" takes the mass away" : ""));
  return found;
}

}  // namespace viscobar
