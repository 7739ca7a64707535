#include "results/checkpoint_file.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <stdexcept>
#include <system_error>

#include "results/output_file.hpp"
#include "viscobar/results/io_error.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view magic = "viscobar";
constexpr std::uint64_t format = 4;
constexpr std::size_t head_bytes = 3 * sizeof(std::uint64_t), checksum_bytes = sizeof(std::uint64_t);

constexpr const char *newest = "checkpoint.bin", *previous = "checkpoint.previous.bin";

template <class... Numbers>
std::string archived(const Numbers&... numbers) {
  ArchiveWriter archive;
  archive(numbers...);
  return archive.take();
}

std::string archive_content(const fs::path& file) {
  if (!fs::is_regular_file(fs::symlink_status(file))) throw ArchiveError("is no regular file");
  return file_content(file);
}

}  // namespace

std::string sealed(std::string_view content) {
  std::string bytes(magic);
  bytes.reserve(head_bytes + content.size() + checksum_bytes);
  bytes += archived(format, content.size());
  bytes += content;
  bytes += archived(Checksum::of(bytes).crc64);
  return bytes;
}

std::string encoded(const RunCheckpoint& checkpoint) {
  ArchiveWriter archive;
  archive(versions().viscobar, versions().build, checkpoint);
  return sealed(archive.take());
}

std::string_view unsealed(std::string_view bytes) {
  if (bytes.size() < head_bytes + checksum_bytes) throw ArchiveError("is truncated");
  if (!bytes.starts_with(magic)) throw ArchiveError("does not begin as those of viscobar do");
  const std::string_view summed = bytes.substr(0, bytes.size() - checksum_bytes);
  std::uint64_t its_format = 0, length = 0, checksum = 0;
  ArchiveReader(bytes.substr(magic.size()))(its_format, length);
  ArchiveReader(bytes.substr(summed.size()))(checksum);
  if (length > summed.size() - head_bytes) throw ArchiveError("is truncated");
  if (length != summed.size() - head_bytes || Checksum::of(summed).crc64 != checksum)
    throw ArchiveError("is damaged: its checksum does not fit its content");
  if (its_format != format) throw ArchiveError("has a format that this version does not know");
  return summed.substr(head_bytes);
}

RunCheckpoint decoded(std::string_view bytes) {
  ArchiveReader archive(unsealed(bytes));
  std::string version, build;
  archive(version, build);
  if (version != versions().viscobar)
    throw ArchiveError(fmt::format("was made by version {}, and only that version can go on with it; this is {}",
                                   version, versions().viscobar));
  if (build != versions().build)
    throw ArchiveError(
        fmt::format("was made by another build of version {} ({}), and only that build can go on with it "
                    "bit for bit; this is {}",
                    version, build, versions().build));
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

FoundCheckpoint read_checkpoint(const fs::path& directory, CheckFiles check) {
  std::string complaint;
  bool files_changed = false;
  const auto complain = [&](const fs::path& file, const std::string& what) {
    complaint += fmt::format("{}{}: {}", complaint.empty() ? "" : "\n", file.string(), what);
  };
  for (const char* name : {newest, previous}) {
    const fs::path file = directory / name;
    if (!fs::exists(file)) continue;
    try {
      RunCheckpoint checkpoint = decoded(archive_content(file));
      // To begin anew would take the place of what is still sound in files that were changed.
      if (!checkpoint.motion && files_changed) continue;
      if (check == CheckFiles::yes && checkpoint.motion) checkpoint.files.check(directory);
      return {std::move(checkpoint), complaint};
    } catch (const ArchiveError& error) {
      complain(file, error.what());
    } catch (const IoError& error) {
      files_changed = true;
      complain(file, std::string("cannot be gone on from: ") + error.what());
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
  // A name that is no file is nobody's checkpoint and left alone.
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
