#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace viscobar {

/// A file that could not be created, written or replaced, and why.
class IoError : public std::runtime_error {
 public:
  /// With the message "path: reason".
  IoError(std::filesystem::path path, const std::string& reason)
      : std::runtime_error(path.string() + ": " + reason), file(std::move(path)) {}
  std::filesystem::path file;  ///< that could not be read or written
};

}  // namespace viscobar
