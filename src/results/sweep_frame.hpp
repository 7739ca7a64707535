#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "text/checksum.hpp"

namespace viscobar {

/// Stands before the HDF5 file in sweep.h5, in the bytes that HDF5 leaves to its user, and tells whether the file is
/// the one that was written without asking HDF5, which takes damage for orders. All but the values of the rows is there
/// from the beginning and never changes: its checksum is here. A row has its own, in the dataset `checksums`.
struct SweepFrame {
  static constexpr std::size_t bytes = 512;

  struct Part {
    std::uint64_t begin = 0, length = 0;
    static void members(auto& part, auto&& each) { each(part.begin, part.length); }
  };
  Part identity, rows, timings, checksums, done;
  Checksum rest;  ///< of all else behind this frame, the identity included

  static void members(auto& frame, auto&& each) {
    each(frame.identity, frame.rows, frame.timings, frame.checksums, frame.done, frame.rest);
  }

  std::size_t cases() const { return done.length; }
  /// Counts the rest of a file that has just been made, and writes the frame into it. @throws IoError
  void write(const std::filesystem::path& file);
  /// Nothing for a file of an earlier version, which has none. @throws IoError when the frame or the rest is damaged
  static std::optional<SweepFrame> read(const std::filesystem::path& file);
};

/// The checksum of a row: of the sweep's identity, the row and its timings, as they lie in the file.
std::uint64_t row_checksum(const Checksum& identity, std::string_view row, std::string_view timings);

struct SweepRowStates {
  std::size_t done = 0;              ///< marked as done
  std::vector<std::size_t> damaged;  ///< cases that are marked, and are not what was written
};
/// @throws IoError
SweepRowStates check_rows(const std::filesystem::path& file, const SweepFrame& frame);

}  // namespace viscobar
