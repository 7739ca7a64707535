#include "results/csv.hpp"

namespace viscobar {

namespace {

LineFile line_file(const std::filesystem::path& path, const std::optional<Checksum>& keep) {
  return keep ? LineFile(path, *keep) : LineFile(path);
}

}  // namespace

EndsCsv::EndsCsv(const std::filesystem::path& path, const std::optional<Checksum>& keep)
    : file_(line_file(path, keep)) {
  if (!keep) file_.print("t,u_left,v_left,reaction_left,u_right,v_right,reaction_right");
}

void EndsCsv::append(const Snapshot& at) {
  file_.print("{},{},{},{},{},{},{}", at.time, at.u.front(), at.v.front(), at.reaction_left, at.u.back(), at.v.back(),
              at.reaction_right);
}

SensitivityCsv::SensitivityCsv(const std::filesystem::path& path, std::span<const Direction> directions,
                               const std::optional<Checksum>& keep)
    : file_(line_file(path, keep)) {
  if (keep) return;
  std::string header = "t";
  for (const Direction& along : directions)
    for (const char* column : {"u_left", "v_left", "reaction_left", "u_right", "v_right", "reaction_right"})
      header += fmt::format(",{}/{}", column, along.key);
  file_.print("{}", header);
}

void SensitivityCsv::append(const Snapshot& at) {
  std::string line = fmt::format("{}", at.time);
  for (const FieldSensitivity& s : at.sensitivities)
    for (const double value : {s.u.front(), s.v.front(), s.reaction_left, s.u.back(), s.v.back(), s.reaction_right})
      line += fmt::format(",{}", value);
  file_.print("{}", line);
}

EventsCsv::EventsCsv(const std::filesystem::path& path, const std::optional<Checksum>& keep)
    : file_(line_file(path, keep)) {
  if (!keep) file_.print("t,where,change,velocity");
}

void EventsCsv::append(const Event& event) {
  file_.print("{},{},{},{}", event.time, place(event), event.change == Change::closing ? "closing" : "opening",
              event.velocity);
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
