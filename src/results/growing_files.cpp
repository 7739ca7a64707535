#include "results/growing_files.hpp"

#include <fmt/format.h>

#include <string_view>
#include <system_error>

#include "dynamics/pieces.hpp"
#include "input/described_scene.hpp"
#include "input/unit_of_key.hpp"
#include "results/csv.hpp"
#include "results/output_file.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

void check_length(const fs::path& file, std::uint64_t length) {
  std::error_code error;
  const fs::file_type there = fs::symlink_status(file, error).type();
  if (there == fs::file_type::not_found) throw IoError(file, "is missing: it was removed since the checkpoint");
  if (there != fs::file_type::regular) throw IoError(file, "is no regular file: it was replaced since the checkpoint");
  const auto size = fs::file_size(file, error);
  if (error) throw IoError(file, "cannot be read: " + error.message());
  if (size < length) throw IoError(file, "is shorter than at the checkpoint: it was changed since");
}

}  // namespace

void check_begin(const fs::path& file, const Checksum& expected) {
  check_length(file, expected.bytes);
  if (checksum_of_file(file, 0, expected.bytes) != expected)
    throw IoError(file,
                  fmt::format("its first {} bytes are not those of the checkpoint: it was changed or damaged since",
                              expected.bytes));
}

void GrowingFiles::Mark::check(const fs::path& directory) const {
  if (field) check_length(directory / "field.h5", field->length);
  for (std::size_t k = 0; k < tables.size(); ++k)
    if (tables[k]) check_begin(directory / names[k], *tables[k]);
  if (field) field->check_values(directory / "field.h5");
}

std::vector<std::size_t> joint_nodes_of(const Case& run) {
  std::vector<std::size_t> nodes;
  if (run.scene.chain.empty()) return nodes;
  const std::vector<Piece> pieces = pieces_of(run.scene, run.mesh());
  for (std::size_t k = 1; k < pieces.size(); ++k)
    if (pieces[k].first > pieces[k - 1].last()) nodes.push_back(pieces[k].first);
  return nodes;
}

GrowingFiles::GrowingFiles(const fs::path& directory, const SceneFile& scene, const Mark* mark) {
  const Case& run = scene.run;
  const auto add = [&](Table which, bool wanted, std::string_view header) {
    if (!wanted) return;
    const fs::path path = directory / names[which];
    if (mark && mark->tables[which])
      tables[which].emplace(path, *mark->tables[which]);
    else
      tables[which].emplace(path).print("{}", header);
  };
  add(ends, run.files.ends, ends_header);
  add(events, run.files.events, events_header);
  add(energy, run.files.energy, energy_header);
  add(sensitivity, !run.directions.empty(), sensitivity_header(run.directions));
  add(gauges, !run.gauges.empty(), fmt::format("t,{}", fmt::join(gauge_columns(run.gauges), ",")));
  joint_nodes = joint_nodes_of(run);
  add(joints, !joint_nodes.empty(), joints_header(run.scene));
  read = make_gauges(run.gauges, run.mesh(), run.scene);
  std::vector<FieldOrigin::Key> keys;
  for (const Direction& direction : run.directions)
    keys.push_back({direction.key, unit_of_key(direction.key, run.scene)});
  if (run.files.field)
    field.emplace(directory, run.mesh(), static_cast<std::size_t>(run.end / run.output_every) + 2,
                  mark && mark->field ? &*mark->field : nullptr,
                  FieldOrigin{run.scene.bar, run.scene.units, run.scene.title, mark ? "" : scene_text(scene.values),
                              keys, element_bars(run.scene, run.mesh())});
}

void GrowingFiles::take_places() {
  for (auto& table : tables)
    if (table) table->take_place();
  if (field) field->take_place();
}

void GrowingFiles::append(const Snapshot& snapshot) {
  if (tables[ends]) tables[ends]->print("{}", ends_row(snapshot));
  if (tables[energy] && snapshot.energy) tables[energy]->print("{}", energy_row(snapshot.time, *snapshot.energy));
  if (tables[sensitivity]) tables[sensitivity]->print("{}", sensitivity_row(snapshot));
  if (tables[gauges]) tables[gauges]->print("{}", gauges_row(snapshot, read));
  if (tables[joints]) tables[joints]->print("{}", joints_row(snapshot, joint_nodes));
  if (field) field->append(snapshot);
}

void GrowingFiles::append(const Event& event) {
  if (tables[events]) tables[events]->print("{}", events_row(event));
}

GrowingFiles::Mark GrowingFiles::mark() {
  Mark mark;
  for (std::size_t k = 0; k < tables.size(); ++k)
    if (tables[k]) mark.tables[k] = tables[k]->mark();
  if (field) mark.field = field->mark();
  return mark;
}

}  // namespace viscobar
