#include "results/field/field_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <span>
#include <string_view>
#include <utility>

#include "dynamics/gauge.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar {

namespace {

constexpr std::size_t block_bytes = 1 << 20;

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

/// Visits the file in its order: a gap (of length 0 where there is none), the region behind it, and so on; behind the
/// last gap comes a region of length 0.
template <class Visit>
void for_each_part(const FieldMark& mark, Visit&& visit) {
  std::vector<FieldMark::Region> regions = mark.regions;
  std::ranges::sort(regions, {}, &FieldMark::Region::begin);
  regions.push_back({mark.length, 0, {}});
  std::size_t at = 0;
  for (const FieldMark::Region& region : regions) {
    visit(at, region.begin - at, region);
    at = region.begin + region.length;
  }
}

}  // namespace

Checksum FieldMark::checksum() const {
  Checksum whole;
  std::string_view rest = others;
  for_each_part(*this, [&](std::size_t, std::size_t gap, const Region& region) {
    whole.add(rest.substr(0, gap));
    rest.remove_prefix(gap);
    whole.append(region.values);
    whole.append(Checksum::of_zeros(region.length - region.values.bytes));
  });
  return whole;
}

void FieldMark::check_values(const std::filesystem::path& file) const {
  for (const Region& region : regions)
    if (checksum_of_file(file, region.begin, region.values.bytes) != region.values)
      throw IoError(file,
                    fmt::format("its bytes {} to {} are not those of the checkpoint: it was changed or damaged since",
                                region.begin, region.begin + region.values.bytes));
}

FieldMark marked(const std::filesystem::path& file, std::size_t rows, std::vector<FieldMark::Region> regions) {
  FieldMark mark{rows, std::filesystem::file_size(file), std::move(regions), {}};
  std::ifstream stream(file, std::ios::binary);
  for_each_part(mark, [&](std::size_t gap, std::size_t length, const FieldMark::Region&) {
    const std::size_t before = mark.others.size();
    mark.others.resize(before + length);
    stream.seekg(static_cast<std::streamoff>(gap));
    stream.read(mark.others.data() + before, static_cast<std::streamsize>(length));
  });
  if (!stream) throw IoError(file, "cannot be read back");
  return mark;
}

void put_back(const std::filesystem::path& file, const FieldMark& mark) {
  OutputFile raw(file, OutputFile::Content::keep);
  raw.cut_at(mark.length);
  std::string_view others = mark.others;
  for_each_part(mark, [&](std::size_t gap, std::size_t length, const FieldMark::Region& region) {
    raw.write_at(gap, others.substr(0, length));
    others.remove_prefix(length);
    // Values that came later.
    raw.write_at(region.begin + region.values.bytes, std::string(region.length - region.values.bytes, '\0'));
  });
  raw.sync();
  raw.close();
}

FieldFile::FieldFile(const std::filesystem::path& directory, const Mesh& mesh, std::size_t expected_rows,
                     const FieldMark* mark, const FieldOrigin& of)
    : path_(directory / "field.h5"),
      mesh_(mesh),
      bar_(of.bar),
      bars_(of.bars),
      nodes_(mesh.nodes()),
      block_rows_(std::max<std::size_t>(1, std::min(block_bytes / (sizeof(double) * nodes_), expected_rows))),
      xdmf_(directory / "field.xdmf", nodes_) {
  const std::size_t long_chunk = std::clamp<std::size_t>(expected_rows, 1, 4096);
  growing_.push_back({"t", 1, long_chunk, 1});
  for (const char* name : {"u", "v"}) growing_.push_back({name, nodes_, block_rows_});
  growing_.push_back({"stress", nodes_ - 1, block_rows_});
  for (const auto& [key, unit] : of.keys) {
    const std::string group = "sensitivity/" + key + "/";
    for (const char* name : {"u", "v"}) growing_.push_back({group + name, nodes_, block_rows_});
    for (const char* name : {"reaction_left", "reaction_right"}) growing_.push_back({group + name, 1, long_chunk, 1});
  }
  for (Growing& grown : growing_) grown.waiting.reserve(block_rows_ * grown.row_values);
  if (mark)
    go_on(*mark);
  else
    create(of);
}

