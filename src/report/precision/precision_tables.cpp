#include "report/precision/precision_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "case/massless.hpp"

namespace viscobar {

namespace {

/// A measured error that its reference can tell from its own, else the bound that remains.
std::string measured(const std::optional<double>& error, double reference_error, const NumberText& number) {
  if (!error) return "-";
  return resolved(*error, reference_error) ? number(*error) : fmt::format("<{}", number(*error + reference_error));
}

std::string part_text(const std::optional<double>& value, const NumberText& number) {
  return value ? number(*value) : "-";
}

/// The time error of a scheme that has stopped falling over the last halvings of its step.
std::optional<double> stagnation(const PrecisionResult& result, const ErrorParts& parts) {
  constexpr std::size_t halvings = 3;
  const auto rows = rows_of(result, parts);
  if (!is_scheme(parts.method) || rows.size() <= halvings) return std::nullopt;
  const auto first = rows[rows.size() - 1 - halvings].time_error, last = rows.back().time_error;
  if (!first || !last || *last < 10.0 * parts.time_reference_error || *first > 1.5 * *last) return std::nullopt;
  return last;
}

}  // namespace

std::string setting_text(MethodName method, double setting, const NumberText& number) {
  return is_scheme(method) ? "step " + number(setting, Dimension::time) : "tolerance " + number(setting);
}

bool resolved(double error, double reference_error) { return error > 3.0 * reference_error; }

const char* setting_word(MethodName method) { return is_scheme(method) ? "step" : "tolerance"; }

std::span<const PrecisionRow> rows_of(const PrecisionResult& result, const ErrorParts& parts) {
  const auto same = [&](const PrecisionRow& row) {
    return row.method == parts.method && row.elements == parts.elements;
  };
  const auto begin = std::find_if(result.rows.begin(), result.rows.end(), same);
  const auto end = std::find_if_not(begin, result.rows.end(), same);
  return {begin, end};
}

std::optional<double> resolved_time_error(const PrecisionResult& result, const PrecisionRow& row) {
  const double own = result.parts_of(row).time_reference_error;
  return row.time_error && resolved(*row.time_error, own) ? row.time_error : std::nullopt;
}

std::string largest_part(const PrecisionResult& result, const PrecisionRow& row) {
  const ErrorParts& parts = result.parts_of(row);
  if (!parts.space || !row.time_error) return "";
  const double penalty = parts.penalty.value_or(0.0);
  const double rest = std::max(*parts.space, penalty);
  if (*row.time_error + parts.time_reference_error > rest && !resolved(*row.time_error, parts.time_reference_error))
    return "";
  if (*row.time_error >= rest) return "time";
  return penalty > *parts.space ? "penalty" : "space";
}

std::vector<Column<PrecisionRow>> precision_columns(const PrecisionResult& result) {
  using Row = PrecisionRow;
  const auto part = [&](const char* key, std::optional<double> ErrorParts::*member) -> Column<Row> {
    Column<Row> column{key, key, [&result, member](const Row& row) { return cell(result.parts_of(row).*member); },
                       [&result, member](const Row& row, const NumberText& number) {
                         return part_text(result.parts_of(row).*member, number);
                       }};
    return std::move(column).in(Dimension::length);
  };
  const auto unless_failed = [](const Row& row, auto value) { return row.failure.empty() ? cell(value) : Cell(); };
  const double reference_error = result.reference ? result.reference->error : 0.0;
  return {
      {"method", "method", [](const Row& row) { return cell(name(row.method)); }},
      {"label", "setting", [](const Row& row) { return cell(row.label); },
       [](const Row& row, const NumberText& number) {
         return row.setting > 0.0 ? setting_text(row.method, row.setting, number) : row.label;
       }},
      Column<Row>{
          "error", "error, measured", [](const Row& row) { return cell(row.error); },
          [=](const Row& row, const NumberText& number) { return measured(row.error, reference_error, number); }}
          .in(Dimension::length),
      {"seconds", "seconds", [=](const Row& row) { return unless_failed(row, row.seconds); }},
      {"steps", "steps", [=](const Row& row) { return unless_failed(row, row.steps); }},
      column("runs", "runs", &Row::runs),
      column("elements", "elements", &Row::elements),
      {"mass", "mass", [](const Row& row) { return cell(name(row.mass)); }},
      {"tolerance", "", [](const Row& row) { return is_adaptive(row.method) ? cell(row.setting) : Cell(); }, {}, true},
      {"step", "", [](const Row& row) { return is_scheme(row.method) ? cell(row.setting) : Cell(); }, {}, true},
      part("space", &ErrorParts::space),
      part("penalty", &ErrorParts::penalty),
      Column<Row>{"time", "time", [](const Row& row) { return cell(row.time_error); },
                  [&result](const Row& row, const NumberText& number) {
                    return measured(row.time_error, result.parts_of(row).time_reference_error, number);
                  }}
          .in(Dimension::length),
      {"largest_part", "largest part", [&result](const Row& row) { return cell(largest_part(result, row)); }},
      column("failure", "", &Row::failure)};
}

Table precision_table(const PrecisionResult& result, const NumberText& number) {
  const bool penalised =
      std::ranges::any_of(result.parts, [](const ErrorParts& parts) { return parts.penalty.has_value(); });
  const bool several = meshes_in(result).size() > 1;
  std::vector<std::string_view> keys = {"method", "elements", "label",   "seconds", "steps",
                                        "error",  "space",    "penalty", "time",    "largest_part"};
  if (!several) std::erase(keys, "elements");
  if (!penalised) std::erase(keys, "penalty");
  Table table = table_of(pick(precision_columns(result), keys), result.rows, number, several ? 3 : 2);
  for (std::size_t i = 0; i < result.rows.size(); ++i)
    if (!result.rows[i].failure.empty()) end_row(table, i, "failed");
  return table;
}

std::string reference_sentence(const PrecisionResult& result, const NumberText& number) {
  if (!result.reference) return "No total error is given, for the reference failed: " + result.no_reference + ".";
  const PrecisionReference& r = *result.reference;
  if (r.closed_form) return fmt::format("Errors are against the closed form: {}.", r.what);
  return fmt::format(
      "Errors are against a finer run: {}, itself good to about {} by its last two meshes{}.", r.what,
      number(r.error, Dimension::length),
      r.order ? fmt::format(" (observed order in h {:.2f})", *r.order) : " (its order in h is not settled)");
}

Table time_reference_table(const PrecisionResult& result, const NumberText& number) {
  Table table{{"method", "elements", "mass", "time errors are against",
               number.heading("which is good to", Dimension::length), "power of epsilon"},
              4,
              {}};
  for (const ErrorParts& parts : result.parts)
    table.rows.push_back(
        {std::string(name(parts.method)), fmt::format("{}", parts.elements), std::string(name(parts.mass)),
         parts.time_reference.empty() ? fmt::format("nothing: {}", parts.problem) : parts.time_reference,
         parts.time_reference.empty() ? "-" : number(parts.time_reference_error),
         parts.penalty_order ? fmt::format("{:.2f}", *parts.penalty_order)
         : parts.penalty     ? "not settled"
                             : "-"});
  return table;
}

Table mesh_table(const PrecisionReference& reference, const NumberText& number) {
  Table table{{"elements", number.heading("difference to the next", Dimension::length), "order"}, 0, {}};
  Sequence changes;
  for (const auto& [elements, difference] : reference.levels) {
    changes.add(1.0 / static_cast<double>(elements), difference.value_or(0.0), 0.0);
    const auto power = changes.x.size() > 1 ? changes.power(changes.x.size() - 2) : std::nullopt;
    table.rows.push_back({fmt::format("{}", elements), difference ? number(*difference) : "-",
                          power ? fmt::format("{:.2f}", *power) : "-"});
  }
  return table;
}

std::vector<std::string> remarks(const PrecisionStudy& study, const PrecisionResult& result, const NumberText& number) {
  std::vector<std::string> found;
  for (const PrecisionRow& row : result.rows)
    if (!row.failure.empty())
      found.push_back(fmt::format("{}, {}, failed: {}", name(row.method), row.label, row.failure));
  for (const auto& [method, elements, what, reason] : result.left_out) {
    const std::string mesh = study.elements.size() > 1 && what.empty() ? fmt::format(" on {} elements", elements) : "";
    found.push_back(what.empty() ? fmt::format("{}{} was left out: {}", name(method), mesh, reason)
                                 : fmt::format("{} was left out from {} on: {}", name(method), what, reason));
  }
  for (const ErrorParts& parts : result.parts)
    if (!parts.problem.empty())
      found.push_back(fmt::format("{} on {} elements has no {}: {}", name(parts.method), parts.elements,
                                  parts.time_reference.empty() ? "time errors" : "space and penalty", parts.problem));
  for (const ErrorParts& parts : result.parts)
    if (const auto stuck = stagnation(result, parts))
      found.push_back(
          fmt::format("{} on {} elements does not tend to that semi-discrete solution: its time error stays "
                      "near {} however small the step",
                      name(parts.method), parts.elements, number(*stuck, Dimension::length)));
  if (result.reference && !result.reference->settles)
    found.emplace_back(
        "The meshes of the reference are further from each other the finer they are: they show no limit, and no error "
        "below its own is told");
  if (result.core_share < 0.9)
    found.push_back(
        fmt::format("Other work kept the machine busy: the timed runs had {:.0f} % of a core, so seconds are "
                    "longer than they need be",
                    100.0 * result.core_share));
  const Case& scene = study.scene;
  const bool touched =
      std::ranges::any_of(result.parts, [](const ErrorParts& parts) { return parts.penalty.value_or(0.0) > 0.0; });
  if (touched && !scene.restitution && !are_massless(scene.scene, common_mass(scene)))
    found.emplace_back(
        scene.scene.span
            ? "Where an undamped penalty rebounds from a span obstacle and the scheme does not, these are two "
              "solutions of one problem, and their difference, here in the space part, falls with no mesh; "
              "contact.restitution "
              "gives both the same law"
            : std::string(
                  "Where a contact node with mass rebounds from the undamped penalty, that counts as space: only "
                  "a finer mesh makes it smaller, or contact.restitution") +
                  (may_be_massless(scene) ? " or mesh.mass = \"redistributed\"" : ""));
  return found;
}

namespace {

/// A part this much smaller than another is not worth paying for.
constexpr double negligible = 0.1;

/// The largest setting from which on the time error stays below `bound`.
std::optional<double> enough(std::span<const PrecisionRow> rows, double bound) {
  std::optional<double> found;
  for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
    if (!row->time_error) continue;
    if (*row->time_error > bound) break;
    found = row->setting;
  }
  return found;
}

std::optional<double> smallest_time_error(std::span<const PrecisionRow> rows) {
  std::optional<double> smallest;
  for (const PrecisionRow& row : rows)
    if (row.time_error && (!smallest || *row.time_error < *smallest)) smallest = row.time_error;
  return smallest;
}

/// Two digits: as good as such a figure is.
double rough(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::round(value / unit) * unit;
}

/// epsilon at which the penalty's part would be `wanted`, by its observed power; not far from what was measured.
std::optional<double> epsilon_for(const ErrorParts& parts, double wanted) {
  if (!parts.epsilon || !parts.penalty_order || *parts.penalty_order < 0.1 || !(*parts.penalty > 0.0))
    return std::nullopt;
  const double factor = std::pow(wanted / *parts.penalty, 1.0 / *parts.penalty_order);
  return rough(*parts.epsilon * std::clamp(factor, 1e-3, 1e3));
}

}  // namespace

