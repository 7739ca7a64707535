#include "io/result_directory.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <system_error>

#include "viscobar/io/io_error.hpp"

namespace viscobar {

void prepare_result_directory(const std::filesystem::path& directory) {
  namespace fs = std::filesystem;
  constexpr std::array summaries = {"summary.json", "compare.json", "limit.json", "precision.json"};
  std::error_code error;
  const bool there = fs::exists(directory, error);
  if (there && !fs::is_directory(directory))
    throw std::invalid_argument(directory.string() + " is not a directory; choose another place for the results");
  const auto has = [&](const char* file) { return fs::exists(directory / file); };
  // What a run leaves that was killed before it had a summary.
  const auto begun = [](const fs::directory_entry& entry) { return entry.path().extension() == ".part"; };
  const auto files = [&] { return fs::directory_iterator(directory, error); };
  if (there && !std::all_of(begin(files()), end(files()), begun) &&
      std::none_of(summaries.begin(), summaries.end(), has))
    throw std::invalid_argument(directory.string() +
                                " holds files and no result of viscobar (no summary.json); nothing was overwritten, "
                                "choose another directory");
  if (error) throw IoError(directory, "cannot be read: " + error.message());
  fs::create_directories(directory, error);
  if (error) throw IoError(directory, "cannot be created: " + error.message());
}

}  // namespace viscobar
