#include "results/export_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <fstream>
#include <optional>
#include <span>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "results/field/field_reader.hpp"
#include "results/field/xdmf_file.hpp"
#include "results/output_file.hpp"
#include "results/result_directory.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;
using Quantity = FieldReader::Quantity;

/// Calls `take` with the rows of a field in blocks of about 1 MiB.
template <class Take>
void for_each_block(const FieldReader& field, Quantity quantity, Take&& take) {
  const std::size_t width = field.width(quantity), most = std::max<std::size_t>(1, (1 << 17) / width);
  std::vector<double> block;
  for (std::size_t row = 0; row < field.rows(); row += most) {
    block.resize(std::min(most, field.rows() - row) * width);
    field.read(quantity, row, block);
    take(row, std::span<const double>(block));
  }
}

/// An array of doubles in NumPy's format 1.0, row by row: 8 bytes "\x93NUMPY\1\0", the length of the header in two
/// bytes, the header, a Python dictionary padded with blanks to a multiple of 64, then the numbers, little-endian.
/// @throws IoError
class NpyFile {
 public:
  /// All extents are known beforehand; one extent makes a vector.
  NpyFile(const fs::path& path, const std::vector<std::size_t>& shape) : file_(path) {
    // A tuple of one number ends with a comma.
    std::string head =
        fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", fmt::join(shape, ", "));
    constexpr std::size_t before = 10, alignment = 64;
    head.resize((before + head.size() + 1 + alignment - 1) / alignment * alignment - before - 1, ' ');
    head += '\n';
    std::string start("\x93NUMPY\x01\x00", 8);
    start += static_cast<char>(head.size() & 0xff);
    start += static_cast<char>(head.size() >> 8);
    start += head;
    file_.write_at(0, start);
    written_ = start.size();
  }

  void append(std::span<const double> values) {
    static_assert(std::endian::native == std::endian::little, "the numbers are written as they lie in memory");
    const auto bytes = std::as_bytes(values);
    file_.write_at(written_, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    written_ += bytes.size();
  }

  void close() { file_.close(); }

 private:
  OutputFile file_;
  std::size_t written_ = 0;
};

void write_npy(const fs::path& path, std::span<const double> values, const std::vector<std::size_t>& shape) {
  NpyFile file(path, shape);
  file.append(values);
  file.close();
}

void write_npy(const fs::path& path, const FieldReader& field, Quantity quantity) {
  NpyFile file(path, {field.rows(), field.width(quantity)});
  for_each_block(field, quantity, [&](std::size_t, std::span<const double> block) { file.append(block); });
  file.close();
}

void write_csv(const fs::path& path, const FieldReader& field, Quantity quantity) {
  LineFile file(path);
  const std::size_t n = field.width(quantity);
  std::vector<double> x = field.x();
  if (quantity == Quantity::stress)  // of the middle of each element
    for (std::size_t j = 0; j < n; ++j) x[j] = 0.5 * (x[j] + x[j + 1]);
  x.resize(n);
  file.print("t,{}", fmt::join(x, ","));
  for_each_block(field, quantity, [&](std::size_t first, std::span<const double> block) {
    for (std::size_t row = 0; row < block.size() / n; ++row)
      file.print("{},{}", field.times()[first + row], fmt::join(block.subspan(row * n, n), ","));
  });
  file.close();
}

/// field.h5 and field.xdmf with a dataset for each time (u/0, u/1, ...): for readers that know no part of a dataset,
/// such as meshio.
void export_xdmf(const FieldReader& field, const fs::path& target) {
  NewFile values(target / "field.h5"), description(target / "field.xdmf");
  const fs::path& path = values.part();
  begin_hdf5();
  Hdf5File file(hdf5_checked(path, "cannot be created",
                             [&] { return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT); }));
  const Hdf5Properties groups(H5Pcreate(H5P_LINK_CREATE));
  H5Pset_create_intermediate_group(groups.get(), 1);
  const std::size_t n = field.nodes();
  write_dataset(path, file.get(), "points", std::array<hsize_t, 2>{n, 3}, xdmf::points(field.x()));
  write_dataset(path, file.get(), "line", std::array<hsize_t, 2>{n - 1, 2}, xdmf::line(n));

  std::string text(xdmf::head);
  std::vector<double> row;
  for (std::size_t k = 0; k < field.rows(); ++k) {
    text += xdmf::grid_head(k, field.times()[k], n);
    for (const auto& [name, quantity] :
         {std::pair("u", Quantity::displacement), {"v", Quantity::velocity}, {"stress", Quantity::stress}}) {
      if (!field.has(quantity)) continue;
      row.resize(field.width(quantity));
      field.read(quantity, k, row);
      const std::string place = fmt::format("{}/{}", name, k);
      write_dataset(path, file.get(), place, std::array<hsize_t, 1>{row.size()}, row, groups.get());
      text += xdmf::attribute(name, row.size(), place);
    }
    text += "</Grid>\n";
  }
  hdf5_checked(path, "cannot be closed", [&] { return H5Fclose(file.release()); });
  values.take_place();
  OutputFile out(description.part());
  out.write_at(0, text.append(xdmf::closing_tags));
  out.close();
  description.take_place();
}

