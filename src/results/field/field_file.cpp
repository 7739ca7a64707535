#include "results/field/field_file.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>

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

std::string_view bytes_of(const auto& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof values.front()};
}

/// Returns where the values are.
template <class Value>
FieldMark::Region write_all(const std::filesystem::path& path, hid_t file, const char* name, hid_t stored, hid_t type,
                            std::span<const hsize_t> extent, const std::vector<Value>& values) {
  const Hdf5Dataset dataset = create_dataset(path, file, name, stored, extent);
  hdf5_checked(path, "cannot be written",
               [&] { return H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()); });
  return {H5Dget_offset(dataset.get()), H5Dget_storage_size(dataset.get()), Checksum::of(bytes_of(values))};
}

}  // namespace

FieldFile::FieldFile(const std::filesystem::path& directory, const Mesh& mesh, std::size_t expected_rows,
                     const FieldMark* mark)
    : path_(directory / "field.h5"),
      nodes_(mesh.nodes()),
      block_rows_(std::max<std::size_t>(1, std::min(block_bytes / (sizeof(double) * nodes_), expected_rows))),
      xdmf_(directory / "field.xdmf", "field.h5", nodes_),
      t_{"t", 1, std::clamp<std::size_t>(expected_rows, 1, 4096)},
      u_{"u", nodes_, block_rows_},
      v_{"v", nodes_, block_rows_} {
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
  t_.dataset.reset(create_dataset(path_, file_.get(), t_.name, H5T_IEEE_F64LE, One{0}, One{t_.chunk_rows}).release());
  for (Growing* grown : {&u_, &v_})
    grown->dataset.reset(
        create_dataset(path_, file_.get(), grown->name, H5T_IEEE_F64LE, Two{0, nodes_}, Two{block_rows_, nodes_})
            .release());
  std::vector<double> x(nodes_), points(3 * nodes_, 0.0);
  for (std::size_t j = 0; j < nodes_; ++j) points[3 * j] = x[j] = mesh.node(j);
  std::vector<int> line(nodes_);
  std::iota(line.begin(), line.end(), 0);
  fixed_ = {write_all(path_, file_.get(), "x", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, One{nodes_}, x),
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
  append_rows(t_, times_);
  append_rows(u_, us_);
  append_rows(v_, vs_);
  hdf5_checked(path_, "cannot be flushed", [&] { return H5Fflush(file_.get(), H5F_SCOPE_GLOBAL); });
  // After the rows, so that it never names one that is not there.
  xdmf_.append(times_);
  rows_ += times_.size();
  times_.clear();
  us_.clear();
  vs_.clear();
}

void FieldFile::append_rows(Growing& grown, const std::vector<double>& values) {
  const std::array<hsize_t, 2> first{rows_, 0}, count{times_.size(), grown.row_values},
      extent{rows_ + times_.size(), grown.row_values};
  const hid_t dataset = grown.dataset.get();
  hdf5_checked(path_, "cannot grow", [&] { return H5Dset_extent(dataset, extent.data()); });
  const Hdf5Dataspace target(H5Dget_space(dataset));
  const Hdf5Dataspace source(H5Screate_simple(H5Sget_simple_extent_ndims(target.get()), count.data(), nullptr));
  H5Sselect_hyperslab(target.get(), H5S_SELECT_SET, first.data(), nullptr, count.data(), nullptr);
  hdf5_checked(path_, "cannot be written", [&] {
    return H5Dwrite(dataset, H5T_NATIVE_DOUBLE, source.get(), target.get(), H5P_DEFAULT, values.data());
  });
  const std::size_t chunk_bytes = sizeof(double) * grown.row_values * grown.chunk_rows;
  for (std::string_view rest = bytes_of(values); !rest.empty();) {
    if (grown.chunks.empty() || grown.chunks.back().values.bytes == chunk_bytes)
      grown.chunks.push_back({0, chunk_bytes, {}});
    Checksum& chunk = grown.chunks.back().values;
    const std::string_view next = rest.substr(0, chunk_bytes - chunk.bytes);
    chunk.add(next);
    rest.remove_prefix(next.size());
  }
}

void FieldFile::go_on(const FieldMark& mark) {
  begin_hdf5();
  put_back(path_, mark);
  file_.reset(
      hdf5_checked(path_, "cannot be opened", [&] { return H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT); }));
  rows_ = mark.rows;
  auto end = mark.regions.end();  // of those of a dataset, in the order of regions()
  for (Growing* grown : {&v_, &u_, &t_}) {
    grown->dataset.reset(
        hdf5_checked(path_, "lacks a dataset", [&] { return H5Dopen2(file_.get(), grown->name, H5P_DEFAULT); }));
    const auto begin = end - static_cast<std::ptrdiff_t>((rows_ + grown->chunk_rows - 1) / grown->chunk_rows);
    grown->chunks.assign(begin, end);
    grown->located = grown->chunks.size();
    end = begin;
  }
  fixed_.assign(mark.regions.begin(), end);
  identity_.emplace(path_);
  xdmf_.begin();
  std::vector<double> times(rows_);
  hdf5_checked(path_, "cannot be read", [&] {
    return H5Dread(t_.dataset.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, times.data());
  });
  xdmf_.append(times);
}

void FieldFile::locate(Growing& grown) {
  for (; grown.located < grown.chunks.size(); ++grown.located) {
    const std::array<hsize_t, 2> first{grown.located * grown.chunk_rows, 0};
    unsigned filters = 0;
    haddr_t address = 0;
    hsize_t size = 0;
    hdf5_checked(path_, "cannot be searched", [&] {
      return H5Dget_chunk_info_by_coord(grown.dataset.get(), first.data(), &filters, &address, &size);
    });
    grown.chunks[grown.located].begin = address;
  }
}

std::vector<FieldMark::Region> FieldFile::regions() {
  std::vector<FieldMark::Region> all = fixed_;
  for (Growing* grown : {&t_, &u_, &v_}) {
    locate(*grown);
    all.insert(all.end(), grown->chunks.begin(), grown->chunks.end());
  }
  return all;
}

FieldMark FieldFile::mark() {
  flush();
  hdf5_checked(path_, "cannot be flushed", [&] { return H5Fflush(file_.get(), H5F_SCOPE_GLOBAL); });
  OutputFile(path_, OutputFile::Content::keep).sync();
  return marked(path_, rows_, regions());
}

void FieldFile::close() {
  flush();
  std::vector<FieldMark::Region> values = regions();
  for (Growing* grown : {&t_, &u_, &v_})
    hdf5_checked(path_, "cannot be closed", [&] { return H5Dclose(grown->dataset.release()); });
  hdf5_checked(path_, "cannot be closed", [&] { return H5Fclose(file_.release()); });
  checksum_ = marked(path_, rows_, std::move(values)).checksum();
  xdmf_.close();
}

}  // namespace viscobar
