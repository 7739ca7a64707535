#include "sweep/sweep_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "input/described_scene.hpp"
#include "input/unit_of_key.hpp"
#include "report/page.hpp"
#include "report/plot/axis.hpp"
#include "report/plot/colours.hpp"
#include "report/plot/figure.hpp"
#include "sweep/sweep_results.hpp"
#include "text/json_text.hpp"
#include "text/number.hpp"
#include "text/printable_text.hpp"

namespace viscobar {

namespace {

using plot::json_string;

/// The columns whose values are not all the same, or not all missing.
std::vector<std::size_t> telling_columns(const SweepPlan& plan, std::span<const SweepRow* const> rows) {
  std::vector<std::size_t> shown;
  for (std::size_t k = 0; k < plan.columns().size(); ++k) {
    const auto differs = [&](const SweepRow* row) {
      const double a = row->column(k), b = rows.front()->column(k);
      return !(a == b || (std::isnan(a) && std::isnan(b)));
    };
    if (!rows.empty() && std::ranges::any_of(rows, differs)) shown.push_back(k);
  }
  return shown;
}

/// The columns among these that describe the motion of the bar, the most telling first.
std::vector<std::size_t> by_interest(const SweepPlan& plan, const std::vector<std::size_t>& shown) {
  if (!plan.bars.empty()) return shown;
  using enum Quantity;
  constexpr Quantity order[] = {events,
                                max_reaction_left,
                                max_reaction_right,
                                impulse_left,
                                impulse_right,
                                max_penetration,
                                energy_final,
                                u_left_min,
                                u_right_max,
                                u_left_final,
                                u_right_final,
                                time_in_contact_left,
                                time_in_contact_right,
                                steps};
  std::vector<std::size_t> found;
  for (const Quantity quantity : order)
    if (const auto k = static_cast<std::size_t>(quantity); std::ranges::find(shown, k) != shown.end())
      found.push_back(k);
  return found;
}

NumberText numbers_of(const SweepFile& sweep, NumberText::For reader) {
  Scene scene;
  scene.units = sweep.units;
  return NumberText(reader, scene);
}

template <class Values, class Text>
std::string list(const Values& values, Text&& text) {
  std::string all = "[";
  for (const auto& value : values) all += (all.size() > 1 ? "," : "") + text(value);
  return all + "]";
}

std::string data_json(const SweepFile& sweep, std::span<const SweepRow* const> rows,
                      const std::vector<std::size_t>& shown) {
  const auto& keys = sweep.plan.keys;
  const NumberText number = numbers_of(sweep, NumberText::For::page);
  std::string errors, command = fmt::format("viscobar run {}", sweep.scene_source);
  for (const Setting& setting : sweep.settings) command += fmt::format(" --set '{}'", text_of(setting));
  for (std::size_t row = 0; row < rows.size(); ++row)
    if (!rows[row]->completed)
      errors += fmt::format("{}\"{}\":{}", errors.empty() ? "" : ",", row, json_string(rows[row]->error));
  const auto value_json = [](const auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::string>)
      return json_string(value);
    else
      return fmt::format("{}", value);
  };
  const auto key_json = [&](const VariedKey& key) {
    return fmt::format(R"({{"name":{},"label":{},"values":{}}})", json_string(key.key),
                       json_string(number.heading(key.key, unit_of_key(key.key, {}).value_or(UnitPowers{}))),
                       std::visit([&](const auto& values) { return list(values, value_json); }, key.values));
  };
  const std::vector<QuantityColumn> columns = sweep.plan.columns();
  const auto column_json = [&](std::size_t k) {
    const UnitPowers unit = unit_powers(columns[k].unit).value_or(UnitPowers{});
    const std::string named = number.unit(unit);
    return fmt::format(R"({{"name":{},"label":{},"unit":{},"meaning":{},"values":{}}})", json_string(columns[k].name),
                       json_string(number.heading(columns[k].name, unit)),
                       json_string(named.empty() ? columns[k].unit : named), json_string(columns[k].meaning),
                       plot::json_numbers(
                           rows, [&](const SweepRow* row) { return row->column(k); }, 7));
  };
  const std::vector<std::size_t> interesting = by_interest(sweep.plan, shown);
  return fmt::format(
      R"({{"zip":{},"first":{},"command":{},"keys":{},"columns":{},"index":{},"choice":{},"errors":{{{}}},"anchors":{},"dashes":{},"markers":{}}})",
      sweep.plan.combine == Combine::zip, json_string(interesting.empty() ? "" : columns[interesting.front()].name),
      json_string(command), list(keys, key_json), list(shown, column_json),
      list(rows, [&](const SweepRow* row) { return value_json(row->index); }),
      list(rows, [&](const SweepRow* row) { return list(sweep.plan.choice(row->index), value_json); }), errors,
      list(plot::sequential().anchors, [](plot::Colour colour) { return json_string(plot::hex(colour)); }),
      list(plot::dash_shapes(), json_string), list(plot::marker_shapes(), json_string));
}

}  // namespace

