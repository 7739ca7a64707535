#include "sweep/sweep_csv.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

namespace viscobar {

namespace {

std::string cell(double value) { return std::isnan(value) ? "" : fmt::format("{}", value); }
std::string cell(std::int64_t value) { return fmt::format("{}", value); }

// RFC 4180: quotes around what holds a comma, quotes or a new line, quotes in it doubled.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == text.npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

}  // namespace

std::string sweep_csv(const SweepPlan& plan, std::span<const SweepRow* const> rows) {
  std::string text = "index";
  const auto add = [&](std::string_view next) {
    text += ',';
    text += next;
  };
  for (const VariedKey& key : plan.keys) add(key.key);
  add("completed");
  add("error");
  for (const QuantityColumn& column : quantity_columns()) add(column.name);
  const std::vector<std::string> derivatives = plan.derivatives();
  for (const std::string& name : derivatives) add(name);
  text += '\n';
  for (const SweepRow* row : rows) {
    text += cell(static_cast<std::int64_t>(row->index));
    const std::vector<std::size_t> chosen = plan.choice(row->index);
    for (std::size_t k = 0; k < plan.keys.size(); ++k)
      std::visit([&](const auto& list) { add(cell(list[chosen[k]])); }, plan.keys[k].values);
    add(row->completed ? "1" : "0");
    add(cell(row->error));
    for (std::size_t k = 0; k < quantities + derivatives.size(); ++k) add(cell(row->column(k)));
    text += '\n';
  }
  return text;
}

std::string timings_csv(std::span<const SweepRow* const> rows) {
  std::string text = "index,seconds,integration_seconds\n";
  for (const SweepRow* row : rows)
    fmt::format_to(std::back_inserter(text), "{},{},{}\n", row->index, row->seconds, row->integration_seconds);
  return text;
}

}  // namespace viscobar
