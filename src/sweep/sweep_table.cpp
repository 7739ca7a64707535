#include "sweep/sweep_table.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <utility>

#include "results/output_file.hpp"
#include "results/sweep_frame.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

constexpr std::array timing_names = {"seconds", "integration_seconds"};

struct Timings {
  double seconds, integration_seconds;
};

Hdf5Type native(const TableField& field) {
  switch (field.kind) {
    case TableField::Kind::real: return Hdf5Type(H5Tcopy(H5T_IEEE_F64LE));
    case TableField::Kind::whole: return Hdf5Type(H5Tcopy(H5T_STD_I64LE));
    case TableField::Kind::flag: return Hdf5Type(H5Tcopy(H5T_STD_U8LE));
    case TableField::Kind::text: break;
  }
  Hdf5Type type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type.get(), field.bytes);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  return type;
}

Hdf5Type compound(std::span<const TableField> fields) {
  Hdf5Type type(H5Tcreate(H5T_COMPOUND, fields.back().offset + fields.back().bytes));
  for (const TableField& field : fields) H5Tinsert(type.get(), field.name.c_str(), field.offset, native(field).get());
  return type;
}

std::vector<TableField> timing_fields() {
  std::vector<TableField> fields;
  for (const char* name : timing_names)
    fields.push_back({name, TableField::Kind::real, sizeof(double), fields.size() * sizeof(double)});
  return fields;
}

// At its full size from the beginning, in one piece, filled with zeros by the file system.
SweepFrame::Part create_dataset(const fs::path& path, hid_t file, const char* name, hid_t type, hsize_t rows,
                                const void* values = nullptr) {
  const Hdf5Properties properties(H5Pcreate(H5P_DATASET_CREATE));
  H5Pset_layout(properties.get(), H5D_CONTIGUOUS);
  H5Pset_alloc_time(properties.get(), H5D_ALLOC_TIME_EARLY);
  H5Pset_fill_time(properties.get(), H5D_FILL_TIME_NEVER);
  H5Pset_obj_track_times(properties.get(), false);
  const Hdf5Dataspace space(H5Screate_simple(1, &rows, nullptr));
  const Hdf5Dataset dataset(hdf5_checked(path, "cannot create a dataset", [&] {
    return H5Dcreate2(file, name, type, space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT);
  }));
  if (values)
    hdf5_checked(path, "cannot be written",
                 [&] { return H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values); });
  return {H5Dget_offset(dataset.get()), H5Dget_storage_size(dataset.get())};
}

Hdf5Dataset open_dataset(const fs::path& path, hid_t file, const char* name) {
  return Hdf5Dataset(
      hdf5_checked(path, "is not the table of a sweep", [&] { return H5Dopen2(file, name, H5P_DEFAULT); }));
}

// Rows go to the file at once: nothing is collected on the way.
Hdf5File open_file(const fs::path& path) {
  const Hdf5Properties access(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_sieve_buf_size(access.get(), 0);
  return Hdf5File(hdf5_checked(path, "cannot be opened (is another sweep writing it?)",
                               [&] { return H5Fopen(path.c_str(), H5F_ACC_RDWR, access.get()); }));
}

std::string text_of(const fs::path& path, const Hdf5Dataset& dataset) {
  const Hdf5Dataspace space(H5Dget_space(dataset.get()));
  std::string text(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get())), '\0');
  hdf5_checked(path, "cannot be read",
               [&] { return H5Dread(dataset.get(), H5T_NATIVE_CHAR, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()); });
  return text;
}

void write_row(const fs::path& path, const Hdf5Dataset& dataset, hid_t type, hsize_t row, const void* data) {
  const hsize_t one = 1;
  const Hdf5Dataspace target(H5Dget_space(dataset.get())), source(H5Screate_simple(1, &one, nullptr));
  H5Sselect_hyperslab(target.get(), H5S_SELECT_SET, &row, nullptr, &one, nullptr);
  hdf5_checked(path, "cannot be written",
               [&] { return H5Dwrite(dataset.get(), type, source.get(), target.get(), H5P_DEFAULT, data); });
}

template <class Value>
void put(std::vector<char>& buffer, const TableField& field, Value value) {
  std::memcpy(buffer.data() + field.offset, &value, sizeof value);
}

