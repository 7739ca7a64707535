#include "results/csv.hpp"

#include <fmt/format.h>

#include <array>

namespace viscobar {

namespace {

// Columns of an instant or of its derivatives, in the order of ends.csv.
std::array<double, 6> at_ends(const auto& of) {
  return {of.u.front(), of.v.front(), of.reaction_left, of.u.back(), of.v.back(), of.reaction_right};
}

}  // namespace

std::string ends_row(const Snapshot& at) { return fmt::format("{},{}", at.time, fmt::join(at_ends(at), ",")); }

std::string events_row(const Event& event) {
  return fmt::format("{},{},{},{}", event.time, place(event), event.change == Change::closing ? "closing" : "opening",
                     event.velocity);
}

std::string energy_row(double t, const EnergyState& energy) {
  return fmt::format("{},{},{},{},{},{},{}", t, energy.kinetic, energy.elastic, energy.contact, energy.dissipated,
                     energy.work, energy.total());
}

std::string sensitivity_header(std::span<const Direction> directions) {
  std::string header = "t";
  for (const Direction& along : directions)
    for (const char* column : {"u_left", "v_left", "reaction_left", "u_right", "v_right", "reaction_right"})
      header += fmt::format(",{}/{}", column, along.key);
  return header;
}

std::string sensitivity_row(const Snapshot& at) {
  std::string row = fmt::format("{}", at.time);
  for (const FieldSensitivity& s : at.sensitivities) row += fmt::format(",{}", fmt::join(at_ends(s), ","));
  return row;
}

std::string gauges_row(const Snapshot& at, std::span<const Gauge> gauges) {
  std::string row = fmt::format("{}", at.time);
  for (const Gauge& gauge : gauges) {
    const auto [u, v, strain, stress] = gauge(at.u, at.v);
    row += fmt::format(",{},{},{},{}", u, v, strain, stress);
  }
  return row;
}

std::string csv_text(const std::string& word) {
  if (word.find_first_of(",\"\r\n") == word.npos) return word;
  std::string quoted = "\"";
  for (const char c : word) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

std::string_view name(Where where) { return where == Where::left ? "left" : where == Where::right ? "right" : "span"; }

std::string place(const Event& event) {
  return event.where == Where::span ? fmt::format("span:{}", event.node) : std::string(name(event.where));
}

}  // namespace viscobar
