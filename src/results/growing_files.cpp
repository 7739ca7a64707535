#include "results/growing_files.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <system_error>

#include "input/described_scene.hpp"
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
  if (ends) check_begin(directory / "ends.csv", *ends);
  if (events) check_begin(directory / "events.csv", *events);
  if (energy) check_begin(directory / "energy.csv", *energy);
  if (sensitivity) check_begin(directory / "sensitivity.csv", *sensitivity);
  if (field) field->check_values(directory / "field.h5");
}

GrowingFiles::GrowingFiles(const fs::path& directory, const SceneFile& scene, const Mark* mark) {
  const Case& run = scene.run;
  const auto kept = [&](const std::optional<Checksum> Mark::*file) { return mark ? mark->*file : std::nullopt; };
  if (run.files.ends) ends.emplace(directory / "ends.csv", kept(&Mark::ends));
  if (run.files.events) events.emplace(directory / "events.csv", kept(&Mark::events));
  if (run.files.energy) energy.emplace(directory / "energy.csv", kept(&Mark::energy));
  if (!run.directions.empty())
    sensitivity.emplace(directory / "sensitivity.csv", run.directions, kept(&Mark::sensitivity));
  std::vector<std::string> keys;
  for (const Direction& direction : run.directions) keys.push_back(direction.key);
  if (run.files.field)
    field.emplace(
        directory, run.mesh(), static_cast<std::size_t>(run.end / run.output_every) + 2,
        mark && mark->field ? &*mark->field : nullptr,
        FieldOrigin{run.scene.bar, run.scene.units, run.scene.title, mark ? "" : scene_text(scene.description), keys});
}

void GrowingFiles::take_places() {
  const auto take = [](auto& file) {
    if (file) file->take_place();
  };
  take(ends), take(events), take(energy), take(sensitivity), take(field);
}

void GrowingFiles::append(const Snapshot& snapshot) {
  if (ends) ends->append(snapshot);
  if (energy) energy->append(snapshot);
  if (sensitivity) sensitivity->append(snapshot);
  if (field) field->append(snapshot);
}

void GrowingFiles::append(const Event& event) {
  if (events) events->append(event);
}

GrowingFiles::Mark GrowingFiles::mark() {
  Mark mark;
  if (ends) mark.ends = ends->mark();
  if (events) mark.events = events->mark();
  if (energy) mark.energy = energy->mark();
  if (sensitivity) mark.sensitivity = sensitivity->mark();
  if (field) mark.field = field->mark();
  return mark;
}

}  // namespace viscobar