void FieldFile::create(const FieldOrigin& of) {
  new_.emplace(path_);
  begin_hdf5();
  file_.reset(hdf5_checked(new_->part(), "cannot be created",
                           [&] { return H5Fcreate(new_->part().c_str(), H5F_ACC_EXCL, H5P_DEFAULT, H5P_DEFAULT); }));
  using Extent = std::array<hsize_t, 2>;
  for (Growing& grown : growing_) {
    const Extent chunk{grown.chunk_rows, grown.row_values}, none{0, grown.row_values};
    const Hdf5Properties properties(H5Pcreate(H5P_DATASET_CREATE));
    H5Pset_chunk(properties.get(), static_cast<int>(grown.rank), chunk.data());
    grown.dataset =
        new_dataset(path_, file_, grown.name, H5T_IEEE_F64LE, std::span(none).first(grown.rank), properties.get());
  }
  const auto fix = [&](const char* name, Extent extent, std::size_t rank, const auto& values) {
    write_dataset(path_, file_, name, std::span(extent).first(rank), values);
    const Hdf5Dataset dataset = hdf5_dataset(path_, file_, name);
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
  // The format takes no more in one attribute.
  constexpr std::size_t most = 60'000;
  const auto of_file = [&](const char* name, const std::string& text) {
    if (!text.empty())
      write_attribute(path_, file_.get(), name, text.size() <= most ? text : "too long: see summary.json");
  };
  of_file("title", of.title);
  of_file("scene", of.scene);
  of_file("units", named_units(of.units));
  of_file("version", "viscobar " + versions().viscobar);
  const auto of_dataset = [&](const std::string& name, const std::string& meaning, const std::string& unit) {
    const Hdf5Dataset dataset = hdf5_dataset(path_, file_, name);
    write_attribute(path_, dataset.get(), "long_name", meaning);
    if (!unit.empty()) write_attribute(path_, dataset.get(), "units", unit);
  };
  struct Meaning {
    const char *name, *words;
    Dimension quantity;
  };
  const Meaning u{"u", "displacement of the nodes, times x nodes", Dimension::length},
      v{"v", "velocity of the nodes, times x nodes", Dimension::velocity};
  for (const auto& [name, words, quantity] :
       {Meaning{"t", "output times", Dimension::time}, Meaning{"x", "nodes", Dimension::length}, u, v,
        Meaning{"stress", "mean stress of each element, times x elements", Dimension::stress},
        Meaning{"points", "nodes in space, for field.xdmf", Dimension::length}})
    of_dataset(name, words, unit_name(of.units, quantity));
  of_dataset("line", "the two nodes of each element, for field.xdmf", "");
  for (const auto& [key, per] : of.keys)
    for (const auto& [name, words, quantity] :
         {u, v, Meaning{"reaction_left", "reaction at the left end", Dimension::force},
          Meaning{"reaction_right", "reaction at the right end", Dimension::force}})
      of_dataset("sensitivity/" + key + "/" + name, fmt::format("derivative with respect to {}: {}", key, words),
                 unit_name(of.units, quantity, per));
}

void FieldFile::take_place() {
  if (!new_) return;
  new_->take_place();
  new_.reset();
  identity_.emplace(path_);
  xdmf_.begin();
}

void FieldFile::append(const Snapshot& snapshot) {
  auto to = growing_.begin();
  const auto add = [&](std::span<const double> row) {
    to->waiting.insert(to->waiting.end(), row.begin(), row.end());
    ++to;
  };
  add({&snapshot.time, 1});
  add(snapshot.u);
  add(snapshot.v);
  for (std::size_t j = 0; j + 1 < nodes_; ++j)
    to->waiting.push_back(element_stress(bars_.empty() ? bar_ : bars_[j], mesh_, snapshot.u, snapshot.v, j));
  ++to;
  for (const FieldSensitivity& s : snapshot.sensitivities) {
    add(s.u);
    add(s.v);
    add({&s.reaction_left, 1});
    add({&s.reaction_right, 1});
  }
  // Blocks begin where chunks begin, unless the clock cut one short.
  if ((rows_ + growing_.front().waiting.size()) % block_rows_ == 0 || clock_.due()) flush();
}

void FieldFile::flush() {
  take_place();
  check_in_place(path_, *identity_);
  const std::vector<double>& times = growing_.front().waiting;
  if (times.empty()) return;
  // Rows written once more would not have the checksums that they get.
  if (std::exchange(torn_, true)) throw IoError(path_, "is left as a failure in the middle of its rows left it");
  for (Growing& grown : growing_) append_rows(grown);
  hdf5_checked(path_, "cannot be flushed", [&] { return H5Fflush(file_.get(), H5F_SCOPE_GLOBAL); });
  // After the rows, so that it never names one that is not there.
  xdmf_.append(times);
  rows_ += times.size();
  for (Growing& grown : growing_) grown.waiting.clear();
  torn_ = false;
}

void FieldFile::append_rows(Growing& grown) {
  const std::vector<double>& values = grown.waiting;
  const std::size_t rows = values.size() / grown.row_values;
  const std::array<hsize_t, 2> extent{rows_ + rows, grown.row_values};
  const hid_t dataset = grown.dataset.get();
  hdf5_checked(path_, "cannot grow", [&] { return H5Dset_extent(dataset, extent.data()); });
  const Hdf5Rows target(grown.dataset, rows_, rows, grown.row_values);
  hdf5_checked(path_, "cannot be written", [&] {
    return H5Dwrite(dataset, H5T_NATIVE_DOUBLE, target.memory.get(), target.file.get(), H5P_DEFAULT, values.data());
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
  put_back(path_, mark);
  file_ = hdf5_file(path_, H5F_ACC_RDWR);
  rows_ = mark.rows;
  auto end = mark.regions.end();  // of those of a dataset, in the order of regions()
  for (auto grown = growing_.rbegin(); grown != growing_.rend(); ++grown) {
    grown->dataset = hdf5_dataset(path_, file_, grown->name);
    const auto begin = end - static_cast<std::ptrdiff_t>((rows_ + grown->chunk_rows - 1) / grown->chunk_rows);
    grown->chunks.assign(begin, end);
    grown->located = grown->chunks.size();
    end = begin;
  }
  fixed_.assign(mark.regions.begin(), end);
  identity_.emplace(path_);
  xdmf_.begin();
  std::vector<double> times(rows_);
  read_values(path_, growing_.front().dataset, H5T_NATIVE_DOUBLE, times.data());
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
  for (Growing& grown : growing_) {
    locate(grown);
    all.insert(all.end(), grown.chunks.begin(), grown.chunks.end());
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
  for (Growing& grown : growing_)
    hdf5_checked(path_, "cannot be closed", [&] { return H5Dclose(grown.dataset.release()); });
  hdf5_checked(path_, "cannot be closed", [&] { return H5Fclose(file_.release()); });
  checksum_ = marked(path_, rows_, std::move(values)).checksum();
  xdmf_.close();
}

}  // namespace viscobar
