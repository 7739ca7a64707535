#include "results/sweep_frame.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <string>

#include "results/checkpoint_file.hpp"
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
    const char mark = marks.next().front();
    if (mark == 1) ++states.done;
    if (mark == 0) continue;  // a row without one is of a sweep that was killed
    if (mark != 1 || index != i || sum != row_checksum(identity, row, timing)) states.damaged.push_back(i);
  }
  return states;
}

}  // namespace viscobar
