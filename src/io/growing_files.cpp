#include "io/growing_files.hpp"

#include <system_error>
#include <utility>

#include "viscobar/io/io_error.hpp"

namespace viscobar {

namespace fs = std::filesystem;

void GrowingFiles::Mark::check(const std::filesystem::path& directory) const {
  for (const auto& [name, length] : {std::pair{"ends.csv", ends}, {"events.csv", events}, {"field.h5", field.length}}) {
    std::error_code error;
    if (fs::symlink_status(directory / name, error).type() == fs::file_type::not_found)
      throw IoError(directory / name, "is missing: it was removed since the checkpoint; nothing was changed");
    if (!fs::is_regular_file(fs::symlink_status(directory / name, error)))
      throw IoError(directory / name, "is no regular file: it was replaced since the checkpoint; nothing was changed");
    const auto size = fs::file_size(directory / name, error);
    if (error) throw IoError(directory / name, "cannot be read: " + error.message());
    if (size < length)
      throw IoError(directory / name,
                    "is shorter than at the checkpoint: it was changed since; nothing was overwritten");
  }
}

}  // namespace viscobar
