#include "io/field_file.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>

namespace viscobar {

namespace {

constexpr std::size_t block_bytes = 1 << 20;

hid_t create_file(const std::filesystem::path& path) {
  begin_hdf5();
  return hdf5_checked(path, "cannot be created",
                      [&] { return H5Fcreate(path.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, H5P_DEFAULT); });
}

Hdf5Dataset create_dataset(const std::filesystem::path& path, hid_t file, const char* name, hid_t type,
                           std::span<const hsize_t> extent, std::span<const hsize_t> chunk = {}) {
  const int rank = static_cast<int>(extent.size());
  const Hdf5Properties properties(H5Pcreate(H5P_DATASET_CREATE));
  std::vector<hsize_t> largest(extent.begin(), extent.end());
  if (!chunk.empty()) {
    largest[0] = H5S_UNLIMITED;
    H5Pset_chunk(properties.get(), rank, chunk.data());
  }
  const Hdf5Dataspace space(H5Screate_simple(rank, extent.data(), largest.data()));
  return Hdf5Dataset(hdf5_checked(path, "cannot create a dataset", [&] {
    return H5Dcreate2(file, name, type, space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT);
  }));
}

/// Returns where the values are.
template <class Value>
FieldMark::Region write_all(const std::filesystem::path& path, hid_t file, const char* name, hid_t stored, hid_t type,
                            std::span<const hsize_t> extent, const std::vector<Value>& values) {
  const Hdf5Dataset dataset = create_dataset(path, file, name, stored, extent);
  hdf5_checked(path, "cannot be written",
               [&] { return H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()); });
  return {H5Dget_offset(dataset.get()), H5Dget_storage_size(dataset.get())};
}

void append_rows(const std::filesystem::path& path, const Hdf5Dataset& dataset, std::span<const hsize_t> first,
                 std::span<const hsize_t> count, const std::vector<double>& values) {
  std::vector<hsize_t> extent(count.begin(), count.end());
  extent[0] += first[0];
  hdf5_checked(path, "cannot grow", [&] { return H5Dset_extent(dataset.get(), extent.data()); });
  const Hdf5Dataspace target(H5Dget_space(dataset.get()));
  const Hdf5Dataspace source(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr));
  H5Sselect_hyperslab(target.get(), H5S_SELECT_SET, first.data(), nullptr, count.data(), nullptr);
  hdf5_checked(path, "cannot be written", [&] {
    return H5Dwrite(dataset.get(), H5T_NATIVE_DOUBLE, source.get(), target.get(), H5P_DEFAULT, values.data());
  });
}

}  // namespace

FieldFile::FieldFile(const std::filesystem::path& directory, const Mesh& mesh, std::size_t expected_rows,
                     const FieldMark* mark)
    : path_(directory / "field.h5"),
      nodes_(mesh.nodes()),
      block_rows_(std::max<std::size_t>(1, std::min(block_bytes / (sizeof(double) * nodes_), expected_rows))),
      time_chunk_(std::clamp<std::size_t>(expected_rows, 1, 4096)),
      xdmf_(directory / "field.xdmf", "field.h5", nodes_) {
  if (mark)
    go_on(*mark);
  else
    create(mesh);
}

void FieldFile::create(const Mesh& mesh) {
  new_.emplace(path_);
  file_.reset(create_file(new_->part()));
  using One = std::array<hsize_t, 1>;
  using Two = std::array<hsize_t, 2>;
  const auto grown = [&](const char* name, std::span<const hsize_t> extent, std::span<const hsize_t> chunk) {
    return create_dataset(path_, file_.get(), name, H5T_IEEE_F64LE, extent, chunk).release();
  };
  t_.reset(grown("t", One{0}, One{time_chunk_}));
  u_.reset(grown("u", Two{0, nodes_}, Two{block_rows_, nodes_}));
  v_.reset(grown("v", Two{0, nodes_}, Two{block_rows_, nodes_}));
  std::vector<double> x(nodes_), points(3 * nodes_, 0.0);
  for (std::size_t j = 0; j < nodes_; ++j) points[3 * j] = x[j] = mesh.node(j);
  std::vector<int> line(nodes_);
  std::iota(line.begin(), line.end(), 0);
  values_ = {write_all(path_, file_.get(), "x", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, One{nodes_}, x),
             write_all(path_, file_.get(), "points", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, Two{nodes_, 3}, points),
             write_all(path_, file_.get(), "line", H5T_STD_I32LE, H5T_NATIVE_INT, One{nodes_}, line)};
}

