#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "results/csv.hpp"
#include "results/field/field_file.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {

/// @throws IoError when a file does not begin with the bytes of that checksum
void check_begin(const std::filesystem::path& file, const Checksum& expected);

/// The files that grow with a run, those that its scene asks for.
struct GrowingFiles {
  std::optional<EndsCsv> ends;
  std::optional<EventsCsv> events;
  std::optional<EnergyCsv> energy;
  std::optional<SensitivityCsv> sensitivity;  ///< of a run with directions
  std::optional<FieldFile> field;

  /// As much of them as belongs to a checkpoint.
  struct Mark {
    std::optional<Checksum> ends, events, energy, sensitivity;
    std::optional<FieldMark> field;

    /// @throws IoError when one of the files in the directory does not hold what it held then
    void check(const std::filesystem::path& directory) const;
    static void members(auto& mark, auto&& each) {
      each(mark.ends, mark.events, mark.energy, mark.sensitivity, mark.field);
    }
  };

  /// New ones, which wait to take their places; with a mark those that are there, cut off at it. @throws IoError
  GrowingFiles(const std::filesystem::path& directory, const SceneFile& scene, const Mark* mark = nullptr);

  /// From now on they are seen as they grow. @throws IoError
  void take_places();
  void append(const Snapshot& snapshot);
  void append(const Event& event);
  /// Brings all to the disk. @throws IoError
  Mark mark();
};

}  // namespace viscobar
