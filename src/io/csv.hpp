#pragma once

#include <filesystem>

#include "io/output_file.hpp"
#include "viscobar/dynamics/run.hpp"

namespace viscobar {

/// ends.csv: a row per output time. Numbers are written in the shortest form that reads back as the same double.
class EndsCsv {
 public:
  explicit EndsCsv(const std::filesystem::path& path);
  void append(const Snapshot& snapshot);
  void close() { file_.close(); }

 private:
  LineFile file_;
};

/// events.csv: a row per contact change.
class EventsCsv {
 public:
  explicit EventsCsv(const std::filesystem::path& path);
  void append(const Event& event);
  void close() { file_.close(); }

 private:
  LineFile file_;
};

/// left, right or span:<mesh node>
std::string place(const Event& event);

}  // namespace viscobar
