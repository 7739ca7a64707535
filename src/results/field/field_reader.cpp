#include "results/field/field_reader.hpp"

#include <algorithm>
#include <array>
#include <cassert>

namespace viscobar {

namespace {

Hdf5File open(const std::filesystem::path& path) {
  begin_hdf5();
  return Hdf5File(
      hdf5_checked(path, "cannot be opened", [&] { return H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT); }));
}

Hdf5Dataset open(const std::filesystem::path& path, const Hdf5File& file, const char* name) {
  return Hdf5Dataset(hdf5_checked(path, "lacks a dataset", [&] { return H5Dopen2(file.get(), name, H5P_DEFAULT); }));
}

/// Extents of a dataset that must have so many dimensions.
template <std::size_t Rank>
std::array<hsize_t, Rank> extent(const std::filesystem::path& path, const Hdf5Dataset& dataset) {
  const Hdf5Dataspace space(H5Dget_space(dataset.get()));
  if (H5Sget_simple_extent_ndims(space.get()) != static_cast<int>(Rank))
    throw IoError(path, "is no field file of viscobar: a dataset has other dimensions");
  std::array<hsize_t, Rank> extents{};
  H5Sget_simple_extent_dims(space.get(), extents.data(), nullptr);
  return extents;
}

std::vector<double> vector(const std::filesystem::path& path, const Hdf5File& file, const char* name) {
  const Hdf5Dataset dataset = open(path, file, name);
  std::vector<double> values(extent<1>(path, dataset)[0]);
  hdf5_checked(path, "cannot be read",
               [&] { return H5Dread(dataset.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()); });
  return values;
}

}  // namespace

FieldReader::FieldReader(const std::filesystem::path& file)
    : path_(file),
      file_(open(path_)),
      u_(open(path_, file_, "u")),
      v_(open(path_, file_, "v")),
      x_(vector(path_, file_, "x")),
      times_(vector(path_, file_, "t")) {
  if (H5Lexists(file_.get(), "stress", H5P_DEFAULT) > 0) stress_.emplace(open(path_, file_, "stress"));
  // A run that was killed may have left a time without its row.
  for (const Hdf5Dataset* dataset : {&u_, &v_}) {
    const auto [rows, nodes] = extent<2>(path_, *dataset);
    if (nodes != x_.size()) throw IoError(path_, "is no field file of viscobar: x and the field differ in length");
    times_.resize(std::min<std::size_t>(times_.size(), rows));
  }
  if (stress_) {
    const auto [rows, elements] = extent<2>(path_, *stress_);
    if (elements + 1 != x_.size())
      throw IoError(path_, "is no field file of viscobar: x and the stress do not fit each other");
    times_.resize(std::min<std::size_t>(times_.size(), rows));
  }
}

void FieldReader::read(Quantity quantity, std::size_t first, std::span<double> values) const {
  const std::size_t n = width(quantity);
  assert(has(quantity) && values.size() % n == 0 && first + values.size() / n <= rows());
  const Hdf5Dataset& dataset = quantity == Quantity::displacement ? u_ : quantity == Quantity::velocity ? v_ : *stress_;
  const std::array<hsize_t, 2> begin{first, 0}, count{values.size() / n, n};
  const Hdf5Dataspace source(H5Dget_space(dataset.get())), target(H5Screate_simple(2, count.data(), nullptr));
  H5Sselect_hyperslab(source.get(), H5S_SELECT_SET, begin.data(), nullptr, count.data(), nullptr);
  hdf5_checked(path_, "cannot be read", [&] {
    return H5Dread(dataset.get(), H5T_NATIVE_DOUBLE, target.get(), source.get(), H5P_DEFAULT, values.data());
  });
}

}  // namespace viscobar
