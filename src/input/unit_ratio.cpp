#include <utility>
#include <vector>

#include "input/input_text.hpp"
#include "input/trace_file.hpp"

namespace viscobar {

namespace {

std::optional<double> size_of(std::string_view unit, char& base) {
  if (unit == "min" || unit == "h") return base = 's', unit == "h" ? 3600.0 : 60.0;
  if (unit == "sec" || unit == "seconds") unit = "s";
  constexpr std::string_view bases[] = {"Pa", "s", "m", "N"};
  constexpr std::pair<std::string_view, double> prefixes[] = {
      {"", 1.0},   {"k", 1e3},  {"M", 1e6},         {"G", 1e9},         {"c", 1e-2},
      {"m", 1e-3}, {"u", 1e-6}, {"\xc2\xb5", 1e-6}, {"\xce\xbc", 1e-6}, {"n", 1e-9}};
  for (const std::string_view name : bases)
    for (const auto& [prefix, size] : prefixes)
      if (unit.ends_with(name) && unit.substr(0, unit.size() - name.size()) == prefix) return base = name.front(), size;
  return std::nullopt;
}

}  // namespace

std::optional<double> unit_ratio(std::string_view from, std::string_view to) {
  if (from == to) return 1.0;
  const std::vector<std::string_view> a = split(from, '/'), b = split(to, '/');
  if (a.size() != b.size() || a.size() > 2) return std::nullopt;
  double ratio = 1.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    char of = 0, wanted = 0;
    const auto size = size_of(a[k], of), other = size_of(b[k], wanted);
    if (!size || !other || of != wanted) return std::nullopt;
    ratio *= k == 0 ? *size / *other : *other / *size;
  }
  return ratio;
}

}  // namespace viscobar
