#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "results/checksum.hpp"

namespace viscobar {

/// A growing HDF5 file as it was at some moment.
///
/// Values that have been written never change nor move. What HDF5 keeps beside them to find them does, and a kill may
/// leave that half written: so a mark holds all bytes of the file that are no values, and putting them back makes the
/// file what it was, whatever happened to it since. Of the values it holds the checksums, taken while they were
/// written: nothing is read again for them.
struct FieldMark {
  /// A place for values, with zeros behind those that are there.
  struct Region {
    std::size_t begin = 0, length = 0;
    Checksum values;
    static void members(auto& region, auto&& each) { each(region.begin, region.length, region.values); }
  };

  std::size_t rows = 0;         ///< of the datasets that grow
  std::size_t length = 0;       ///< of the file, in bytes
  std::vector<Region> regions;  ///< where the values lie
  std::string others;           ///< the bytes outside of these, in their order

  static void members(auto& mark, auto&& each) { each(mark.rows, mark.length, mark.regions, mark.others); }

  /// Of the whole file.
  Checksum checksum() const;
  /// @throws IoError when values in the file are no longer those of the mark
  void check_values(const std::filesystem::path& file) const;
};

/// The mark of a file that has been flushed. @throws IoError
FieldMark marked(const std::filesystem::path& file, std::size_t rows, std::vector<FieldMark::Region> regions);

/// @throws IoError
void put_back(const std::filesystem::path& file, const FieldMark& mark);

}  // namespace viscobar