/// The numbers of a table such as ends.csv. A last line that a killed run left half written is not one of them.
struct Columns {
  std::size_t count = 0;
  std::vector<double> values;
};

Columns read_table(const fs::path& path) {
  std::ifstream stream(path);
  if (!stream) throw IoError(path, "cannot be read");
  Columns columns;
  std::string line;
  std::getline(stream, line);
  columns.count = 1 + static_cast<std::size_t>(std::count(line.begin(), line.end(), ','));
  while (std::getline(stream, line)) {
    std::vector<double> row;
    const char *at = line.data(), *end = at + line.size();
    for (double value = 0.0; at <= end; ++at) {
      const auto [next, error] = std::from_chars(at, end, value);
      if (error != std::errc()) break;
      row.push_back(value);
      at = next;
    }
    if (row.size() == columns.count && !stream.eof())
      columns.values.insert(columns.values.end(), row.begin(), row.end());
    else if (!stream.eof())
      throw IoError(path, fmt::format("has a line that is not {} numbers: {}", columns.count, line));
  }
  return columns;
}

/// What is there is replaced where it begins as an earlier export does. @throws std::invalid_argument
void check_targets(const std::vector<fs::path>& targets, std::string_view beginning) {
  for (const fs::path& target : targets) {
    if (!fs::is_regular_file(target)) continue;  // OutputFile refuses what is none
    std::string begin(beginning.size(), '\0');
    std::ifstream stream(target, std::ios::binary);
    stream.read(begin.data(), static_cast<std::streamsize>(begin.size()));
    if (stream.gcount() > 0 && begin != beginning)
      throw std::invalid_argument(fmt::format(
          "{} is not an earlier export of a result; nothing was changed, choose another place", target.string()));
  }
}

void create(const fs::path& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) throw IoError(directory, "cannot be created: " + error.message());
}

void copy_table(const fs::path& from, const fs::path& to) {
  NewFile copy(to);
  std::error_code error;
  fs::copy_file(from, copy.part(), error);
  if (error) throw IoError(to, "cannot be written: " + error.message());
  copy.take_place();
}

}  // namespace

std::vector<fs::path> export_result(const fs::path& result, ExportFormat format, const fs::path& target) {
  settle_result_directory(result);
  const bool npy = format == ExportFormat::npy;
  std::vector<std::string> tables;
  for (const char* table : {"ends", "energy"})
    if (fs::exists(result / fmt::format("{}.csv", table))) tables.push_back(table);
  std::optional<FieldReader> field;
  if (fs::exists(result / "field.h5")) field.emplace(result / "field.h5");
  if (!field && tables.empty())
    throw std::invalid_argument(
        fmt::format("{} holds no result of `viscobar run` with numbers to export (no field.h5, ends.csv or energy.csv)",
                    result.string()));
  std::vector<std::pair<std::string, Quantity>> fields;
  for (const auto& [name, quantity] :
       {std::pair("u", Quantity::displacement), {"v", Quantity::velocity}, {"stress", Quantity::stress}})
    if (field && field->has(quantity)) fields.emplace_back(name, quantity);

  if (format == ExportFormat::xdmf) {
    if (!field) throw std::invalid_argument(fmt::format("{} has no field.h5 to export", result.string()));
    if (fs::exists(target) && fs::equivalent(result, target))
      throw std::invalid_argument(
          "an export of this format has files of the same names as the result: choose another directory");
    const std::vector<fs::path> files = {target / "field.h5", target / "field.xdmf"};
    check_targets({files[0]}, "\x89HDF");
    check_targets({files[1]}, "<?xml");
    create(target);
    export_xdmf(*field, target);
    return files;
  }
  std::vector<fs::path> targets;
  const auto path_of = [&](const std::string& name) { return target / (name + (npy ? ".npy" : ".csv")); };
  if (field && npy) targets = {path_of("x"), path_of("t")};
  for (const auto& [name, quantity] : fields) targets.push_back(path_of(name));
  for (const std::string& table : tables) targets.push_back(path_of(table));
  check_targets(targets, npy ? "\x93NUMPY" : "t,");
  create(target);
  if (field && npy) {
    write_npy(path_of("x"), field->x(), {field->nodes()});
    write_npy(path_of("t"), field->times(), {field->rows()});
  }
  for (const auto& [name, quantity] : fields)
    npy ? write_npy(path_of(name), *field, quantity) : write_csv(path_of(name), *field, quantity);
  for (const std::string& table : tables) {
    const fs::path from = result / (table + ".csv");
    if (npy) {
      const Columns columns = read_table(from);
      write_npy(path_of(table), columns.values, {columns.values.size() / columns.count, columns.count});
    } else if (!fs::equivalent(result, target)) {
      copy_table(from, path_of(table));
    }
  }
  return targets;
}

}  // namespace viscobar
