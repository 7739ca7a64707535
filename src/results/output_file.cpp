#include "results/output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

std::string last_error() { return std::generic_category().message(errno); }

}  // namespace

NewFile::NewFile(std::filesystem::path path) : path_(std::move(path)), part_(path_) {
  part_ += ".part";
  check_replaceable(path_);
  remove_file(part_);
}

NewFile::~NewFile() {
  if (!placed_) ::unlink(part_.c_str());
}

void NewFile::take_place() {
  move_file(part_, path_);
  placed_ = true;
}

FileIdentity::FileIdentity(int descriptor) {
  struct stat status {};
  if (::fstat(descriptor, &status) == 0) device_ = status.st_dev, node_ = status.st_ino;
}

FileIdentity::FileIdentity(const std::filesystem::path& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) == 0) device_ = status.st_dev, node_ = status.st_ino;
}

void check_in_place(const std::filesystem::path& path, const FileIdentity& file) {
  if (FileIdentity(path) != file) throw IoError(path, "was removed or replaced while it was written");
}

OutputFile::OutputFile(std::filesystem::path path, Content content) : path_(std::move(path)) {
  if (content == Content::discard) {
    new_.emplace(path_);
    descriptor_ = ::open(new_->part().c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) throw IoError(path_, "cannot be created: " + last_error());
  } else {
    // A pipe that nobody reads gives an error at once.
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (descriptor_ < 0) throw IoError(path_, "cannot be opened: " + last_error());
  }
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void OutputFile::take_place() {
  if (!new_) return;
  new_->take_place();
  new_.reset();
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
  // A pipe or a device cannot be synced, and loses nothing.
  if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != EROFS)
    throw IoError(path_, "cannot be brought to the disk: " + last_error());
}

void OutputFile::check_in_place() const {
  if (!new_) viscobar::check_in_place(path_, FileIdentity(descriptor_));
}

void OutputFile::close() {
  if (descriptor_ < 0) return;
  check_in_place();
  // Network file systems report a full disk here at the earliest.
  if (::close(std::exchange(descriptor_, -1)) != 0) throw IoError(path_, "cannot be closed: " + last_error());
  take_place();
}

void LineFile::flush() {
  file_.check_in_place();
  file_.write_at(written_.bytes, block_);
  written_.add(block_);
  block_.clear();
}

void LineFile::close() {
  flush();
  file_.close();
}

void remove_file(const std::filesystem::path& file) {
  if (::unlink(file.c_str()) != 0 && errno != ENOENT) throw IoError(file, "cannot be removed: " + last_error());
}

void check_replaceable(const std::filesystem::path& path) {
  struct stat there {};
  if (::lstat(path.c_str(), &there) == 0 && !S_ISREG(there.st_mode) && !S_ISLNK(there.st_mode))
    throw IoError(path, "cannot be replaced: it is no regular file");
}

void move_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) throw IoError(to, "cannot be replaced: " + last_error());
}

void sync_file(const std::filesystem::path& file) {
  OutputFile opened(file, OutputFile::Content::keep);
  opened.sync();
  opened.close();
}

void sync_directory(const std::filesystem::path& directory) {
  const int descriptor = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) throw IoError(directory, "cannot be opened: " + last_error());
  const bool synced = ::fsync(descriptor) == 0 || errno == EINVAL;
  const std::string error = last_error();
  ::close(descriptor);
  if (!synced) throw IoError(directory, "cannot be brought to the disk: " + error);
}

void make_directories(const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) throw IoError(directory, "cannot be created: " + error.message());
}

std::string file_content(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file)) throw IoError(file, "is a directory, and not a file");
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) throw IoError(file, "cannot be read");
  return text;
}

Checksum checksum_of_file(const std::filesystem::path& file, std::uint64_t begin, std::uint64_t length) {
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(begin));
  Checksum sum;
  std::vector<char> block(1 << 18);
  while (stream && sum.bytes < length) {
    stream.read(block.data(), static_cast<std::streamsize>(std::min<std::uint64_t>(block.size(), length - sum.bytes)));
    sum.add({block.data(), static_cast<std::size_t>(stream.gcount())});
  }
  if (stream.bad() || (!stream && !stream.eof()))
    throw IoError(file, "cannot be read: " + std::generic_category().message(errno));
  return sum;
}

void write_atomically(const std::filesystem::path& path, std::string_view text, bool durable) {
  OutputFile file(path);
  file.write_at(0, text);
  if (durable) file.sync();
  file.close();
}

}  // namespace viscobar
