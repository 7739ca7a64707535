#pragma once

#include <filesystem>
#include <optional>

#include "results/csv.hpp"
#include "results/field/field_file.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

/// @throws IoError when a file does not begin with the bytes of that checksum
void check_begin(const std::filesystem::path& file, const Checksum& expected);

/// The files that grow with a run.
struct GrowingFiles {
  EndsCsv ends;
  EventsCsv events;
  FieldFile field;
  std::optional<SensitivityCsv> sensitivity;  ///< of a run with directions

  /// As much of them as belongs to a checkpoint.
  struct Mark {
    Checksum ends, events;
    FieldMark field;
    std::optional<Checksum> sensitivity;

    /// @throws IoError when one of the files in the directory does not hold what it held then
    void check(const std::filesystem::path& directory) const;
    static void members(auto& mark, auto&& each) { each(mark.ends, mark.events, mark.field, mark.sensitivity); }
  };

  /// New ones, which wait to take their places; with a mark those that are there, cut off at it. @throws IoError
  GrowingFiles(const std::filesystem::path& directory, const Case& run, const Mark* mark = nullptr)
      : ends(directory / "ends.csv", mark ? std::optional(mark->ends) : std::nullopt),
        events(directory / "events.csv", mark ? std::optional(mark->events) : std::nullopt),
        field(directory, run.mesh(), static_cast<std::size_t>(run.end / run.output_every) + 2,
              mark ? &mark->field : nullptr) {
    if (!run.directions.empty())
      sensitivity.emplace(directory / "sensitivity.csv", run.directions, mark ? mark->sensitivity : std::nullopt);
  }

  /// From now on they are seen as they grow. @throws IoError
  void take_places() {
    ends.take_place();
    events.take_place();
    field.take_place();
    if (sensitivity) sensitivity->take_place();
  }
  /// Brings all to the disk. @throws IoError
  Mark mark() {
    return {ends.mark(), events.mark(), field.mark(), sensitivity ? std::optional(sensitivity->mark()) : std::nullopt};
  }
};

}  // namespace viscobar
