#include "io/checkpoint_file.hpp"

#include <fmt/format.h>

#include <boost/crc.hpp>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>

#include "dynamics/archive.hpp"
#include "io/output_file.hpp"
#include "viscobar/io/io_error.hpp"
#include "viscobar/io/versions.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view magic = "viscobar";
constexpr std::uint64_t format = 1;
constexpr std::size_t head_bytes = 3 * sizeof(std::uint64_t), checksum_bytes = sizeof(std::uint64_t);

constexpr const char *newest = "checkpoint.bin", *previous = "checkpoint.previous.bin";

std::uint64_t checksum(std::string_view bytes) {
  constexpr std::uint64_t ones = ~std::uint64_t{0};
  boost::crc_optimal<64, 0x42F0E1EBA9EA3693, ones, ones, true, true> crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

void append(std::string& bytes, std::uint64_t number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

std::uint64_t number_at(std::string_view bytes, std::size_t offset) {
  std::uint64_t number = 0;
  std::memcpy(&number, bytes.data() + offset, sizeof number);
  return number;
}

std::string content(const fs::path& file) {
  if (!fs::is_regular_file(fs::symlink_status(file))) throw ArchiveError("is no regular file");
  std::ifstream stream(file, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) throw ArchiveError("cannot be read");
  return bytes;
}

}  // namespace

std::string sealed(std::string_view content) {
  std::string bytes(magic);
  bytes.reserve(head_bytes + content.size() + checksum_bytes);
  append(bytes, format);
  append(bytes, content.size());
  bytes += content;
  append(bytes, checksum(bytes));
  return bytes;
}

std::string encoded(const RunCheckpoint& checkpoint) {
  ArchiveWriter archive;
  archive(versions().viscobar, checkpoint);
  return sealed(archive.take());
}

RunCheckpoint decoded(std::string_view bytes) {
  if (bytes.size() < head_bytes + checksum_bytes) throw ArchiveError("is truncated");
  if (!bytes.starts_with(magic)) throw ArchiveError("is no checkpoint of viscobar");
  const std::string_view summed = bytes.substr(0, bytes.size() - checksum_bytes);
  const std::uint64_t length = number_at(bytes, 2 * sizeof(std::uint64_t));
  if (length > summed.size() - head_bytes) throw ArchiveError("is truncated");
  if (length != summed.size() - head_bytes || checksum(summed) != number_at(bytes, summed.size()))
    throw ArchiveError("is damaged: its checksum does not fit its content");
  if (number_at(bytes, magic.size()) != format) throw ArchiveError("has a format that this version does not know");
  ArchiveReader archive(summed.substr(head_bytes));
  std::string version;
  archive(version);
  if (version != versions().viscobar)
    throw ArchiveError(fmt::format("was made by version {}, and only that version can go on with it; this is {}",
                                   version, versions().viscobar));
  RunCheckpoint checkpoint;
  archive(checkpoint);
  if (!archive.finished()) throw ArchiveError("is longer than its content");
  return checkpoint;
}

void write_checkpoint(const fs::path& directory, const RunCheckpoint& checkpoint) {
  const fs::path target = directory / newest;
  OutputFile file(target);
  file.write_at(0, encoded(checkpoint));
  file.sync();
  std::error_code error;
  if (fs::exists(target)) fs::rename(target, directory / previous, error);
  if (error) throw IoError(target, "cannot be replaced: " + error.message());
  file.close();
  sync_directory(directory);
}

FoundCheckpoint read_checkpoint(const fs::path& directory) {
  std::string complaint;
  for (const char* name : {newest, previous}) {
    const fs::path file = directory / name;
    if (!fs::exists(file)) continue;
    try {
      return {decoded(content(file)), complaint};
    } catch (const ArchiveError& error) {
      complaint += fmt::format("{}{}: {}", complaint.empty() ? "" : "\n", file.string(), error.what());
    }
  }
  if (!complaint.empty()) throw IoError(directory, "holds no sound checkpoint; nothing was changed\n" + complaint);
  throw std::invalid_argument(
      fmt::format("{} holds no checkpoint: the run there is complete, or was made without --checkpoint and not stopped "
                  "by Ctrl-C",
                  directory.string()));
}

bool has_checkpoint(const fs::path& directory) {
  return fs::exists(directory / newest) || fs::exists(directory / previous);
}

void remove_newest_checkpoint(const fs::path& directory) {
  std::error_code error;
  // What is no file, and so nobody's checkpoint, is kept out of the way.
  if (fs::is_regular_file(fs::symlink_status(directory / newest)))
    fs::remove(directory / newest, error);
  else
    fs::rename(directory / newest, directory / "checkpoint.damaged", error);
  if (error) throw IoError(directory / newest, "cannot be removed: " + error.message());
}

void remove_checkpoints(const fs::path& directory) {
  std::error_code ignored;
  for (const char* name : {newest, previous}) fs::remove(directory / name, ignored);
}

}  // namespace viscobar
