#include "results/field/field_file.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <utility>

#include "dynamics/element_stress.hpp"
#include "scene/unit_names.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar {

namespace {

constexpr std::size_t block_bytes = 1 << 20;

hid_t create_file(const std::filesystem::path& path) {
  begin_hdf5();
  return hdf5_checked(path, "cannot be created",
                      [&] { return H5Fcreate(path.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, H5P_DEFAULT); });
}

// That grows by rows.
hid_t create_growing(const std::filesystem::path& path, hid_t file, const char* name, std::span<const hsize_t> chunk) {
  const int rank = static_cast<int>(chunk.size());
  const Hdf5Properties properties(H5Pcreate(H5P_DATASET_CREATE));
  H5Pset_chunk(properties.get(), rank, chunk.data());
  std::vector<hsize_t> extent(chunk.begin(), chunk.end()), largest = extent;
  extent[0] = 0;
  largest[0] = H5S_UNLIMITED;
  const Hdf5Dataspace space(H5Screate_simple(rank, extent.data(), largest.data()));
  return hdf5_checked(path, "cannot create a dataset", [&] {
    return H5Dcreate2(file, name, H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT);
  });
}

std::string_view bytes_of(const auto& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof values.front()};
}

/// A string of variable length, as readers take it most easily.
void write_attribute(const std::filesystem::path& path, hid_t object, const char* name, const std::string& text) {
  const Hdf5Type type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  const Hdf5Dataspace scalar(H5Screate(H5S_SCALAR));
  const Hdf5Attribute attribute(hdf5_checked(path, "cannot create an attribute", [&] {
    return H5Acreate2(object, name, type.get(), scalar.get(), H5P_DEFAULT, H5P_DEFAULT);
  }));
  const char* value = text.c_str();
  hdf5_checked(path, "cannot write an attribute", [&] { return H5Awrite(attribute.get(), type.get(), &value); });
}

}  // namespace

FieldFile::FieldFile(const std::filesystem::path& directory, const Mesh& mesh, std::size_t expected_rows,
                     const FieldMark* mark, const FieldOrigin& of)
    : path_(directory / "field.h5"),
      mesh_(mesh),
      bar_(of.bar),
      nodes_(mesh.nodes()),
      block_rows_(std::max<std::size_t>(1, std::min(block_bytes / (sizeof(double) * nodes_), expected_rows))),
      xdmf_(directory / "field.xdmf", nodes_),
      t_{"t", 1, std::clamp<std::size_t>(expected_rows, 1, 4096)},
      u_{"u", nodes_, block_rows_},
      v_{"v", nodes_, block_rows_},
      stress_{"stress", nodes_ - 1, block_rows_} {
  if (mark)
    go_on(*mark);
  else
    create(of);
}

void FieldFile::create(const FieldOrigin& of) {
  new_.emplace(path_);
  file_.reset(create_file(new_->part()));
  using Extent = std::array<hsize_t, 2>;
  const auto grow = [&](Growing& grown, std::size_t rank) {
    const Extent chunk{grown.chunk_rows, grown.row_values};
    grown.dataset.reset(create_growing(path_, file_.get(), grown.name, std::span(chunk).first(rank)));
  };
  grow(t_, 1), grow(u_, 2), grow(v_, 2), grow(stress_, 2);
  const auto fix = [&](const char* name, Extent extent, std::size_t rank, const auto& values) {
    const Hdf5Dataset dataset = write_dataset(path_, file_.get(), name, std::span(extent).first(rank), values);
    fixed_.push_back(
        {H5Dget_offset(dataset.get()), H5Dget_storage_size(dataset.get()), Checksum::of(bytes_of(values))});
  };
  std::vector<double> x(nodes_);
  for (std::size_t j = 0; j < nodes_; ++j) x[j] = mesh_.node(j);
  fix("x", {nodes_, 0}, 1, x);
  fix("points", {nodes_, 3}, 2, xdmf::points(x));
  fix("line", {nodes_ - 1, 2}, 2, xdmf::line(nodes_));
  describe(of);
}

void FieldFile::describe(const FieldOrigin& of) {
  const hid_t file = file_.get();
  // The format takes no more in one attribute.
  constexpr std::size_t most = 60'000;
  const auto of_file = [&](const char* name, const std::string& text) {
    if (!text.empty()) write_attribute(path_, file, name, text.size() <= most ? text : "too long: see summary.json");
  };
  of_file("title", of.title);
  of_file("scene", of.scene);
  of_file("units", named_units(of.units));
  of_file("version", "viscobar " + versions().viscobar);
  struct Meaning {
    const char *dataset, *long_name;
    std::optional<Dimension> quantity;
  };
  const Meaning meanings[] = {{"t", "output times", Dimension::time},
                              {"x", "nodes", Dimension::length},
                              {"u", "displacement of the nodes, times x nodes", Dimension::length},
                              {"v", "velocity of the nodes, times x nodes", Dimension::velocity},
                              {"stress", "mean stress of each element, times x elements", Dimension::stress},
                              {"points", "nodes in space, for field.xdmf", Dimension::length},
                              {"line", "the two nodes of each element, for field.xdmf", std::nullopt}};
  for (const Meaning& of_one : meanings) {
    const Hdf5Dataset dataset(
        hdf5_checked(path_, "lacks a dataset", [&] { return H5Dopen2(file, of_one.dataset, H5P_DEFAULT); }));
    write_attribute(path_, dataset.get(), "long_name", of_one.long_name);
    const std::string unit = of_one.quantity ? unit_name(of.units, *of_one.quantity) : "";
    if (!unit.empty()) write_attribute(path_, dataset.get(), "units", unit);
  }
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
  add_stress(snapshot);
  // Blocks begin where chunks begin, unless the clock cut one short.
  if ((rows_ + times_.size()) % block_rows_ == 0 || clock_.due()) flush();
}

void FieldFile::add_stress(const Snapshot& at) {
  for (std::size_t j = 0; j + 1 < nodes_; ++j) stresses_.push_back(element_stress(bar_, mesh_, at.u, at.v, j));
}

void FieldFile::flush() {
  take_place();
  check_in_place(path_, *identity_);
  if (times_.empty()) return;
  append_rows(t_, times_);
  append_rows(u_, us_);
  append_rows(v_, vs_);
  append_rows(stress_, stresses_);
  hdf5_checked(path_, "cannot be flushed", [&] { return H5Fflush(file_.get(), H5F_SCOPE_GLOBAL); });
  // After the rows, so that it never names one that is not there.
  xdmf_.append(times_);
  rows_ += times_.size();
  times_.clear();
  us_.clear();
  vs_.clear();
  stresses_.clear();
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
  for (Growing* grown : {&stress_, &v_, &u_, &t_}) {
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
  for (Growing* grown : growing()) {
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
  for (Growing* grown : growing())
    hdf5_checked(path_, "cannot be closed", [&] { return H5Dclose(grown->dataset.release()); });
  hdf5_checked(path_, "cannot be closed", [&] { return H5Fclose(file_.release()); });
  checksum_ = marked(path_, rows_, std::move(values)).checksum();
  xdmf_.close();
}

}  // namespace viscobar