void FieldFile::take_place() {
  if (!new_) return;
  new_->take_place();
  new_.reset();
  identity_.emplace(path_);
  xdmf_.begin();
}

void FieldFile::append(const Snapshot& snapshot) {
  times_.push_back(snapshot.time);
  us_.insert(us_.end(), snapshot.u.begin(), snapshot.u.end());
  vs_.insert(vs_.end(), snapshot.v.begin(), snapshot.v.end());
  // Blocks begin where chunks begin, unless the clock cut one short.
  if ((rows_ + times_.size()) % block_rows_ == 0 || clock_.due()) flush();
}

void FieldFile::flush() {
  take_place();
  check_in_place(path_, *identity_);
  if (times_.empty()) return;
  append_rows(path_, t_, std::array<hsize_t, 1>{rows_}, std::array<hsize_t, 1>{times_.size()}, times_);
  append_rows(path_, u_, std::array<hsize_t, 2>{rows_, 0}, std::array<hsize_t, 2>{times_.size(), nodes_}, us_);
  append_rows(path_, v_, std::array<hsize_t, 2>{rows_, 0}, std::array<hsize_t, 2>{times_.size(), nodes_}, vs_);
  hdf5_checked(path_, "cannot be flushed", [&] { return H5Fflush(file_.get(), H5F_SCOPE_GLOBAL); });
  // After the rows, so that it never names one that is not there.
  xdmf_.append(times_);
  rows_ += times_.size();
  times_.clear();
  us_.clear();
  vs_.clear();
}

void FieldFile::go_on(const FieldMark& mark) {
  begin_hdf5();
  put_back(path_, mark);
  file_.reset(
      hdf5_checked(path_, "cannot be opened", [&] { return H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT); }));
  for (const auto& [name, dataset] : {std::pair{"t", &t_}, {"u", &u_}, {"v", &v_}})
    dataset->reset(hdf5_checked(path_, "lacks a dataset", [&] { return H5Dopen2(file_.get(), name, H5P_DEFAULT); }));
  rows_ = located_ = mark.rows;
  values_ = mark.values;
  identity_.emplace(path_);
  xdmf_.begin();
  std::vector<double> times(rows_);
  hdf5_checked(path_, "cannot be read",
               [&] { return H5Dread(t_.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, times.data()); });
  xdmf_.append(times);
}

// Of a chunk that was not full at the last mark the place is known.
void FieldFile::locate(const Hdf5Dataset& dataset, hsize_t chunk_rows) {
  for (hsize_t row = (located_ + chunk_rows - 1) / chunk_rows * chunk_rows; row < rows_; row += chunk_rows) {
    const std::array<hsize_t, 2> first{row, 0};
    unsigned filters = 0;
    haddr_t address = 0;
    hsize_t size = 0;
    hdf5_checked(path_, "cannot be searched",
                 [&] { return H5Dget_chunk_info_by_coord(dataset.get(), first.data(), &filters, &address, &size); });
    values_.push_back({address, size});
  }
}

FieldMark FieldFile::mark() {
  flush();
  hdf5_checked(path_, "cannot be flushed", [&] { return H5Fflush(file_.get(), H5F_SCOPE_GLOBAL); });
  locate(t_, time_chunk_);
  locate(u_, block_rows_);
  locate(v_, block_rows_);
  located_ = rows_;
  return marked(path_, rows_, values_);
}

void FieldFile::close() {
  flush();
  for (Hdf5Dataset* dataset : {&t_, &u_, &v_})
    if (dataset->get() >= 0) hdf5_checked(path_, "cannot be closed", [&] { return H5Dclose(dataset->release()); });
  if (file_.get() >= 0) hdf5_checked(path_, "cannot be closed", [&] { return H5Fclose(file_.release()); });
  xdmf_.close();
}

}  // namespace viscobar