Table sweep_text_table(const SweepFile& sweep, std::span<const SweepRow* const> rows, std::size_t most,
                       NumberText::For reader) {
  using Row = const SweepRow*;
  constexpr std::size_t most_columns = 4;
  const std::vector<Column<Row>> all = sweep_columns(sweep.plan);
  std::vector<Column<Row>> columns(all.begin(), all.begin() + 1 + std::ssize(sweep.plan.keys));
  const std::size_t words = columns.size(), numbers = words + 2;  // behind completed and error
  for (const std::size_t k : by_interest(sweep.plan, telling_columns(sweep.plan, rows))) {
    if (columns.size() == words + most_columns) break;
    columns.push_back(all[numbers + k]);
    columns.back().people = [k](Row row, const NumberText& number) {
      if (!row->completed) return std::string("failed");
      return std::isnan(row->column(k)) ? "" : number(row->column(k), 5);
    };
  }
  columns.push_back(timing_columns()[1]);
  rows = rows.first(std::min(rows.size(), most));
  Table table = table_of(columns, std::vector(rows.begin(), rows.end()), numbers_of(sweep, reader), words);
  for (auto& row : table.rows)
    for (std::string& cell : row) cell = one_line(cell);
  return table;
}

std::string sweep_page(const SweepFile& sweep, std::span<const SweepRow* const> all) {
  const auto rows = all.first(std::min(all.size(), most_on_page));
  Page page(sweep.title.empty() ? "A sweep of viscobar" : sweep.title);
  std::string keys;
  for (const VariedKey& key : sweep.plan.keys)
    keys += fmt::format("{}{} ({})", keys.empty() ? "" : ", ", escaped(key.key), counted(key.size(), "value"));
  page.add_head(fmt::format(
      "<p class=\"model\">{} over {}: {} of {} cases are done{}.</p>\n", escaped(sweep.scene_source), keys, all.size(),
      sweep.plan.size(),
      all.size() > rows.size() ? fmt::format("; this page has the first {}, sweep.csv has all", rows.size()) : ""));
  const std::vector<std::size_t> shown = telling_columns(sweep.plan, rows);
  if (shown.empty() || sweep.plan.keys.empty()) {
    page.add("<section><p>Nothing differs from case to case.</p></section>\n");
    return page.html();
  }
  Table still = sweep_text_table(sweep, rows, 100, NumberText::For::page);
  for (auto& row : still.rows) row.pop_back();  // a page does not depend on the machine
  still.header.pop_back();
  page.add(fmt::format("<section class=\"still\"><h2>Cases</h2>\n{}</section>\n", html(still)));
  page.add("<section class=\"live\" id=\"sweep\"></section>\n");
  page.add_data("sweep", data_json(sweep, rows, shown));
  return page.html();
}

}  // namespace viscobar
