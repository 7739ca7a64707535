#include "sweep/sweep_table.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "results/output_file.hpp"
#include "results/sweep_frame.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

std::vector<TableField> timing_fields() {
  return {{"seconds", H5T_IEEE_F64LE, sizeof(double)}, {"integration_seconds", H5T_IEEE_F64LE, sizeof(double)}};
}

std::vector<TableField> row_fields(const SweepPlan& plan) {
  const TableField real{"", H5T_IEEE_F64LE, 8}, whole{"", H5T_STD_I64LE, 8}, flag{"", H5T_STD_U8LE, 1};
  std::vector<TableField> fields;
  const auto add = [&](std::string_view name, TableField field) {
    field.name = name;
    fields.push_back(std::move(field));
  };
  add("index", whole);
  for (const VariedKey& key : plan.keys) {
    TableField text{"", H5T_C_S1, 1};
    if (const auto* texts = std::get_if<std::vector<std::string>>(&key.values))
      for (const std::string& one : *texts) text.bytes = std::max(text.bytes, one.size());
    add(key.key, std::array{real, whole, text}[key.values.index()]);
  }
  add("completed", flag);
  add("error", {"", H5T_C_S1, longest_error});
  for (const QuantityColumn& column : plan.columns()) add(column.name, real);
  return fields;
}

std::size_t bytes_of(std::span<const TableField> fields) {
  return std::accumulate(fields.begin(), fields.end(), std::size_t{0},
                         [](std::size_t sum, const TableField& field) { return sum + field.bytes; });
}

Hdf5Type compound(std::span<const TableField> fields) {
  Hdf5Type type(H5Tcreate(H5T_COMPOUND, bytes_of(fields)));
  std::size_t offset = 0;
  for (const TableField& field : fields) {
    const Hdf5Type own(H5Tcopy(field.type));
    if (field.type == H5T_C_S1) {
      H5Tset_size(own.get(), field.bytes);
      H5Tset_cset(own.get(), H5T_CSET_UTF8);
      H5Tset_strpad(own.get(), H5T_STR_NULLPAD);
    }
    H5Tinsert(type.get(), field.name.c_str(), std::exchange(offset, offset + field.bytes), own.get());
  }
  return type;
}

// At its full size from the beginning, in one piece, filled with zeros by the file system.
SweepFrame::Part create_dataset(const fs::path& path, const Hdf5File& file, const char* name, hid_t type, hsize_t rows,
                                const void* values = nullptr) {
  const Hdf5Properties properties(H5Pcreate(H5P_DATASET_CREATE));
  H5Pset_layout(properties.get(), H5D_CONTIGUOUS);
  H5Pset_alloc_time(properties.get(), H5D_ALLOC_TIME_EARLY);
  H5Pset_fill_time(properties.get(), H5D_FILL_TIME_NEVER);
  Hdf5Dataset dataset = new_dataset(path, file, name, type, {&rows, 1}, properties.get());
  if (values)
    hdf5_checked(path, "cannot be written",
                 [&] { return H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values); });
  const SweepFrame::Part part{H5Dget_offset(dataset.get()), H5Dget_storage_size(dataset.get())};
  // Values that HDF5 has put off are written here: a handle that ends could not tell that they were not.
  hdf5_checked(path, "cannot be written", [&] { return H5Dclose(dataset.release()); });
  return part;
}

Hdf5Dataset open_dataset(const fs::path& path, const Hdf5File& file, const char* name) {
  return hdf5_dataset(path, file, name, "is not the table of a sweep");
}

std::string text_in(const fs::path& path, const Hdf5Dataset& dataset) {
  const Hdf5Dataspace space(H5Dget_space(dataset.get()));
  std::string text(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get())), '\0');
  read_values(path, dataset, H5T_NATIVE_CHAR, text.data());
  return text;
}

// Those with the given indices, from `data` one behind the other.
void write_rows(const fs::path& path, const Hdf5Dataset& dataset, hid_t type, std::span<const hsize_t> rows,
                const void* data) {
  const hsize_t count = rows.size();
  const Hdf5Dataspace target(H5Dget_space(dataset.get())), source(H5Screate_simple(1, &count, nullptr));
  H5Sselect_elements(target.get(), H5S_SELECT_SET, rows.size(), rows.data());
  hdf5_checked(path, "cannot be written",
               [&] { return H5Dwrite(dataset.get(), type, source.get(), target.get(), H5P_DEFAULT, data); });
}

std::string_view in_memory(const std::string& text) { return text; }
std::string_view in_memory(const auto& value) { return {reinterpret_cast<const char*>(&value), sizeof value}; }

}  // namespace

