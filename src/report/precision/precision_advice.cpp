#include "report/precision/precision_advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "report/precision/precision_tables.hpp"

namespace viscobar {

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

std::string advice(const PrecisionResult& result, const ErrorParts& parts, NumberText number) {
  const auto rows = rows_of(result, parts);
  const auto time = smallest_time_error(rows);
  if (!time) return parts.problem.empty() ? "no run to judge by" : "the time error is not known: " + parts.problem;
  if (!parts.space) return fmt::format("the time error comes down to {}; the others are not known", number(*time));
  const double space = *parts.space, penalty = parts.penalty.value_or(0.0);
  const double rest = std::max(space, penalty);
  const char* setting = setting_word(parts.method);
  const double rounding = 100.0 * std::numeric_limits<double>::epsilon() * result.reference->largest_displacement;
  if (*time + rest <= rounding) return "nothing but rounding in any part, whatever is paid";
  if (*time + parts.time_reference_error > rest && !resolved(*time, parts.time_reference_error))
    return fmt::format("time, below {} at the smallest {}, and {}, {}, are not told apart by this reference",
                       number(*time + parts.time_reference_error), setting, penalty > space ? "the penalty" : "space",
                       number(rest));
  if (*time > rest)
    return fmt::format("time dominates down to the smallest {}: {}, against {} of {}", setting, number(*time),
                       number(rest), penalty > space ? "the penalty" : "space");

  std::string text = penalty > space
                         ? fmt::format("the penalty dominates: {}, against {} of space", number(penalty), number(space))
                         : fmt::format("space dominates: {}", number(space));
  if (penalty > 0.0 && penalty <= space) text += fmt::format(", against {} of the penalty", number(penalty));
  std::string vain;
  if (const auto setting_enough = enough(rows, negligible * rest); setting_enough && *setting_enough > 0.0)
    vain = fmt::format("a {} below {}", setting, number(*setting_enough));
  if (parts.penalty && penalty <= space)
    if (const auto enough_epsilon = epsilon_for(parts, negligible * space))
      vain += fmt::format("{}an epsilon below {}", vain.empty() ? "" : " or ", number(*enough_epsilon));
  if (!vain.empty()) text += fmt::format("; {} buys nothing", vain);
  if (penalty > space) {
    const auto balanced = epsilon_for(parts, space);
    text += balanced ? fmt::format("; below epsilon = {} the mesh is the larger part", number(*balanced))
                     : "; it does not fall with epsilon here, see viscobar check";
  }
  return text;
}

std::vector<Advice> advice_on_mesh(const PrecisionResult& result, std::size_t elements, NumberText number) {
  std::vector<Advice> all;
  for (const ErrorParts& parts : result.parts) {
    if (parts.elements != elements) continue;
    const std::string text = advice(result, parts, number), method(name(parts.method));
    const auto same = std::find_if(all.begin(), all.end(), [&](const Advice& known) { return known.text == text; });
    if (same == all.end())
      all.push_back({method, text});
    else
      same->methods += ", " + method;
  }
  return all;
}

}  // namespace viscobar
