#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace viscobar {

/// A file that could not be created, written or replaced, and why.
class IoError : public std::runtime_error {
 public:
  IoError(std::filesystem::path path, const std::string& reason)
      : std::runtime_error(path.string() + ": " + reason), file(std::move(path)) {}
  std::filesystem::path file;
};

}  // namespace viscobar
