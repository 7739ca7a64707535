#include "results/sweep_info.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "results/field/hdf5_handle.hpp"
#include "results/sweep_frame.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* not_a_table = "is not the table of a sweep";

// The file of a running sweep is locked; as nothing in it moves, it can be read all the same.
Hdf5File open_unlocked(const fs::path& path) {
  const Hdf5Properties access(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_file_locking(access.get(), false, true);
  return Hdf5File(
      hdf5_checked(path, "cannot be opened", [&] { return H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()); }));
}

/// A dataset of rows, of which one member after another is read.
class Rows {
 public:
  Rows(const fs::path& path, const Hdf5File& file, const char* name)
      : path_(path),
        dataset_(hdf5_checked(path, not_a_table, [&] { return H5Dopen2(file.get(), name, H5P_DEFAULT); })),
        type_(H5Dget_type(dataset_.get())) {
    const Hdf5Dataspace space(H5Dget_space(dataset_.get()));
    count_ = static_cast<std::size_t>(std::max<hssize_t>(H5Sget_simple_extent_npoints(space.get()), 0));
  }

  std::size_t count() const { return count_; }

  std::vector<std::string> members() const {
    std::vector<std::string> names;
    if (H5Tget_class(type_.get()) != H5T_COMPOUND) throw IoError(path_, not_a_table);
    for (unsigned k = 0; k < static_cast<unsigned>(H5Tget_nmembers(type_.get())); ++k) {
      const std::unique_ptr<char, decltype(&std::free)> name(H5Tget_member_name(type_.get(), k), &std::free);
      names.emplace_back(name.get());
    }
    return names;
  }

  bool is_text(const std::string& member) const { return H5Tget_class(type_of(member).get()) == H5T_STRING; }

  std::vector<double> numbers(const std::string& member) const {
    std::vector<double> values(count_);
    read(member, H5T_NATIVE_DOUBLE, sizeof(double), values.data());
    return values;
  }

  std::vector<std::string> texts(const std::string& member) const {
    const Hdf5Type type = type_of(member);
    const std::size_t bytes = H5Tget_size(type.get());
    std::vector<char> buffer(count_ * bytes);
    read(member, type.get(), bytes, buffer.data());
    std::vector<std::string> values;
    for (std::size_t i = 0; i < count_; ++i) {
      const char* from = buffer.data() + i * bytes;
      values.emplace_back(from, std::find(from, from + bytes, '\0'));
    }
    return values;
  }

  void all(hid_t type, void* out) const {
    hdf5_checked(path_, "cannot be read",
                 [&] { return H5Dread(dataset_.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, out); });
  }

 private:
  Hdf5Type type_of(const std::string& member) const {
    const int index =
        hdf5_checked(path_, not_a_table, [&] { return H5Tget_member_index(type_.get(), member.c_str()); });
    return Hdf5Type(H5Tget_member_type(type_.get(), static_cast<unsigned>(index)));
  }

  void read(const std::string& member, hid_t type, std::size_t bytes, void* out) const {
    const Hdf5Type alone(H5Tcreate(H5T_COMPOUND, bytes));
    H5Tinsert(alone.get(), member.c_str(), 0, type);
    all(alone.get(), out);
  }

  const fs::path& path_;
  Hdf5Dataset dataset_;
  Hdf5Type type_;
  std::size_t count_ = 0;
};

template <class Value>
std::vector<Value> selected(std::vector<Value> values, const std::vector<std::uint8_t>& marks) {
  std::vector<Value> kept;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (marks[i] == 1) kept.push_back(std::move(values[i]));
  return kept;
}

Json range(std::string_view name, std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });  // cases without such a value
  Json column = {{"name", name}, {"rows", values.size()}};
  if (values.empty()) return column;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  column["from"] = *least;
  column["to"] = *most;
  return column;
}

// Each text once, with its number of rows, the most frequent first.
Json counted(const std::vector<std::string>& texts) {
  std::map<std::string, std::size_t> counts;
  for (const std::string& text : texts) ++counts[text];
  std::vector<std::pair<std::string, std::size_t>> sorted(counts.begin(), counts.end());
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  Json found = Json::array();
  for (const auto& [text, count] : sorted) found.push_back({{"text", text}, {"rows", count}});
  return found;
}

}  // namespace

Json sweep_facts(const fs::path& path) {
  // HDF5 would take damage for orders.
  std::ignore = SweepFrame::read(path);
  const Hdf5File file = open_unlocked(path);
  const Rows rows(path, file, "rows"), timings(path, file, "timings"), done(path, file, "done");
  if (timings.count() != rows.count() || done.count() != rows.count()) throw IoError(path, not_a_table);
  std::vector<std::uint8_t> marks(done.count());
  done.all(H5T_NATIVE_UINT8, marks.data());

  const auto cases = rows.count(), finished = static_cast<std::size_t>(std::count(marks.begin(), marks.end(), 1));
  const std::vector<double> completed = selected(rows.numbers("completed"), marks);
  const auto failed = static_cast<std::size_t>(std::count(completed.begin(), completed.end(), 0.0));
  double seconds = 0.0;
  for (const double spent : selected(timings.numbers("seconds"), marks)) seconds += spent;
  std::vector<std::string> errors = selected(rows.texts("error"), marks);
  std::erase(errors, "");

  Json facts = {{"cases", cases},
                {"done", finished},
                {"failed", failed},
                {"remaining", cases - finished},
                {"completed", finished == cases && failed == 0},
                {"seconds_of_cases", seconds},
                {"errors", counted(errors)},
                {"columns", Json::array()}};
  for (const std::string& name : rows.members()) {
    if (name == "index" || name == "completed" || name == "error") continue;
    if (rows.is_text(name))
      facts["columns"].push_back({{"name", name}, {"values", counted(selected(rows.texts(name), marks))}});
    else
      facts["columns"].push_back(range(name, selected(rows.numbers(name), marks)));
  }
  return facts;
}

}  // namespace viscobar
