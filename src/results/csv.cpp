#include "results/csv.hpp"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <array>

namespace viscobar {

namespace {

// Columns of an instant or of its derivatives, in the order of ends.csv.
std::array<double, 6> at_ends(const auto& of) {
  return {of.u.front(), of.v.front(), of.reaction_left, of.u.back(), of.v.back(), of.reaction_right};
}

}  // namespace

std::string ends_row(const Snapshot& at) {
  return fmt::format(FMT_COMPILE("{},{}"), at.time, fmt::join(at_ends(at), ","));
}

std::string events_row(const Event& event) {
  return fmt::format("{},{},{},{}", event.time, place(event), event.change == Change::closing ? "closing" : "opening",
                     event.velocity);
}

std::string energy_row(double t, const EnergyState& energy) {
  return fmt::format(FMT_COMPILE("{},{},{},{},{},{},{}"), t, energy.kinetic, energy.elastic, energy.contact,
                     energy.dissipated, energy.work, energy.total());
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

std::string joints_header(const Scene& scene) {
  std::string header = "t";
  for (std::size_t k = 1; k < scene.chain.size(); ++k)
    if (scene.chain[k - 1].joint.kind != JointKind::bonded)
      header += fmt::format(",u_left:{0},u_right:{0},force:{0}", k);
  return header;
}

std::string joints_row(const Snapshot& at, std::span<const std::size_t> nodes) {
  std::string row = fmt::format("{}", at.time);
  for (std::size_t k = 0; k < nodes.size(); ++k)
    row += fmt::format(",{},{},{}", at.u[nodes[k] - 1], at.u[nodes[k]],
                       k < at.joint_forces.size() ? at.joint_forces[k] : 0.0);
  return row;
}

std::string csv_text(const std::string& word) {
  if (word.find_first_of(",\"\r\n") == word.npos) return word;
  std::string quoted = "\"";
  for (const char c : word) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

std::string_view name(Where where) {
  constexpr std::string_view names[] = {"left", "right", "span", "joint"};
  return names[static_cast<std::size_t>(where)];
}

std::string name(const ContactPlace& place) {
  return place.joint > 0 ? fmt::format("joint:{}", place.joint) : std::string(name(place.where));
}

std::string place(const Event& event) {
  return event.where == Where::left || event.where == Where::right
             ? std::string(name(event.where))
             : fmt::format("{}:{}", name(event.where), event.node);
}

}  // namespace viscobar
