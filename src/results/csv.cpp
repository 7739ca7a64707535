#include "results/csv.hpp"

namespace viscobar {

void EndsCsv::append(const Snapshot& at) {
  file_.print("{},{},{},{},{},{},{}", at.time, at.u.front(), at.v.front(), at.reaction_left, at.u.back(), at.v.back(),
              at.reaction_right);
}

namespace {

std::string sensitivity_header(std::span<const Direction> directions) {
  std::string header = "t";
  for (const Direction& along : directions)
    for (const char* column : {"u_left", "v_left", "reaction_left", "u_right", "v_right", "reaction_right"})
      header += fmt::format(",{}/{}", column, along.key);
  return header;
}

}  // namespace

SensitivityCsv::SensitivityCsv(const std::filesystem::path& path, std::span<const Direction> directions,
                               const std::optional<Checksum>& keep)
    : GrowingTable(path, sensitivity_header(directions), keep) {}

void SensitivityCsv::append(const Snapshot& at) {
  std::string line = fmt::format("{}", at.time);
  for (const FieldSensitivity& s : at.sensitivities)
    for (const double value : {s.u.front(), s.v.front(), s.reaction_left, s.u.back(), s.v.back(), s.reaction_right})
      line += fmt::format(",{}", value);
  file_.print("{}", line);
}

void EventsCsv::append(const Event& event) {
  file_.print("{},{},{},{}", event.time, place(event), event.change == Change::closing ? "closing" : "opening",
              event.velocity);
}

void EnergyCsv::append(const Snapshot& at) {
  if (!at.energy) return;
  const EnergyState& energy = *at.energy;
  file_.print("{},{},{},{},{},{},{}", at.time, energy.kinetic, energy.elastic, energy.contact,
              energy.dissipated + energy.end_inertia, energy.work, energy.total());
}

std::string place(const Event& event) {
  switch (event.where) {
    case Where::left: return "left";
    case Where::right: return "right";
    case Where::span: return fmt::format("span:{}", event.node);
  }
  return {};
}

}  // namespace viscobar
