#include "results/export_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <initializer_list>
#include <stdexcept>
#include <system_error>

#include "results/field/field_reader.hpp"
#include "results/npy_file.hpp"
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
  const std::size_t most = std::max<std::size_t>(1, (1 << 17) / field.nodes());
  std::vector<double> block;
  for (std::size_t row = 0; row < field.rows(); row += most) {
    block.resize(std::min(most, field.rows() - row) * field.nodes());
    field.read(quantity, row, block);
    take(row, std::span<const double>(block));
  }
}

void write_npy(const fs::path& path, std::span<const double> values) {
  NpyFile file(path, std::array{values.size()});
  file.append(values);
  file.close();
}

void write_npy(const fs::path& path, const FieldReader& field, Quantity quantity) {
  NpyFile file(path, std::array{field.rows(), field.nodes()});
  for_each_block(field, quantity, [&](std::size_t, std::span<const double> block) { file.append(block); });
  file.close();
}

void write_csv(const fs::path& path, const FieldReader& field, Quantity quantity) {
  LineFile file(path);
  const std::size_t n = field.nodes();
  file.print("t,{}", fmt::join(field.x(), ","));
  for_each_block(field, quantity, [&](std::size_t first, std::span<const double> block) {
    for (std::size_t row = 0; row < block.size() / n; ++row)
      file.print("{},{}", field.times()[first + row], fmt::join(block.subspan(row * n, n), ","));
  });
  file.close();
}

/// The numbers of ends.csv. A last line that a killed run left half written is not one of them.
struct Columns {
  std::size_t count = 0;
  std::vector<double> values;
};

Columns read_ends(const fs::path& path) {
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

void write_npy(const fs::path& path, const Columns& columns) {
  NpyFile file(path, std::array{columns.values.size() / columns.count, columns.count});
  file.append(columns.values);
  file.close();
}

/// What is there is replaced where it begins as an earlier export does. @throws std::invalid_argument
void check_targets(const fs::path& target, std::initializer_list<const char*> names, std::string_view beginning) {
  for (const char* name : names) {
    if (!fs::is_regular_file(target / name)) continue;  // OutputFile refuses what is none
    std::string begin(beginning.size(), '\0');
    std::ifstream stream(target / name, std::ios::binary);
    stream.read(begin.data(), static_cast<std::streamsize>(begin.size()));
    if (stream.gcount() > 0 && begin != beginning)
      throw std::invalid_argument(
          fmt::format("{} is not an earlier export of a result; nothing was changed, choose another place",
                      (target / name).string()));
  }
}

}  // namespace

std::vector<fs::path> export_result(const fs::path& result, ExportFormat format, const fs::path& target) {
  settle_result_directory(result);
  for (const char* needed : {"field.h5", "ends.csv"})
    if (!fs::exists(result / needed))
      throw std::invalid_argument(fmt::format("{} holds no result of `viscobar run` (no {})", result.string(), needed));
  format == ExportFormat::npy ? check_targets(target, {"x.npy", "t.npy", "u.npy", "v.npy", "ends.npy"}, "\x93NUMPY")
                              : check_targets(target, {"u.csv", "v.csv", "ends.csv"}, "t,");
  const FieldReader field(result / "field.h5");
  std::error_code error;
  fs::create_directories(target, error);
  if (error) throw IoError(target, "cannot be created: " + error.message());
  if (format == ExportFormat::npy) {
    write_npy(target / "x.npy", field.x());
    write_npy(target / "t.npy", field.times());
    write_npy(target / "u.npy", field, Quantity::displacement);
    write_npy(target / "v.npy", field, Quantity::velocity);
    write_npy(target / "ends.npy", read_ends(result / "ends.csv"));
    return {target / "x.npy", target / "t.npy", target / "u.npy", target / "v.npy", target / "ends.npy"};
  }
  write_csv(target / "u.csv", field, Quantity::displacement);
  write_csv(target / "v.csv", field, Quantity::velocity);
  if (!fs::equivalent(result, target)) {
    NewFile copy(target / "ends.csv");
    fs::copy_file(result / "ends.csv", copy.part(), error);
    if (error) throw IoError(target / "ends.csv", "cannot be written: " + error.message());
    copy.take_place();
  }
  return {target / "u.csv", target / "v.csv", target / "ends.csv"};
}

}  // namespace viscobar
