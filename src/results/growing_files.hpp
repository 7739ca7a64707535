#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "dynamics/gauge.hpp"
#include "results/field/field_file.hpp"
#include "results/output_file.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {

/// @throws IoError when a file does not begin with the bytes of that checksum
void check_begin(const std::filesystem::path& file, const Checksum& expected);

/// The nodes to the right of the joints of a chain that are not bonded.
std::vector<std::size_t> joint_nodes_of(const Case& run);

/// The files that grow with a run, those that its scene asks for.
struct GrowingFiles {
  /// The last ones of a run with directions, with gauges, and of a chain with joints that are not bonded.
  enum Table : std::size_t { ends, events, energy, sensitivity, gauges, joints };
  static constexpr std::array names = {"ends.csv",        "events.csv", "energy.csv",
                                       "sensitivity.csv", "gauges.csv", "joints.csv"};

  std::array<std::optional<LineFile>, names.size()> tables;
  std::optional<FieldFile> field;
  std::vector<Gauge> read;               ///< at the gauges
  std::vector<std::size_t> joint_nodes;  ///< to the right of the joints

  /// As much of them as belongs to a checkpoint.
  struct Mark {
    std::array<std::optional<Checksum>, names.size()> tables;
    std::optional<FieldMark> field;

    /// @throws IoError when one of the files in the directory does not hold what it held then
    void check(const std::filesystem::path& directory) const;
    static void members(auto& mark, auto&& each) {
      for (auto& table : mark.tables) each(table);
      each(mark.field);
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
