#include "scene/unit_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace viscobar {

namespace {

constexpr std::pair<std::string_view, std::string Units::*> kinds[] = {{"length", &Units::length},
                                                                       {"time", &Units::time},
                                                                       {"mass", &Units::mass},
                                                                       {"force", &Units::force},
                                                                       {"stress", &Units::stress}};
/// Powers of these.
using Powers = std::array<double, std::size(kinds)>;

/// Powers of a stress, in units that are named.
std::optional<Powers> stress_powers(const Units& units) {
  const bool length = !units.length.empty();
  if (!units.stress.empty()) return Powers{0, 0, 0, 0, 1};
  if (!units.force.empty() && length) return Powers{-2, 0, 0, 1, 0};
  if (!units.mass.empty() && !units.time.empty() && length) return Powers{-1, -2, 1, 0, 0};
  return std::nullopt;
}

std::string power(std::string_view name, double exponent) {
  return exponent == 1.0 ? std::string(name) : fmt::format("{}^{}", name, exponent);
}

// Empty where a unit is not named.
std::string name_of(const Units& units, const Powers& all) {
  // The force first, and the mass: "N s/m^2", "kg/s^2".
  std::string above, below;
  int divisors = 0;
  for (const std::size_t k : {4, 3, 2, 0, 1}) {
    const std::string& name = units.*kinds[k].second;
    const double exponent = all[k];
    if (exponent == 0.0) continue;
    if (name.empty()) return {};
    std::string& part = exponent > 0.0 ? above : below;
    if (exponent < 0.0) ++divisors;
    part += (part.empty() ? "" : " ") + power(name, std::abs(exponent));
  }
  if (below.empty()) return above;
  return fmt::format("{}/{}", above.empty() ? "1" : above, divisors > 1 ? "(" + below + ")" : below);
}

}  // namespace

UnitPowers unit_powers(Dimension quantity) {
  constexpr std::array<UnitPowers, 7> powers = {
      {{1, 0, 0, 0}, {0, 1, 0, 0}, {1, -1, 0, 0}, {0, 0, 1, 0}, {0, 0, 1, 1}, {0, 1, 1, 1}, {1, 0, 1, 1}}};
  return powers[static_cast<std::size_t>(quantity)];
}

std::optional<UnitPowers> unit_powers(std::string_view words) {
  constexpr std::pair<std::string_view, UnitPowers> known[] = {
      {"1", {0, 0, 0, 0}},        {"length", {1, 0, 0, 0}}, {"time", {0, 1, 0, 0}},  {"stress", {0, 0, 1, 0}},
      {"density", {-2, 2, 1, 0}}, {"area", {0, 0, 0, 1}},   {"force", {0, 0, 1, 1}}, {"energy", {1, 0, 1, 1}}};
  if (words.empty()) return std::nullopt;
  UnitPowers all{};
  double sign = 1.0;
  while (!words.empty()) {
    const std::string_view word = words.substr(0, words.find(' '));
    words.remove_prefix(std::min(word.size() + 1, words.size()));
    if (word == "/" || word == "x") {
      sign = word == "/" ? -1.0 : 1.0;
      continue;
    }
    const auto* found = std::ranges::find(known, word, &std::pair<std::string_view, UnitPowers>::first);
    if (found == std::end(known)) return std::nullopt;
    for (std::size_t k = 0; k < all.size(); ++k) all[k] += sign * found->second[k];
  }
  return all;
}

std::string unit_name(const Units& units, const UnitPowers& powers) {
  auto [length, time, stress, area] = powers;
  const double in_length = length + (units.of_section ? 2.0 * area : 0.0);
  const std::string by_mass = name_of(units, {in_length - stress, time - 2.0 * stress, stress, 0, 0});
  Powers all{length, time, 0, 0, 0};
  if (units.of_section) {
    const double forces = units.force.empty() || area * stress <= 0.0 ? 0.0 : std::min(area / stress, 1.0) * stress;
    all[0] += 2.0 * (area - forces), all[3] += forces;
    stress -= forces;
  }
  if (stress != 0.0) {
    const auto parts = stress_powers(units);
    if (!parts) return {};
    for (std::size_t k = 0; k < all.size(); ++k) all[k] += stress * (*parts)[k];
  }
  // A density is kg/m^3 rather than Pa s^2/m^2, a stress a stress.
  std::string name = name_of(units, all);
  const bool by_its_own = powers == unit_powers(Dimension::stress) || powers == unit_powers(Dimension::force);
  return !by_mass.empty() && by_mass.size() < name.size() && !by_its_own ? by_mass : name;
}

std::string unit_name(const Units& units, Dimension quantity, const std::optional<UnitPowers>& per) {
  if (!per) return {};
  UnitPowers powers = unit_powers(quantity);
  for (std::size_t k = 0; k < powers.size(); ++k) powers[k] -= (*per)[k];
  return powers == UnitPowers{} && !named_units(units).empty() ? "1" : unit_name(units, powers);
}

std::string squares(std::string unit) {
  for (const auto& [power, sign] : {std::pair{"^2", "²"}, std::pair{"^3", "³"}})
    for (std::size_t at = 0; (at = unit.find(power, at)) != unit.npos;) unit.replace(at, 2, sign);
  return unit;
}

std::string with_unit(std::string_view words, const std::string& unit) {
  return unit.empty() ? std::string(words) : fmt::format("{} [{}]", words, unit);
}

std::string named_units(const Units& units) {
  std::string all;
  for (const auto& [what, name] : kinds)
    if (!(units.*name).empty()) all += fmt::format("{}{}: {}", all.empty() ? "" : ", ", what, units.*name);
  return all;
}

}  // namespace viscobar
