#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "results/output_file.hpp"

namespace viscobar {

/// An array of doubles in NumPy's format 1.0, row by row: 8 bytes "\x93NUMPY\1\0", the length of the header in two
/// bytes, the header, a Python dictionary padded with blanks to a multiple of 64, then the numbers, little-endian.
/// @throws IoError
class NpyFile {
 public:
  /// All extents are known beforehand; one extent makes a vector.
  NpyFile(const std::filesystem::path& path, std::span<const std::size_t> shape);

  void append(std::span<const double> values);
  void close() { file_.close(); }

 private:
  OutputFile file_;
  std::size_t written_ = 0;
};

}  // namespace viscobar
