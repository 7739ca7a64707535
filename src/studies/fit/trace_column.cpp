#include <fmt/format.h>

#include <cmath>

#include "text/number.hpp"
#include "viscobar/studies/fit/fit.hpp"

namespace viscobar {

namespace {

constexpr std::string_view column_names[] = {
    "u_left", "v_left",  "reaction_left", "u_right", "v_right",  "reaction_right", "u@",
    "v@",     "strain@", "stress@",       "u_left:", "u_right:", "force:"};

bool has_place(std::string_view name) { return name.ends_with('@') || name.ends_with(':'); }

}  // namespace

std::span<const std::string_view> trace_column_names() { return column_names; }

std::string name(TraceColumn column, double place) {
  const std::string_view own = column_names[static_cast<std::size_t>(column)];
  return has_place(own) ? fmt::format("{}{}", own, place) : std::string(own);
}

std::optional<std::pair<TraceColumn, double>> trace_column(std::string_view text) {
  for (std::size_t k = 0; k < std::size(column_names); ++k) {
    const auto column = static_cast<TraceColumn>(k);
    if (text == column_names[k] && !has_place(text)) return std::pair(column, 0.0);
    const auto place = has_place(column_names[k]) && text.starts_with(column_names[k])
                           ? number_in<double>(text.substr(column_names[k].size()))
                           : std::nullopt;
    if (place && std::isfinite(*place)) return std::pair(column, *place);
  }
  return std::nullopt;
}

}  // namespace viscobar
