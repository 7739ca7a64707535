#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "results/output_file.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// A table that grows by rows. Numbers are written in the shortest form that reads back as the same double.
class GrowingTable {
 public:
  void take_place() { file_.take_place(); }
  Checksum mark() { return file_.mark(); }
  void close() { file_.close(); }
  const Checksum& checksum() const { return file_.checksum(); }

 protected:
  /// A new one, or the bytes of `keep` of one that is there.
  GrowingTable(const std::filesystem::path& path, std::string_view header, const std::optional<Checksum>& keep)
      : file_(keep ? LineFile(path, *keep) : LineFile(path)) {
    if (!keep) file_.print("{}", header);
  }
  LineFile file_;
};

/// ends.csv: a row per output time.
class EndsCsv : public GrowingTable {
 public:
  explicit EndsCsv(const std::filesystem::path& path, const std::optional<Checksum>& keep = {})
      : GrowingTable(path, "t,u_left,v_left,reaction_left,u_right,v_right,reaction_right", keep) {}
  void append(const Snapshot& snapshot);
};

/// events.csv: a row per contact change.
class EventsCsv : public GrowingTable {
 public:
  explicit EventsCsv(const std::filesystem::path& path, const std::optional<Checksum>& keep = {})
      : GrowingTable(path, "t,where,change,velocity", keep) {}
  void append(const Event& event);
};

/// sensitivity.csv: a row per output time, t and the derivatives of the columns of ends.csv with respect to each key.
class SensitivityCsv : public GrowingTable {
 public:
  SensitivityCsv(const std::filesystem::path& path, std::span<const Direction> directions,
                 const std::optional<Checksum>& keep = {});
  void append(const Snapshot& snapshot);
};

/// energy.csv: a row per output time that has an energy, with
///
///     kinetic + elastic + contact = total,   total + dissipated = total at the start + work + balance error
///
/// On the mass `fourth_order` `dissipated` includes what the end rows of the mass took, EnergyState::end_inertia.
class EnergyCsv : public GrowingTable {
 public:
  explicit EnergyCsv(const std::filesystem::path& path, const std::optional<Checksum>& keep = {})
      : GrowingTable(path, "t,kinetic,elastic,contact,dissipated,work,total", keep) {}
  void append(const Snapshot& snapshot);
};

/// left, right or span:<mesh node>
std::string place(const Event& event);

}  // namespace viscobar