SweepTable::SweepTable(const fs::path& file, const SweepPlan& plan, const std::string& identity, Access access)
    : path_(file), plan_(plan), identity_(Checksum::of(identity)) {
  begin_hdf5();
  fields_ = row_fields(plan);
  if (access == Access::write && !fs::exists(path_)) create(identity);
  const std::optional<SweepFrame> frame = SweepFrame::read(path_);
  if (!frame)
    throw std::invalid_argument(
        path_.string() +
        " is of a version that made no checksums, so that its rows cannot be trusted; nothing was "
        "overwritten, choose another directory");
  // Rows go to the file at once: nothing is collected on the way.
  const Hdf5Properties at_once(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_sieve_buf_size(at_once.get(), 0);
  file_ = hdf5_file(path_, access == Access::write ? H5F_ACC_RDWR : H5F_ACC_RDONLY, at_once.get());
  if (text_in(path_, open_dataset(path_, file_, "identity")) != identity)
    throw std::invalid_argument(path_.string() +
                                " holds the rows of another sweep: the scene, its settings, the varied values or the "
                                "version differ; nothing was overwritten, choose another directory");
  build_ = text_in(path_, open_dataset(path_, file_, "build"));
  for (const auto& [name, dataset] :
       {std::pair{"rows", &rows_}, {"timings", &timings_}, {"checksums", &checksums_}, {"done", &done_}})
    *dataset = open_dataset(path_, file_, name);
  row_type_ = compound(fields_);
  timing_type_ = compound(timing_fields());
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
      return create_dataset(part, file, name, type, count, values);
    };
    frame.rows = make("rows", compound(fields_).get(), cases);
    frame.timings = make("timings", compound(timing_fields()).get(), cases);
    frame.checksums = make("checksums", H5T_STD_U64LE, cases);
    frame.done = make("done", H5T_STD_U8LE, cases);
    frame.identity = make("identity", H5T_STD_I8LE, identity.size(), identity.data());
    const std::string build = versions().build;
    make("build", H5T_STD_I8LE, build.size(), build.data());
    hdf5_checked(part, "cannot be flushed", [&] { return H5Fflush(file.get(), H5F_SCOPE_GLOBAL); });
    hdf5_checked(part, "cannot be closed", [&] { return H5Fclose(file.release()); });
  }
  frame.write(part);
  file_to_be.take_place();
  sync_directory(path_.parent_path());
}

std::vector<SweepRow> SweepTable::read() const {
  const std::size_t cases = plan_.size();
  std::vector<std::uint8_t> done(cases);
  std::vector<Timings> timings(cases);
  read_values(path_, done_, H5T_STD_U8LE, done.data());
  read_values(path_, timings_, timing_type_.get(), timings.data());
  std::vector<SweepRow> rows;
  if (std::ranges::count(done, 1) == 0) return rows;
  const std::size_t row_bytes = bytes_of(fields_), before = bytes_of(std::span(fields_).first(1 + plan_.keys.size()));
  std::vector<char> bytes(cases * row_bytes);
  read_values(path_, rows_, row_type_.get(), bytes.data());
  for (std::size_t i = 0; i < cases; ++i) {
    if (done[i] != 1 || std::ranges::binary_search(damaged_, i)) continue;
    const char* from = bytes.data() + i * row_bytes + before;
    const auto get = [&from](auto& value) {
      std::memcpy(&value, std::exchange(from, from + sizeof value), sizeof value);
    };
    SweepRow row;
    row.index = i;
    std::uint8_t completed = 0;
    get(completed);
    row.completed = completed != 0;
    row.error.assign(from, strnlen(from, longest_error));
    from += longest_error;
    row.values.resize(fields_.size() - plan_.keys.size() - 3);
    for (double& value : row.values) get(value);
    row.seconds = timings[i].seconds;
    row.integration_seconds = timings[i].integration_seconds;
    rows.push_back(std::move(row));
  }
  return rows;
}

void SweepTable::write(const SweepRow& row) {
  std::string& bytes = pending_.rows;
  const std::size_t first = bytes.size();
  auto field = fields_.begin();
  const auto put = [&](std::string_view value) {  // a text is cut off, or filled up
    const std::size_t begin = bytes.size();
    bytes += value.substr(0, field->bytes);
    bytes.resize(begin + (field++)->bytes);
  };
  put(in_memory(static_cast<std::int64_t>(row.index)));
  const std::vector<std::size_t> chosen = plan_.choice(row.index);
  for (std::size_t k = 0; k < chosen.size(); ++k)
    std::visit([&](const auto& list) { put(in_memory(list[chosen[k]])); }, plan_.keys[k].values);
  put(in_memory(static_cast<std::uint8_t>(row.completed)));
  put(row.error);
  for (std::size_t k = 0; field != fields_.end(); ++k) put(in_memory(row.column(k)));

  const Timings timings{row.seconds, row.integration_seconds};
  pending_.checksums.push_back(row_checksum(identity_, std::string_view(bytes).substr(first), in_memory(timings)));
  pending_.timings.push_back(timings);
  pending_.indices.push_back(row.index);
}

void SweepTable::sync() const { OutputFile(path_, OutputFile::Content::keep).sync(); }

void SweepTable::commit() {
  const std::span<const hsize_t> indices(pending_.indices);
  if (indices.empty()) return;
  write_rows(path_, rows_, row_type_.get(), indices, pending_.rows.data());
  write_rows(path_, timings_, timing_type_.get(), indices, pending_.timings.data());
  write_rows(path_, checksums_, H5T_STD_U64LE, indices, pending_.checksums.data());
  sync();
  write_rows(path_, done_, H5T_STD_U8LE, indices, std::vector<std::uint8_t>(indices.size(), 1).data());
  pending_ = {};
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
