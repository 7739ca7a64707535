#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "results/checksum.hpp"

namespace viscobar {

/// The description that lets ParaView open field.h5: a temporal collection of grids whose cells are the elements, with
/// displacement and velocity at the nodes and the stress of each cell. Their mesh stands in the first and is referred
/// to by the others. A new one is made from the old and
/// takes its place at once, so whatever happens to a run there is a whole one; that costs a copy, and is done so often
/// that it takes a twentieth of the time. @throws IoError
class XdmfFile {
 public:
  XdmfFile(std::filesystem::path path, std::string field_file, std::size_t nodes);

  /// Writes one without times.
  void begin();
  /// Adds the next times; their rows must be in the field file by now.
  void append(std::span<const double> times);
  void close();
  /// Of the file as it is.
  Checksum checksum() const;

 private:
  using Clock = std::chrono::steady_clock;
  void publish();
  std::string grid(std::size_t row, double time) const;

  std::filesystem::path path_;
  std::string field_file_;
  std::size_t nodes_, rows_ = 0;
  Checksum written_;  // of what stands before the closing tags
  std::vector<double> pending_;
  Clock::time_point next_ = Clock::now();
};

}  // namespace viscobar
