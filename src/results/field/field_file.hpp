#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "results/field/hdf5_handle.hpp"
#include "results/field/xdmf_file.hpp"
#include "results/output_file.hpp"
#include "scene/unit_names.hpp"
#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/run/run.hpp"
#include "viscobar/scene/scene.hpp"

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

  Checksum checksum() const;
  /// @throws IoError when values in the file are no longer those of the mark
  void check_values(const std::filesystem::path& file) const;
};

/// The mark of a file that has been flushed. @throws IoError
FieldMark marked(const std::filesystem::path& file, std::size_t rows, std::vector<FieldMark::Region> regions);

/// @throws IoError
void put_back(const std::filesystem::path& file, const FieldMark& mark);

/// Origin of a field: the material that makes stresses of it, and the texts of its attributes.
struct FieldOrigin {
  Bar bar;
  Units units;
  std::string title, scene;  ///< the latter as a scene file; empty for a file that goes on
  /// A number that it has derivatives by, and its unit.
  struct Key {
    std::string name;
    std::optional<UnitPowers> unit{};  ///< absent: nobody knows
  };
  std::vector<Key> keys;    ///< of the derivatives that its snapshots have
  std::vector<Bar> bars{};  ///< the material of each element of a chain, see element_bars(); empty: `bar`
};

/// field.h5 with x (J+1), t (K), u and v (K x J+1), and stress (K x J), the mean over each element,
///
///     s_i = (E (u_{i+1} - u_i) + eta (v_{i+1} - v_i)) / h_i,
///
/// K growing, and field.xdmf beside it. For each key of the derivatives there are sensitivity/KEY/u and
/// sensitivity/KEY/v (K x J+1), sensitivity/KEY/reaction_left and sensitivity/KEY/reaction_right (K). Rows are
/// collected to blocks of about 1 MiB; a block that is written is flushed and readable. For ParaView there are also
/// `points` (J+1 x 3) and `line` (J x 2), the nodes of each element. The file has the attributes title, scene, units
/// and version, each dataset long_name and units, where there are any.
/// @throws IoError
class FieldFile {
 public:
  /// `expected_rows` bounds the size of a block. With a mark the file is the one that is there, as it was then.
  FieldFile(const std::filesystem::path& directory, const Mesh& mesh, std::size_t expected_rows,
            const FieldMark* mark = nullptr, const FieldOrigin& of = {});

  /// A new one is seen from now on as it grows; otherwise from its first block on. @throws IoError
  void take_place();
  void append(const Snapshot& snapshot);
  void flush();
  FieldMark mark();
  void close();

  // Once closed.
  const Checksum& checksum() const { return checksum_; }
  Checksum xdmf_checksum() const { return xdmf_.checksum(); }

 private:
  /// A dataset that grows by rows, in chunks of so many.
  struct Growing {
    std::string name;
    std::size_t row_values, chunk_rows;
    std::size_t rank = 2;
    std::vector<double> waiting{};  // not yet in the file
    Hdf5Dataset dataset{};
    std::vector<FieldMark::Region> chunks{};
    std::size_t located = 0;  // chunks whose place is known; it stays
  };

  void create(const FieldOrigin& of);
  void describe(const FieldOrigin& of);
  void go_on(const FieldMark& mark);
  void append_rows(Growing& grown);
  void locate(Growing& grown);
  std::vector<FieldMark::Region> regions();

  std::filesystem::path path_;
  Mesh mesh_;
  Bar bar_;
  std::vector<Bar> bars_;  // of each element of a chain
  std::size_t nodes_, block_rows_;
  XdmfFile xdmf_;
  std::optional<NewFile> new_;  // while it is not in its place
  std::optional<FileIdentity> identity_;
  Hdf5File file_;
  std::vector<FieldMark::Region> fixed_;  // values that do not grow
  std::vector<Growing> growing_;          // t, u, v, stress, and those of each key
  std::size_t rows_ = 0;                  // in the file
  bool torn_ = false;                     // a flush has begun, and not ended
  FlushClock clock_;
  Checksum checksum_;
};

}  // namespace viscobar
