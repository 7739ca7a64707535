#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <iterator>
#include <optional>
#include <string>

#include "run/stopwatch.hpp"
#include "text/checksum.hpp"

namespace viscobar {

/// True once at least a second has passed since the last time it was: what is written then bounds what a killed run
/// loses.
class FlushClock {
 public:
  bool due() {
    if (last_.seconds() < 1.0) return false;
    last_ = WallClock();
    return true;
  }

 private:
  WallClock last_;
};

/// The name of a new file until it is fit to be seen: the one it will have, with ".part". What has that one so far is
/// left as it is until then, be it a file, or a link to another one.
class NewFile {
 public:
  /// Removes what a killed run left under the name; nothing is created. @throws IoError
  explicit NewFile(std::filesystem::path path);
  ~NewFile();
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  const std::filesystem::path& part() const { return part_; }
  void take_place();

 private:
  std::filesystem::path path_, part_;
  bool placed_ = false;
};

class FileIdentity {
 public:
  explicit FileIdentity(int descriptor);
  explicit FileIdentity(const std::filesystem::path& path);
  bool operator==(const FileIdentity&) const = default;

 private:
  unsigned long device_ = 0, node_ = 0;  // of no file
};

/// @throws IoError when the name is no longer that file's: somebody has removed or replaced it
void check_in_place(const std::filesystem::path& path, const FileIdentity& file);

/// A file whose write errors are noticed where they happen. A new one takes its place when it is closed, or before by
/// take_place(). @throws IoError
class OutputFile {
 public:
  enum class Content { discard, keep };
  explicit OutputFile(std::filesystem::path path, Content content = Content::discard);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// From now on it is seen as it grows.
  void take_place();

  void write_at(std::size_t offset, std::string_view text);
  void cut_at(std::size_t length);
  /// Returns when the content is on the disk.
  void sync();
  /// @throws IoError when it took its place and has been removed or replaced since
  void check_in_place() const;
  void close();

 private:
  std::filesystem::path path_;
  std::optional<NewFile> new_;  // while it is not in its place
  int descriptor_;
};

/// Text that grows line by line, written in blocks that end with a line.
class LineFile {
 public:
  explicit LineFile(std::filesystem::path path) : file_(std::move(path)) {}
  /// One that is there, cut off behind the bytes of `keep`, to grow on.
  LineFile(std::filesystem::path path, const Checksum& keep)
      : file_(std::move(path), OutputFile::Content::keep), written_(keep) {
    file_.cut_at(keep.bytes);
  }

  template <class... Args>
  void print(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(block_), format, std::forward<Args>(args)...);
    block_ += '\n';
    if (block_.size() >= block_size || clock_.due()) flush();
  }
  void take_place() { file_.take_place(); }
  void flush();
  /// Brings all lines to the disk and returns their checksum.
  Checksum mark() {
    flush();
    file_.sync();
    return written_;
  }
  void close();
  const Checksum& checksum() const { return written_; }

 private:
  static constexpr std::size_t block_size = 1 << 16;
  OutputFile file_;
  Checksum written_;
  std::string block_;
  FlushClock clock_;
};

/// True if a call of HDF5 has failed: at the end of the program the library tries once more to write what it could not,
/// and crashes. Such a program ends by std::_Exit().
bool hdf5_failed();

/// Does nothing where there is none. @throws IoError
void remove_file(const std::filesystem::path& file);

/// Nothing that is no file of ours to replace may have the name. @throws IoError
void check_replaceable(const std::filesystem::path& path);

/// Gives a file or folder another name; a file of that name is replaced. @throws IoError
void move_file(const std::filesystem::path& from, const std::filesystem::path& to);

/// Returns when the content of a file is on the disk. @throws IoError
void sync_file(const std::filesystem::path& file);

/// Returns when the names in a directory are on the disk.
void sync_directory(const std::filesystem::path& directory);

/// With those above it. @throws IoError
void make_directories(const std::filesystem::path& directory);

std::string file_content(const std::filesystem::path& file);

/// Checksum of `length` bytes of a file from `begin` on, or of as many as there are. @throws IoError when it cannot be
/// read
Checksum checksum_of_file(const std::filesystem::path& file, std::uint64_t begin = 0, std::uint64_t length = ~0ull);

/// Writes a whole file so that a reader sees the old content or the new, never a part; `durable`, also after a power
/// cut.
void write_atomically(const std::filesystem::path& path, std::string_view text, bool durable = false);

}  // namespace viscobar