void put_text(std::vector<char>& buffer, const TableField& field, std::string_view text) {
  std::fill_n(buffer.data() + field.offset, field.bytes, '\0');
  std::copy_n(text.begin(), std::min(text.size(), field.bytes), buffer.data() + field.offset);
}

template <class Value>
Value get(const char* row, const TableField& field) {
  Value value;
  std::memcpy(&value, row + field.offset, sizeof value);
  return value;
}

}  // namespace

std::vector<TableField> table_fields(const SweepPlan& plan) {
  using Kind = TableField::Kind;
  std::vector<TableField> fields;
  const auto add = [&](std::string_view name, Kind kind, std::size_t bytes) {
    const std::size_t offset = fields.empty() ? 0 : fields.back().offset + fields.back().bytes;
    fields.push_back({std::string(name), kind, bytes, offset});
  };
  add("index", Kind::whole, 8);
  for (const VariedKey& key : plan.keys) {
    if (const auto* texts = std::get_if<std::vector<std::string>>(&key.values)) {
      std::size_t longest = 1;
      for (const std::string& text : *texts) longest = std::max(longest, text.size());
      add(key.key, Kind::text, longest);
    } else {
      add(key.key, key.values.index() == 0 ? Kind::real : Kind::whole, 8);
    }
  }
  add("completed", Kind::flag, 1);
  add("error", Kind::text, longest_error);
  for (std::size_t k = 0; k < quantities; ++k) add(quantity_columns()[k].name, Kind::real, 8);
  for (const std::string& name : plan.derivatives()) add(name, Kind::real, 8);
  return fields;
}

SweepTable::SweepTable(const fs::path& file, const SweepPlan& plan, const std::string& identity)
    : path_(file),
      plan_(plan),
      fields_(table_fields(plan)),
      row_bytes_(fields_.back().offset + fields_.back().bytes),
      identity_(Checksum::of(identity)) {
  begin_hdf5();
  if (!fs::exists(path_)) create(identity);
  const std::optional<SweepFrame> frame = SweepFrame::read(path_);
  if (!frame)
    throw std::invalid_argument(
        path_.string() +
        " is of a version that made no checksums, so that its rows cannot be trusted; nothing was "
        "overwritten, choose another directory");
  file_.reset(open_file(path_).release());
  if (text_of(path_, open_dataset(path_, file_.get(), "identity")) != identity)
    throw std::invalid_argument(path_.string() +
                                " holds the rows of another sweep: the scene, its settings, the varied values or the "
                                "version differ; nothing was overwritten, choose another directory");
  build_ = text_of(path_, open_dataset(path_, file_.get(), "build"));
  for (const auto& [name, dataset] :
       {std::pair{"rows", &rows_}, {"timings", &timings_}, {"checksums", &checksums_}, {"done", &done_}})
    dataset->reset(open_dataset(path_, file_.get(), name).release());
  buffer_.resize(row_bytes_);
  row_type_.reset(compound(fields_).release());
  timing_type_.reset(compound(timing_fields()).release());
  damaged_ = check_rows(path_, *frame).damaged;
}

void SweepTable::create(const std::string& identity) const {
  NewFile file_to_be(path_);
  const fs::path& part = file_to_be.part();
  SweepFrame frame;
  {
    const Hdf5Properties properties(H5Pcreate(H5P_FILE_CREATE));
    H5Pset_userblock(properties.get(), SweepFrame::bytes);
    Hdf5File file(hdf5_checked(part, "cannot be created",
                               [&] { return H5Fcreate(part.c_str(), H5F_ACC_EXCL, properties.get(), H5P_DEFAULT); }));
    const hsize_t cases = plan_.size();
    const auto make = [&](const char* name, hid_t type, hsize_t count, const void* values = nullptr) {
      return create_dataset(part, file.get(), name, type, count, values);
    };
    frame.rows = make("rows", compound(fields_).get(), cases);
    frame.timings = make("timings", compound(timing_fields()).get(), cases);
    frame.checksums = make("checksums", H5T_STD_U64LE, cases);
    frame.done = make("done", H5T_STD_U8LE, cases);
    frame.identity = make("identity", H5T_STD_I8LE, identity.size(), identity.data());
    const std::string build = versions().build;
    make("build", H5T_STD_I8LE, build.size(), build.data());
    hdf5_checked(part, "cannot be flushed", [&] { return H5Fflush(file.get(), H5F_SCOPE_GLOBAL); });
  }
  frame.write(part);
  file_to_be.take_place();
  sync_directory(path_.parent_path());
}

