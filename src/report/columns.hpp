#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "report/number_text.hpp"
#include "results/csv.hpp"
#include "results/json.hpp"
#include "text/table.hpp"

namespace viscobar {

/// A cell of a table: nothing, a word, a count or a number.
using Cell = std::variant<std::monostate, std::string, std::size_t, double>;

inline Cell cell(double value) { return value; }
inline Cell cell(std::size_t value) { return value; }
inline Cell cell(std::int64_t value) { return static_cast<std::size_t>(value); }  ///< not negative
inline Cell cell(std::string_view value) { return value.empty() ? Cell() : Cell(std::string(value)); }
template <class Value>
Cell cell(const std::optional<Value>& value) {
  return value ? cell(*value) : Cell();
}

/// A column of a table, which is a list of them. The table for people, which text() and html() print, JSON and CSV are
/// printers of that list.
template <class Row>
struct Column {
  std::string key;                            ///< its name in JSON and CSV
  std::string heading;                        ///< its name for people
  std::function<Cell(const Row& row)> value;  ///< with all its digits
  /// For people, where they read something else than the value.
  std::function<std::string(const Row& row, const NumberText& number)> people = {};
  bool optional = false;    ///< where it is absent it is not told
  int digits = 3;           ///< for people
  const char* absent = "";  ///< for people, where there is no value
  UnitPowers unit{};        ///< of its numbers, told in the heading

  Column or_else(const char* words) && {
    absent = words;
    return std::move(*this);
  }
  Column in(const UnitPowers& powers) && {
    unit = powers;
    return std::move(*this);
  }
  Column in(Dimension quantity) && { return std::move(*this).in(unit_powers(quantity)); }
};

template <class Row, class Value>
Column<Row> column(std::string key, std::string heading, Value Row::*member, bool optional = false) {
  return {std::move(key), std::move(heading), [member](const Row& row) { return cell(row.*member); }, {}, optional};
}

template <class Row>
std::vector<Column<Row>> pick(const std::vector<Column<Row>>& columns, const std::vector<std::string_view>& keys) {
  std::vector<Column<Row>> picked;
  for (const std::string_view key : keys) picked.push_back(*std::ranges::find(columns, key, &Column<Row>::key));
  return picked;
}

/// The text of a cell whose numbers are written by `number`.
template <class Number>
std::string text_of(const Cell& cell, Number&& number, const char* absent = "") {
  if (const auto* real = std::get_if<double>(&cell)) return number(*real);
  if (const auto* count = std::get_if<std::size_t>(&cell)) return fmt::format("{}", *count);
  const auto* word = std::get_if<std::string>(&cell);
  return word ? *word : absent;
}

/// For people: the first `words` columns flush left; an optional column that no row has is not there.
template <class Row>
Table table_of(std::vector<Column<Row>> columns, const std::vector<Row>& rows, const NumberText& number,
               std::size_t words) {
  std::erase_if(columns, [&](const Column<Row>& column) {
    const auto absent = [&](const Row& row) {
      return column.people ? column.people(row, number).empty()
                           : std::holds_alternative<std::monostate>(column.value(row));
    };
    return column.optional && std::ranges::all_of(rows, absent);
  });
  Table table{{}, words, {}};
  for (const Column<Row>& column : columns) table.header.push_back(number.heading(column.heading, column.unit));
  for (const Row& row : rows) {
    std::vector<std::string>& line = table.rows.emplace_back();
    for (const Column<Row>& column : columns)
      line.push_back(column.people ? column.people(row, number)
                                   : text_of(
                                         column.value(row), [&](double value) { return number(value, column.digits); },
                                         column.absent));
  }
  return table;
}

/// Puts a word in place of the numbers of a row.
inline void end_row(Table& table, std::size_t row, const char* word) {
  table.rows[row].resize(table.words);
  table.rows[row].emplace_back(word);
}

/// An object of a row; what is absent is null, or left out where the column is optional.
template <class Row>
Json json_of(const std::vector<Column<Row>>& columns, const Row& row) {
  Json json = Json::object();
  for (const Column<Row>& column : columns)
    std::visit(
        [&](const auto& value) {
          if constexpr (!std::is_same_v<std::decay_t<decltype(value)>, std::monostate>)
            json[column.key] = value;
          else if (!column.optional)
            json[column.key] = nullptr;
        },
        column.value(row));
  return json;
}

template <class Row>
Json json_of(const std::vector<Column<Row>>& columns, const std::vector<Row>& rows) {
  Json json = Json::array();
  for (const Row& row : rows) json.push_back(json_of(columns, row));
  return json;
}

/// A header and a line for each row; numbers in the shortest form that reads back as the same, what is absent empty.
template <class Row>
std::string csv_of(const std::vector<Column<Row>>& columns, const std::vector<Row>& rows) {
  std::vector<std::string> cells;
  for (const Column<Row>& column : columns) cells.push_back(column.key);
  std::string out = fmt::format("{}\n", fmt::join(cells, ","));
  for (const Row& row : rows) {
    cells.clear();
    for (const Column<Row>& column : columns)
      cells.push_back(csv_text(text_of(column.value(row), [](double value) { return fmt::format("{}", value); })));
    out += fmt::format("{}\n", fmt::join(cells, ","));
  }
  return out;
}

}  // namespace viscobar
