#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "viscobar/results/io_error.hpp"

namespace viscobar {

/// A directory that another process, or another part of this one, is at work in.
class DirectoryInUse : public IoError {
 public:
  DirectoryInUse(std::filesystem::path directory, const std::string& holder, bool same_job)
      : IoError(std::move(directory), "is in use by viscobar, " + holder + "; nothing was changed"),
        by_same_job(same_job) {}
  bool by_same_job;  ///< of mpirun, srun or a like, which started both
};

/// Keeps a directory for one process, or one part of it, until the object ends: flock(2) on the file `.viscobar.lock`
/// in it, which says who holds it. The system releases it when the process ends, whatever ends it.
class DirectoryLock {
 public:
  /// @throws DirectoryInUse at once @throws IoError when no file can be made in it
  explicit DirectoryLock(std::filesystem::path directory);
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

  static constexpr const char* file_name = ".viscobar.lock";
  /// False on a file system without locks, where nothing keeps others out.
  bool held() const { return held_; }
  /// Removes the file of the lock made last, for a handler of signals that ends the program.
  static void abandon();

 private:
  std::filesystem::path file_;
  const char* before_ = nullptr;  // the file of the lock made before
  int descriptor_ = -1;
  bool held_ = true;
};

}  // namespace viscobar
