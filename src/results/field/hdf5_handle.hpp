#pragma once

#include <hdf5.h>

#include <filesystem>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "results/output_file.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

void set_hdf5_failed();  ///< hdf5_failed() is true from now on

template <herr_t (*Close)(hid_t)>
class Hdf5Handle {
 public:
  explicit Hdf5Handle(hid_t id = H5I_INVALID_HID) : id_(id) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(other.release()) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    reset(other.release());
    return *this;
  }
  ~Hdf5Handle() { reset(); }
  void reset(hid_t id = H5I_INVALID_HID) {
    if (id_ >= 0) {
      H5E_BEGIN_TRY {
        if (Close(id_) < 0) set_hdf5_failed();
      }
      H5E_END_TRY
    }
    id_ = id;
  }
  hid_t get() const { return id_; }
  hid_t release() { return std::exchange(id_, H5I_INVALID_HID); }

 private:
  hid_t id_;
};

using Hdf5File = Hdf5Handle<H5Fclose>;
using Hdf5Dataset = Hdf5Handle<H5Dclose>;
using Hdf5Attribute = Hdf5Handle<H5Aclose>;
using Hdf5Dataspace = Hdf5Handle<H5Sclose>;
using Hdf5Properties = Hdf5Handle<H5Pclose>;
using Hdf5Type = Hdf5Handle<H5Tclose>;

/// The cause that HDF5 names innermost in its error stack, of a system call the system's own words.
std::string hdf5_cause();

/// Calls HDF5 with its printing off. @throws IoError
template <class Call>
auto hdf5_checked(const std::filesystem::path& path, const char* what, Call&& call) {
  decltype(call()) result;
  H5E_BEGIN_TRY { result = call(); }
  H5E_END_TRY
  if (result < 0) {
    set_hdf5_failed();
    throw IoError(path, std::string(what) + ": " + hdf5_cause());
  }
  return result;
}

/// Before HDF5 is used: it goes on in memory that it did not get, so that is asked for before. @throws std::bad_alloc
void begin_hdf5();

// The rest throws IoError with the name of the file. `lacking` is what is said where there is no such dataset.

Hdf5File hdf5_file(const std::filesystem::path& path, unsigned access = H5F_ACC_RDONLY, hid_t properties = H5P_DEFAULT);
Hdf5Dataset hdf5_dataset(const std::filesystem::path& path, const Hdf5File& file, const std::string& name,
                         const char* lacking = "lacks a dataset");
/// With the groups in its name. A first extent of 0 may grow without bound.
Hdf5Dataset new_dataset(const std::filesystem::path& path, const Hdf5File& file, const std::string& name, hid_t type,
                        std::span<const hsize_t> extent, hid_t properties = H5P_DEFAULT);

void read_values(const std::filesystem::path& path, const Hdf5Dataset& dataset, hid_t type, void* values);

/// A space of doubles and the rows of a dataset, all of their columns, that they are: for reading or writing them.
struct Hdf5Rows {
  Hdf5Rows(const Hdf5Dataset& dataset, hsize_t first, hsize_t rows, hsize_t row_values);
  Hdf5Dataspace memory, file;
};

/// Writes a new dataset of doubles or whole numbers, in its final size. It is closed here, where HDF5 tells what it
/// could not write: a handle that ends cannot.
template <class Value>
void write_dataset(const std::filesystem::path& path, const Hdf5File& file, const std::string& name,
                   std::span<const hsize_t> extent, const std::vector<Value>& values) {
  constexpr bool real = std::is_same_v<Value, double>;
  static_assert(real || std::is_same_v<Value, int>);
  Hdf5Dataset dataset = new_dataset(path, file, name, real ? H5T_IEEE_F64LE : H5T_STD_I32LE, extent);
  hdf5_checked(path, "cannot be written", [&] {
    return H5Dwrite(dataset.get(), real ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                    values.data());
  });
  hdf5_checked(path, "cannot be written", [&] { return H5Dclose(dataset.release()); });
}

}  // namespace viscobar