std::vector<SweepRow> SweepTable::read() const {
  const std::size_t cases = plan_.size();
  std::vector<std::uint8_t> done(cases);
  std::vector<Timings> timings(cases);
  const auto all = [&](const Hdf5Dataset& dataset, hid_t type, void* out) {
    hdf5_checked(path_, "cannot be read",
                 [&] { return H5Dread(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, out); });
  };
  all(done_, H5T_STD_U8LE, done.data());
  all(timings_, timing_type_.get(), timings.data());
  std::vector<SweepRow> rows;
  if (std::none_of(done.begin(), done.end(), [](std::uint8_t one) { return one == 1; })) return rows;
  std::vector<char> bytes(cases * row_bytes_);
  all(rows_, row_type_.get(), bytes.data());
  const std::size_t completed = 1 + plan_.keys.size();
  for (std::size_t i = 0; i < cases; ++i) {
    if (done[i] != 1 || std::ranges::binary_search(damaged_, i)) continue;
    const char* from = bytes.data() + i * row_bytes_;
    SweepRow row;
    row.index = i;
    row.completed = get<std::uint8_t>(from, fields_[completed]) != 0;
    const char* error = from + fields_[completed + 1].offset;
    row.error.assign(error, strnlen(error, longest_error));
    for (std::size_t k = 0; k < quantities; ++k) row.values[k] = get<double>(from, fields_[completed + 2 + k]);
    for (std::size_t k = completed + 2 + quantities; k < fields_.size(); ++k)
      row.derivatives.push_back(get<double>(from, fields_[k]));
    row.seconds = timings[i].seconds;
    row.integration_seconds = timings[i].integration_seconds;
    rows.push_back(std::move(row));
  }
  return rows;
}

void SweepTable::write(const SweepRow& row) {
  auto field = fields_.begin();
  put(buffer_, *field++, static_cast<std::int64_t>(row.index));
  const std::vector<std::size_t> chosen = plan_.choice(row.index);
  for (std::size_t k = 0; k < plan_.keys.size(); ++k, ++field) {
    const VariedKey::Values& values = plan_.keys[k].values;
    if (const auto* reals = std::get_if<0>(&values)) put(buffer_, *field, (*reals)[chosen[k]]);
    if (const auto* wholes = std::get_if<1>(&values)) put(buffer_, *field, (*wholes)[chosen[k]]);
    if (const auto* texts = std::get_if<2>(&values)) put_text(buffer_, *field, (*texts)[chosen[k]]);
  }
  put(buffer_, *field++, static_cast<std::uint8_t>(row.completed));
  put_text(buffer_, *field++, row.error);
  for (std::size_t k = 0; field != fields_.end(); ++k) put(buffer_, *field++, row.column(k));

  const Timings timings{row.seconds, row.integration_seconds};
  const std::uint64_t sum = row_checksum(identity_, {buffer_.data(), buffer_.size()},
                                         {reinterpret_cast<const char*>(&timings), sizeof timings});
  write_row(path_, rows_, row_type_.get(), row.index, buffer_.data());
  write_row(path_, timings_, timing_type_.get(), row.index, &timings);
  write_row(path_, checksums_, H5T_STD_U64LE, row.index, &sum);
  unmarked_.push_back(row.index);
}

void SweepTable::sync() const { OutputFile(path_, OutputFile::Content::keep).sync(); }

void SweepTable::commit() {
  if (unmarked_.empty()) return;
  sync();
  const std::uint8_t done = 1;
  for (const std::size_t index : unmarked_) write_row(path_, done_, H5T_STD_U8LE, index, &done);
  unmarked_.clear();
}

void SweepTable::close() {
  commit();
  for (Hdf5Dataset* dataset : {&rows_, &timings_, &checksums_, &done_})
    hdf5_checked(path_, "cannot be closed", [&] { return H5Dclose(dataset->release()); });
  row_type_.reset();
  timing_type_.reset();
  hdf5_checked(path_, "cannot be closed", [&] { return H5Fclose(file_.release()); });
  sync();
}

}  // namespace viscobar
