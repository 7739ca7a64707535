#include "io/growing_files.hpp"

#include <system_error>
#include <utility>

#include "viscobar/io/io_error.hpp"

namespace viscobar {

void GrowingFiles::Mark::check(const std::filesystem::path& directory) const {
  for (const auto& [name, length] : {std::pair{"ends.csv", ends}, {"events.csv", events}, {"field.h5", field.length}}) {
    std::error_code error;
    const auto size = std::filesystem::file_size(directory / name, error);
    if (error) throw IoError(directory / name, "cannot be read: " + error.message());
    if (size < length)
      throw IoError(directory / name,
                    "is shorter than at the checkpoint: it was changed since; nothing was overwritten");
  }
}

}  // namespace viscobar
