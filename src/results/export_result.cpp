#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <system_error>

#include "results/directory_lock.hpp"
#include "results/field/field_reader.hpp"
#include "results/field/xdmf_file.hpp"
#include "results/file_set.hpp"
#include "results/output_file.hpp"
#include "results/result_directory.hpp"
#include "results/result_info.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;
using Quantity = FieldReader::Quantity;
using Asked = std::function<bool()>;

void look_at(const Asked& stop) {
  if (stop && stop()) throw ExportStopped();
}

/// Calls `take` with the rows of a field in blocks of about 1 MiB.
template <class Take>
void for_each_block(const FieldReader& field, Quantity quantity, const Asked& stop, Take&& take) {
  const std::size_t width = field.width(quantity), most = std::max<std::size_t>(1, (1 << 17) / width);
  std::vector<double> block;
  for (std::size_t row = 0; row < field.rows(); row += most) {
    look_at(stop);
    block.resize(std::min(most, field.rows() - row) * width);
    field.read(quantity, row, block);
    take(row, std::span<const double>(block));
  }
}

void write_csv(const fs::path& path, const FieldReader& field, Quantity quantity, const Asked& stop) {
  LineFile file(path);
  const std::size_t n = field.width(quantity);
  std::vector<double> x = field.x();
  if (quantity == Quantity::stress)  // of the middle of each element
    for (std::size_t j = 0; j < n; ++j) x[j] = 0.5 * (x[j] + x[j + 1]);
  x.resize(n);
  file.print("t,{}", fmt::join(x, ","));
  for_each_block(field, quantity, stop, [&](std::size_t first, std::span<const double> block) {
    for (std::size_t row = 0; row < block.size() / n; ++row)
      file.print("{},{}", field.times()[first + row], fmt::join(block.subspan(row * n, n), ","));
  });
  file.close();
}

/// field.h5 and field.xdmf with a dataset for each time (u/0, u/1, ...): for readers that know no part of a dataset,
/// such as meshio.
void export_xdmf(const FieldReader& field, const fs::path& target, const Asked& stop) {
  const fs::path path = target / "field.h5";
  Hdf5File file(hdf5_checked(path, "cannot be created",
                             [&] { return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT); }));
  const std::size_t n = field.nodes();
  write_dataset(path, file, "points", std::array<hsize_t, 2>{n, 3}, xdmf::points(field.x()));
  write_dataset(path, file, "line", std::array<hsize_t, 2>{n - 1, 2}, xdmf::line(n));

  std::string text(xdmf::head);
  std::vector<double> row;
  for (std::size_t k = 0; k < field.rows(); ++k) {
    look_at(stop);
    xdmf::add_grid_head(text, k, field.times()[k], n);
    for (const Quantity quantity : FieldReader::quantities) {
      if (!field.has(quantity)) continue;
      row.resize(field.width(quantity));
      field.read(quantity, k, row);
      const char* name = FieldReader::name(quantity);
      const std::string place = fmt::format("{}/{}", name, k);
      write_dataset(path, file, place, std::array<hsize_t, 1>{row.size()}, row);
      xdmf::add_attribute(text, name, row.size(), place);
    }
    text += "</Grid>\n";
  }
  hdf5_checked(path, "cannot be closed", [&] { return H5Fclose(file.release()); });
  write_atomically(target / "field.xdmf", text.append(xdmf::closing_tags));
}

bool begins_as(const fs::path& file, std::string_view beginning) {
  std::string begin(beginning.size(), '\0');
  std::ifstream(file, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return begin == beginning;
}

/// A file is replaced where it begins as an earlier export does. @throws std::invalid_argument
void check_target(const fs::path& target, std::string_view beginning) {
  // OutputFile refuses a name that is none of a file.
  if (fs::is_regular_file(target) && fs::file_size(target) > 0 && !begins_as(target, beginning))
    throw std::invalid_argument(fmt::format(
        "{} is not an earlier export of a result; nothing was changed, choose another place", target.string()));
}

void copy_table(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::copy_file(from, to, error);
  if (error) throw IoError(to, "cannot be written: " + error.message());
}

}  // namespace

std::vector<fs::path> export_result(const fs::path& result, ExportFormat format, const fs::path& target,
                                    const Asked& stop) {
  settle_result_directory(result);
  if (fs::exists(result / "summary.json")) check_sound(result, "exported");
  std::optional<FieldReader> field;
  if (fs::exists(result / "field.h5")) field.emplace(result / "field.h5");
  const auto is_there = [&](const std::string& table) { return fs::exists(result / (table + ".csv")); };
  if (!field && !is_there("ends") && !is_there("energy"))
    throw std::invalid_argument(
        fmt::format("{} holds no result of `viscobar run` with numbers to export (no field.h5, ends.csv or energy.csv)",
                    result.string()));
  const bool in_place = fs::exists(target) && fs::equivalent(result, target);
  if (!in_place && fs::exists(target / "summary.json"))
    throw std::invalid_argument(
        fmt::format("{} holds another result; nothing was changed, choose another directory", target.string()));
  if (format == ExportFormat::xdmf) {
    if (!field) throw std::invalid_argument(fmt::format("{} has no field.h5 to export", result.string()));
    if (in_place)
      throw std::invalid_argument(
          "an export of this format has files of the same names as the result: choose another directory");
    check_target(target / "field.h5", "\x89HDF");
    check_target(target / "field.xdmf", "<?xml");
    make_directories(target);
    const DirectoryLock lock(target);
    FileSet files(target, "export");
    export_xdmf(*field, files.folder(), stop);
    files.take_places();
    return {target / "field.h5", target / "field.xdmf"};
  }
  std::vector<fs::path> files;
  std::vector<std::function<void(const fs::path& file)>> writers;
  const auto add = [&](const std::string& name, auto&& write) {
    files.push_back(target / (name + ".csv"));
    writers.push_back(write);
  };
  for (const Quantity quantity : FieldReader::quantities)
    if (field && field->has(quantity))
      add(FieldReader::name(quantity),
          [&, quantity](const fs::path& file) { write_csv(file, *field, quantity, stop); });
  for (const std::string table : {"ends", "energy", "gauges", "joints"})
    if (is_there(table))
      add(table, [&, from = result / (table + ".csv")](const fs::path& file) {
        if (!in_place) copy_table(from, file);
      });
  for (const fs::path& file : files) check_target(file, "t,");
  make_directories(target);
  const DirectoryLock lock(target);
  FileSet set(target, "export");
  for (std::size_t k = 0; k < files.size(); ++k) look_at(stop), writers[k](set.folder() / files[k].filename());
  // Tables of an earlier export, of another result, are known by their first lines.
  for (const auto& [table, beginning] : {std::pair{"u.csv", "t,0"},
                                         {"v.csv", "t,0"},
                                         {"stress.csv", "t,0"},
                                         {"ends.csv", "t,u_left,"},
                                         {"energy.csv", "t,kinetic,"},
                                         {"gauges.csv", "t,u@"},
                                         {"joints.csv", "t,u_left:"}})
    if (!in_place && std::ranges::find(files, target / table) == files.end() && begins_as(target / table, beginning))
      set.drop(table);
  set.take_places();
  return files;
}

}  // namespace viscobar
