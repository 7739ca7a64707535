#include "results/directory_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <system_error>
#include <thread>

#include "results/output_file.hpp"

namespace viscobar {

namespace {

/// Name of the MPI job that this process belongs to; empty in no job.
std::string job() {
  for (const char* name : {"PMIX_NAMESPACE", "PMI_JOBID"})
    if (const char* value = std::getenv(name)) return fmt::format(", of job {}", value);
  return {};
}

std::string this_process() {
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return fmt::format("process {} on {}{}", ::getpid(), host.data(), job());
}

/// Who has locked the file a moment ago may not have written its name yet.
std::string holder(int descriptor) {
  std::array<char, 512> text{};
  for (int attempt = 0; attempt < 200; ++attempt) {
    const ssize_t count = ::pread(descriptor, text.data(), text.size(), 0);
    if (count > 0) return {text.data(), static_cast<std::size_t>(count)};
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return "another process";
}

int open_lock(const std::filesystem::path& file) {
  constexpr int flags = O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | flags, 0666);
  // One that a killed run of another user left can still be locked.
  if (descriptor >= 0 || errno != EACCES) return descriptor;
  const int for_reading = ::open(file.c_str(), O_RDONLY | flags);
  if (for_reading < 0) errno = EACCES;
  return for_reading;
}

std::atomic<const char*> latest = nullptr;  // the file of the lock made last
static_assert(std::atomic<const char*>::is_always_lock_free, "a signal handler may touch nothing else");

}  // namespace

DirectoryLock::DirectoryLock(std::filesystem::path directory) : file_(directory / file_name) {
  do {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = open_lock(file_);
    if (descriptor_ < 0)
      throw IoError(directory, "takes no files: " + std::generic_category().message(errno) + "; nothing was changed");
    int locked = 0;
    do locked = ::flock(descriptor_, LOCK_EX | LOCK_NB);
    while (locked != 0 && errno == EINTR);
    if (locked != 0 && errno == EWOULDBLOCK) {
      const std::string who = holder(descriptor_);
      ::close(std::exchange(descriptor_, -1));
      throw DirectoryInUse(std::move(directory), who, !job().empty() && who.ends_with(job()));
    }
    held_ = locked == 0;
    // The one before removes the file before it lets it go: what was locked may be a file that is no longer there.
  } while (held_ && FileIdentity(descriptor_) != FileIdentity(file_));
  before_ = latest.exchange(file_.c_str());
  const std::string who = this_process();
  // Only for the message to others, so neither a full disk nor a file of another user matters.
  if (::ftruncate(descriptor_, 0) == 0) [[maybe_unused]]
    const ssize_t written = ::pwrite(descriptor_, who.data(), who.size(), 0);
}

void DirectoryLock::abandon() {
  if (const char* file = latest) ::unlink(file);
}

DirectoryLock::~DirectoryLock() {
  latest = before_;
  ::unlink(file_.c_str());
  ::close(descriptor_);
}

}  // namespace viscobar
