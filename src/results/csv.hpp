#pragma once

#include <filesystem>
#include <optional>
#include <span>

#include "results/output_file.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// ends.csv: a row per output time. Numbers are written in the shortest form that reads back as the same double.
class EndsCsv {
 public:
  /// A new one, or the bytes of `keep` of one that is there.
  explicit EndsCsv(const std::filesystem::path& path, const std::optional<Checksum>& keep = {});
  void append(const Snapshot& snapshot);
  void take_place() { file_.take_place(); }
  Checksum mark() { return file_.mark(); }
  void close() { file_.close(); }
  const Checksum& checksum() const { return file_.checksum(); }

 private:
  LineFile file_;
};

/// sensitivity.csv: a row per output time, t and the derivatives of the columns of ends.csv with respect to each key.
class SensitivityCsv {
 public:
  /// A new one, or the bytes of `keep` of one that is there.
  SensitivityCsv(const std::filesystem::path& path, std::span<const Direction> directions,
                 const std::optional<Checksum>& keep = {});
  void append(const Snapshot& snapshot);
  void take_place() { file_.take_place(); }
  Checksum mark() { return file_.mark(); }
  void close() { file_.close(); }
  const Checksum& checksum() const { return file_.checksum(); }

 private:
  LineFile file_;
};

/// events.csv: a row per contact change.
class EventsCsv {
 public:
  /// A new one, or the bytes of `keep` of one that is there.
  explicit EventsCsv(const std::filesystem::path& path, const std::optional<Checksum>& keep = {});
  void append(const Event& event);
  void take_place() { file_.take_place(); }
  Checksum mark() { return file_.mark(); }
  void close() { file_.close(); }
  const Checksum& checksum() const { return file_.checksum(); }

 private:
  LineFile file_;
};

/// left, right or span:<mesh node>
std::string place(const Event& event);

}  // namespace viscobar
