#include "results/field/field_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

namespace viscobar {

namespace {

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
  const Hdf5Dataset dataset = hdf5_dataset(path, file, name);
  std::vector<double> values(extent<1>(path, dataset)[0]);
  read_values(path, dataset, H5T_NATIVE_DOUBLE, values.data());
  return values;
}

}  // namespace

const char* FieldReader::name(Quantity quantity) {
  return std::array{"u", "v", "stress"}[static_cast<std::size_t>(quantity)];
}

FieldReader::FieldReader(const std::filesystem::path& file)
    : path_(file), file_(hdf5_file(path_)), x_(vector(path_, file_, "x")), times_(vector(path_, file_, "t")) {
  for (const Quantity quantity : quantities) {
    if (quantity == Quantity::stress && H5Lexists(file_.get(), "stress", H5P_DEFAULT) <= 0) continue;
    Hdf5Dataset& dataset = datasets_[static_cast<std::size_t>(quantity)];
    dataset = hdf5_dataset(path_, file_, name(quantity));
    const auto [rows, values] = extent<2>(path_, dataset);
    if (x_.empty() || values != width(quantity))
      throw IoError(path_, fmt::format("is no field file of viscobar: x and {} differ in length", name(quantity)));
    // A run that was killed may have left a time without its row.
    times_.resize(std::min<std::size_t>(times_.size(), rows));
  }
}

void FieldReader::read(Quantity quantity, std::size_t first, std::span<double> values) const {
  const std::size_t n = width(quantity);
  assert(has(quantity) && values.size() % n == 0 && first + values.size() / n <= rows());
  const Hdf5Rows source(dataset(quantity), first, values.size() / n, n);
  hdf5_checked(path_, "cannot be read", [&] {
    return H5Dread(dataset(quantity).get(), H5T_NATIVE_DOUBLE, source.memory.get(), source.file.get(), H5P_DEFAULT,
                   values.data());
  });
}

}  // namespace viscobar
