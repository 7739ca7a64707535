#include "results/csv.hpp"

namespace viscobar {

void EndsCsv::append(const Snapshot& at) {
  file_.print("{},{},{},{},{},{},{}", at.time, at.u.front(), at.v.front(), at.reaction_left, at.u.back(), at.v.back(),
              at.reaction_right);
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
