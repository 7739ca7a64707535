#include "report/compare/compare_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "results/csv.hpp"

namespace viscobar {

namespace {

// Contacts of a span come node by node; a table of them all would tell nobody anything.
constexpr std::size_t most_contacts = 30;

std::string count(std::size_t value) { return fmt::format("{}", value); }

std::string settings(const MethodRun& method, NumberText number) {
  const Case& run = method.setup.run;
  if (!method.built_in) return "";
  if (is_scheme(run.method)) return "step " + number(method.setup.step);
  if (is_adaptive(run.method)) return "tolerance " + number(run.tolerance.relative);
  return "";
}

}  // namespace

std::string place(const ContactPeriod& period) { return place(Event{period.begin, period.where, period.node}); }

Table method_table(const Comparison& check, NumberText number) {
  Table table{
      {"method", "mass", "settings", "steps", "seconds", "changes", "penetration", "final energy", "dissipated"},
      3,
      {}};
  for (const MethodRun& run : check.runs) {
    std::vector<std::string> row = {run.label, std::string(name(run.setup.mass)), settings(run, number), "failed"};
    if (run.recording) {
      const Statistics& s = run.recording->statistics;
      const auto energy = [&](double EnergyAccount::*member) { return s.energy ? number((*s.energy).*member, 5) : ""; };
      row.back() = count(s.steps);
      row.insert(row.end(),
                 {number(s.integration_seconds), count(run.recording->events.size()), number(s.max_penetration),
                  energy(&EnergyAccount::final), energy(&EnergyAccount::dissipated)});
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table difference_table(const Comparison& check, NumberText number) {
  return difference_table(check, number, "method", [&](std::size_t run) { return check.to_reference(run); });
}

Table difference_table(const Comparison& check, NumberText number, const std::string& what,
                       const std::function<const Difference*(std::size_t run)>& difference) {
  Table table{
      {what, "mass", "u, L2", "u, H1", "v, L2", "end trace", "changes matched", "largest shift", "final energy"},
      2,
      {}};
  for (std::size_t i = 0; i < check.runs.size(); ++i) {
    const Difference* d = difference(i);
    if (!d) continue;
    const auto known = [&](const std::optional<double>& value) { return value ? number(*value) : std::string(); };
    table.rows.push_back({check.runs[i].label, std::string(name(check.runs[i].setup.mass)), known(d->displacement_l2),
                          known(d->displacement_h1), known(d->velocity_l2), number(d->end_trace),
                          fmt::format("{} of {}, {}", d->events_matched, d->events, d->events_other),
                          known(d->largest_event_shift), known(d->energy_final)});
  }
  return table;
}

Table contact_table(const Comparison& check, NumberText number) {
  Table table{{"where", "method", "begin", "end", "impulse", "bounces"}, 2, {}};
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
                                    period.where == Where::span ? "" : number(period.impulse), count(period.bounces)});
    }
  }
  std::ranges::stable_sort(groups, {}, [](const Group& group) { return group.first.begin; });
  if (groups.size() > most_contacts) groups.resize(most_contacts);
  for (Group& group : groups)
    for (auto& row : group.rows) table.rows.push_back(std::move(row));
  return table;
}

std::string contact_text(const Comparison& check) {
  const Table contacts = contact_table(check, plain_number);
  if (contacts.rows.empty()) return {};
  return "\nContact periods, bounces within a hundredth of the run counted as one\n" + text(contacts);
}

std::vector<std::string> remarks(const MethodChoice& choice, const Comparison& check) {
  std::vector<std::string> found;
  for (const MethodRun& run : check.runs)
    if (!run.recording) found.push_back(fmt::format("{} failed: {}", run.label, run.error));
  for (const MethodName method : choice.default_step)
    for (const Case& run : choice.cases)
      if (run.method == method)
        found.push_back(fmt::format("{} took the step h / (100 c) = {:.4g}: the scene has no method.step", name(method),
                                    *run.step));
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
    const auto& [label, built_in, setup, recording, contacts, error] = run;
    return built_in && (is_scheme(setup.run.method) ||
                        (setup.run.method == MethodName::rigid && setup.mass != Mass::redistributed));
  });
  const Case& first = check.runs.front().setup.run;
  if (penalty && exact && !first.restitution && first.mass != Mass::redistributed)
    found.push_back(
        "Contact nodes with mass rebound from an undamped penalty and do not from an exact constraint; "
        "contact.restitution gives both the same law, mesh.mass = \"redistributed\" takes the mass away");
  return found;
}

}  // namespace viscobar
