#pragma once

#include <hdf5.h>

#include <cstddef>
#include <filesystem>
#include <utility>
#include <vector>

#include "io/output_file.hpp"
#include "io/xdmf_file.hpp"
#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/dynamics/run.hpp"

namespace viscobar {

/// Owns an HDF5 identifier.
template <herr_t (*Close)(hid_t)>
class Hdf5Handle {
 public:
  explicit Hdf5Handle(hid_t id) : id_(id) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  ~Hdf5Handle() {
    if (id_ < 0) return;
    H5E_BEGIN_TRY { Close(id_); }
    H5E_END_TRY
  }
  hid_t get() const { return id_; }
  hid_t release() { return std::exchange(id_, H5I_INVALID_HID); }

 private:
  hid_t id_;
};

using Hdf5File = Hdf5Handle<H5Fclose>;
using Hdf5Dataset = Hdf5Handle<H5Dclose>;

/// field.h5 with x (J+1), t (K), u and v (K x J+1), K growing, and field.xdmf beside it. Rows are collected to blocks
/// of about 1 MiB; a block that is written is flushed and readable. For ParaView there are also `points` (J+1 x 3) and
/// `line`, the node numbers. @throws IoError
class FieldFile {
 public:
  /// `expected_rows` bounds the size of a block.
  FieldFile(const std::filesystem::path& directory, const Mesh& mesh, std::size_t expected_rows);

  void append(const Snapshot& snapshot);
  void flush();
  void close();

 private:
  std::filesystem::path path_;
  std::size_t nodes_, block_rows_;
  XdmfFile xdmf_;
  Hdf5File file_;
  Hdf5Dataset t_, u_, v_;
  std::size_t rows_ = 0;                 // in the file
  std::vector<double> times_, us_, vs_;  // not yet in the file
  FlushClock clock_;
};

}  // namespace viscobar