std::string advice(const PrecisionResult& result, const ErrorParts& parts, const NumberText& number) {
  const auto rows = rows_of(result, parts);
  const auto length = [&](double value) { return number(value, Dimension::length); };
  const auto penalty_of = [&](double epsilon) { return number(epsilon, number.of_epsilon); };
  const auto time = smallest_time_error(rows);
  if (!time) return parts.problem.empty() ? "no run to judge by" : "the time error is not known: " + parts.problem;
  if (!parts.space) return fmt::format("the time error comes down to {}; the others are not known", length(*time));
  const double space = *parts.space, penalty = parts.penalty.value_or(0.0);
  const double rest = std::max(space, penalty);
  const char* setting = setting_word(parts.method);
  const double rounding = 100.0 * std::numeric_limits<double>::epsilon() * result.reference->largest_displacement;
  if (*time + rest <= rounding) return "nothing but rounding in any part, whatever is paid";
  if (*time + parts.time_reference_error > rest && !resolved(*time, parts.time_reference_error))
    return fmt::format("time, below {} at the smallest {}, and {}, {}, are not told apart by this reference",
                       length(*time + parts.time_reference_error), setting, penalty > space ? "the penalty" : "space",
                       length(rest));
  if (*time > rest)
    return fmt::format("time dominates down to the smallest {}: {}, against {} of {}", setting, length(*time),
                       length(rest), penalty > space ? "the penalty" : "space");

  std::string text = penalty > space
                         ? fmt::format("the penalty dominates: {}, against {} of space", length(penalty), length(space))
                         : fmt::format("space dominates: {}", length(space));
  if (penalty > 0.0 && penalty <= space) text += fmt::format(", against {} of the penalty", length(penalty));
  std::string vain;
  if (const auto setting_enough = enough(rows, negligible * rest); setting_enough && *setting_enough > 0.0)
    vain = fmt::format("a {} below {}", setting,
                       is_scheme(parts.method) ? number(*setting_enough, Dimension::time) : number(*setting_enough));
  if (parts.penalty && penalty <= space)
    if (const auto enough_epsilon = epsilon_for(parts, negligible * space))
      vain += fmt::format("{}an epsilon below {}", vain.empty() ? "" : " or ", penalty_of(*enough_epsilon));
  if (!vain.empty()) text += fmt::format("; {} buys nothing", vain);
  if (penalty > space) {
    const auto balanced = epsilon_for(parts, space);
    text += balanced ? fmt::format("; below epsilon = {} the mesh is the larger part", penalty_of(*balanced))
                     : "; at which power of epsilon it falls is not settled, see viscobar check";
  }
  return text;
}

std::vector<Advice> advice_on_mesh(const PrecisionResult& result, std::size_t elements, const NumberText& number) {
  std::vector<Advice> all;
  for (const ErrorParts& parts : result.parts) {
    if (parts.elements != elements) continue;
    const std::string text = advice(result, parts, number), method(name(parts.method));
    const auto same = std::ranges::find(all, text, &Advice::text);
    if (same == all.end())
      all.push_back({method, text});
    else
      same->methods += ", " + method;
  }
  return all;
}

}  // namespace viscobar
