#include "results/sweep_frame.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>

#include "results/checkpoint_file.hpp"
#include "results/field/hdf5_handle.hpp"
#include "results/json.hpp"
#include "results/output_file.hpp"
#include "run/archive.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

std::string bytes_at(const fs::path& file, std::uint64_t begin, std::uint64_t length) {
  std::string bytes(length, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(begin));
  stream.read(bytes.data(), static_cast<std::streamsize>(length));
  if (!stream) throw IoError(file, "is cut off");
  return bytes;
}

/// Values of a part, one case after another, read in blocks.
class CaseReader {
 public:
  CaseReader(const fs::path& file, const SweepFrame::Part& part, std::size_t cases)
      : file_(file), part_(part), each_(part.length / cases) {}

  /// Fields of the next case.
  std::string_view next() {
    if (at_ == block_.size()) {
      const std::uint64_t most = std::max<std::uint64_t>(1, (1 << 20) / each_) * each_;
      block_ = bytes_at(file_, part_.begin + read_, std::min(most, part_.length - read_));
      read_ += block_.size();
      at_ = 0;
    }
    return std::string_view(block_).substr((at_ += each_) - each_, each_);
  }

 private:
  const fs::path& file_;
  SweepFrame::Part part_;
  std::size_t each_, at_ = 0;
  std::uint64_t read_ = 0;
  std::string block_;
};

// In the superblock HDF5 says with one bit whether the file is open for writing: that of a sweep that is running, or
// was killed.
constexpr std::uint64_t flags = SweepFrame::bytes + 20, flag_bytes = 4;

Checksum rest_of(const fs::path& file, const SweepFrame& frame) {
  std::array parts = {frame.rows, frame.timings, frame.checksums, frame.done};
  std::ranges::sort(parts, {}, &SweepFrame::Part::begin);
  Checksum rest = checksum_of_file(file, SweepFrame::bytes, flags - SweepFrame::bytes);
  const std::string open = bytes_at(file, flags, flag_bytes);
  rest.add(open == std::string_view("\1\0\0\0", flag_bytes) ? std::string(flag_bytes, '\0') : open);
  std::uint64_t at = flags + flag_bytes;
  for (const SweepFrame::Part& part : parts) {
    if (part.begin < at) throw IoError(file, "is damaged: its parts overlap");
    rest.append(checksum_of_file(file, at, part.begin - at));
    at = part.begin + part.length;
  }
  rest.append(checksum_of_file(file, at));
  return rest;
}

constexpr const char* not_a_table = "is not the table of a sweep";

// The file of a running sweep is locked; as nothing in it moves, it can be read all the same.
Hdf5File open_unlocked(const fs::path& path) {
  const Hdf5Properties access(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_file_locking(access.get(), false, true);
  return hdf5_file(path, H5F_ACC_RDONLY, access.get());
}

/// A dataset of rows, of which one member after another is read.
class Rows {
 public:
  Rows(const fs::path& path, const Hdf5File& file, const char* name)
      : path_(path), dataset_(hdf5_dataset(path, file, name, not_a_table)), type_(H5Dget_type(dataset_.get())) {
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

  void all(hid_t type, void* out) const { read_values(path_, dataset_, type, out); }

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

void SweepFrame::write(const fs::path& file) {
  rest = rest_of(file, *this);
  ArchiveWriter archive;
  archive(*this);
  std::string text = sealed(archive.take());
  text.resize(bytes);
  OutputFile raw(file, OutputFile::Content::keep);
  raw.write_at(0, text);
  raw.sync();
  raw.close();
}

std::optional<SweepFrame> SweepFrame::read(const fs::path& file) {
  constexpr std::string_view plain_hdf5 = "\x89HDF\r\n\x1a\n";
  const std::string text = bytes_at(file, 0, bytes);
  if (text.starts_with(plain_hdf5)) return std::nullopt;
  SweepFrame frame;
  try {
    const std::string expected = [] {
      ArchiveWriter archive;
      archive(SweepFrame{});
      return sealed(archive.take());
    }();
    if (text.find_first_not_of('\0', expected.size()) != text.npos) throw ArchiveError("is damaged");
    const std::string_view content = unsealed(std::string_view(text).substr(0, expected.size()));
    ArchiveReader archive(content);
    archive(frame);
  } catch (const ArchiveError& error) {
    throw IoError(file, std::string("is no table of a sweep that can be read: its head ") + error.what());
  }
  if (rest_of(file, frame) != frame.rest)
    throw IoError(file, "is damaged: what stands beside the rows is not what was written");
  return frame;
}

std::uint64_t row_checksum(const Checksum& identity, std::string_view row, std::string_view timings) {
  Checksum sum = identity;
  sum.add(row);
  sum.add(timings);
  return sum.crc64;
}

SweepRowStates check_rows(const fs::path& file, const SweepFrame& frame) {
  const Checksum identity = checksum_of_file(file, frame.identity.begin, frame.identity.length);
  const std::size_t cases = frame.cases();
  CaseReader rows(file, frame.rows, cases), timings(file, frame.timings, cases), sums(file, frame.checksums, cases),
      marks(file, frame.done, cases);
  SweepRowStates states;
  for (std::size_t i = 0; i < cases; ++i) {
    const std::string_view row = rows.next(), timing = timings.next();
    std::uint64_t sum = 0, index = 0;
    std::memcpy(&sum, sums.next().data(), sizeof sum);
    std::memcpy(&index, row.data(), sizeof index);
    const bool sound = index == i && sum == row_checksum(identity, row, timing);
    const char mark = marks.next().front();
    if (mark == 1) ++states.done;
    if (mark == 0 ? false : mark != 1 || !sound) states.damaged.push_back(i);
    if (mark == 0 && sound) ++states.unmarked;
  }
  return states;
}

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
