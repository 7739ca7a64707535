#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

#include "io/output_file.hpp"
#include "viscobar/dynamics/run.hpp"

namespace viscobar {

/// ends.csv: a row per output time. Numbers are written in the shortest form that reads back as the same double.
class EndsCsv {
 public:
  /// A new one, or the first `keep` bytes of one that is there.
  explicit EndsCsv(const std::filesystem::path& path, std::optional<std::size_t> keep = {});
  void append(const Snapshot& snapshot);
  void take_place() { file_.take_place(); }
  std::size_t mark() { return file_.mark(); }
  void close() { file_.close(); }

 private:
  LineFile file_;
};

/// events.csv: a row per contact change.
class EventsCsv {
 public:
  /// A new one, or the first `keep` bytes of one that is there.
  explicit EventsCsv(const std::filesystem::path& path, std::optional<std::size_t> keep = {});
  void append(const Event& event);
  void take_place() { file_.take_place(); }
  std::size_t mark() { return file_.mark(); }
  void close() { file_.close(); }

 private:
  LineFile file_;
};

/// left, right or span:<mesh node>
std::string place(const Event& event);

}  // namespace viscobar
