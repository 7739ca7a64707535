#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "io/output_file.hpp"

namespace viscobar {

/// The description that lets ParaView open field.h5: a temporal collection of polylines with displacement and velocity
/// at the nodes. It is complete after every append(): the closing tags are overwritten by the next times.
class XdmfFile {
 public:
  XdmfFile(const std::filesystem::path& path, std::string field_file, std::size_t nodes);

  /// Adds the next times; their rows must be in the field file by now.
  void append(std::span<const double> times);
  void close() { file_.close(); }

 private:
  OutputFile file_;
  std::string field_file_;
  std::size_t nodes_, end_ = 0, rows_ = 0;
};

}  // namespace viscobar
