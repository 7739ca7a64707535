#include "io/output_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "viscobar/io/io_error.hpp"

namespace viscobar {

namespace {

std::string last_error() { return std::generic_category().message(errno); }

}  // namespace

OutputFile::OutputFile(std::filesystem::path path, Content content)
    : path_(std::move(path)),
      descriptor_(
          ::open(path_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | (content == Content::discard ? O_TRUNC : 0), 0666)) {
  if (descriptor_ < 0) throw IoError(path_, "cannot be created: " + last_error());
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void OutputFile::write_at(std::size_t offset, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::pwrite(descriptor_, text.data(), text.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw IoError(path_, "cannot be written: " + last_error());
    offset += static_cast<std::size_t>(count);
    text.remove_prefix(static_cast<std::size_t>(count));
  }
}

void OutputFile::cut_at(std::size_t length) {
  if (::ftruncate(descriptor_, static_cast<off_t>(length)) != 0)
    throw IoError(path_, "cannot be cut off: " + last_error());
}

void OutputFile::sync() {
  // What cannot be synced, as a pipe or a device, cannot lose anything either.
  if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != EROFS)
    throw IoError(path_, "cannot be brought to the disk: " + last_error());
}

void OutputFile::close() {
  // Network file systems report a full disk here at the earliest.
  if (descriptor_ >= 0 && ::close(std::exchange(descriptor_, -1)) != 0)
    throw IoError(path_, "cannot be closed: " + last_error());
}

void LineFile::flush() {
  file_.write_at(written_.bytes, block_);
  written_.add(block_);
  block_.clear();
}

void LineFile::close() {
  flush();
  file_.close();
}

void sync_directory(const std::filesystem::path& directory) {
  const int descriptor = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) throw IoError(directory, "cannot be opened: " + last_error());
  const bool synced = ::fsync(descriptor) == 0 || errno == EINVAL;
  const std::string error = last_error();
  ::close(descriptor);
  if (!synced) throw IoError(directory, "cannot be brought to the disk: " + error);
}

void write_atomically(const std::filesystem::path& path, std::string_view text) {
  std::filesystem::path temporary = path;
  temporary += ".part";
  try {
    OutputFile file(temporary);
    file.write_at(0, text);
    file.close();
    std::filesystem::rename(temporary, path);
  } catch (const std::exception& error) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    if (const auto* failed = dynamic_cast<const std::filesystem::filesystem_error*>(&error))
      throw IoError(path, "cannot be replaced: " + failed->code().message());
    throw;
  }
}

}  // namespace viscobar
