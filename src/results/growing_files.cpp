#include "results/growing_files.hpp"

#include <fmt/format.h>

#include <system_error>

#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

void check_length(const fs::path& file, std::uint64_t length) {
  std::error_code error;
  const fs::file_type there = fs::symlink_status(file, error).type();
  if (there == fs::file_type::not_found) throw IoError(file, "is missing: it was removed since the checkpoint");
  if (there != fs::file_type::regular) throw IoError(file, "is no regular file: it was replaced since the checkpoint");
  const auto size = fs::file_size(file, error);
  if (error) throw IoError(file, "cannot be read: " + error.message());
  if (size < length) throw IoError(file, "is shorter than at the checkpoint: it was changed since");
}

}  // namespace

void check_begin(const fs::path& file, const Checksum& expected) {
  check_length(file, expected.bytes);
  if (checksum_of_file(file, 0, expected.bytes) != expected)
    throw IoError(file,
                  fmt::format("its first {} bytes are not those of the checkpoint: it was changed or damaged since",
                              expected.bytes));
}

void GrowingFiles::Mark::check(const fs::path& directory) const {
  check_length(directory / "field.h5", field.length);
  check_begin(directory / "ends.csv", ends);
  check_begin(directory / "events.csv", events);
  if (sensitivity) check_begin(directory / "sensitivity.csv", *sensitivity);
  field.check_values(directory / "field.h5");
}

}  // namespace viscobar
