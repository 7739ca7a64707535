#include <fmt/format.h>

#include <cmath>

#include "text/number.hpp"
#include "viscobar/studies/fit/fit.hpp"

namespace viscobar {

std::string name(TraceColumn column, double place) {
  constexpr std::string_view names[] = {
      "u_left", "v_left",  "reaction_left", "u_right", "v_right",  "reaction_right", "u@",
      "v@",     "strain@", "stress@",       "u_left:", "u_right:", "force:"};
  const std::string_view own = names[static_cast<std::size_t>(column)];
  return own.ends_with('@') || own.ends_with(':') ? fmt::format("{}{}", own, place) : std::string(own);
}

std::optional<std::pair<TraceColumn, double>> trace_column(std::string_view text) {
  for (const TraceColumn column : all_trace_columns)
    if (name(column) == text) return std::pair(column, 0.0);
  const std::size_t at = text.find_first_of("@:");
  const auto place = at == text.npos ? std::nullopt : number_in<double>(text.substr(at + 1));
  if (!place || !std::isfinite(*place)) return std::nullopt;
  for (const auto& [quantity, column] : {std::pair{"u@", TraceColumn::u_at},
                                         {"v@", TraceColumn::v_at},
                                         {"strain@", TraceColumn::strain_at},
                                         {"stress@", TraceColumn::stress_at},
                                         {"u_left:", TraceColumn::u_left_of},
                                         {"u_right:", TraceColumn::u_right_of},
                                         {"force:", TraceColumn::force_of}})
    if (text.substr(0, at + 1) == quantity) return std::pair(column, *place);
  return std::nullopt;
}

}  // namespace viscobar
