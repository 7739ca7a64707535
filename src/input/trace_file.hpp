#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace viscobar {

/// A table of measured values: the first line names the columns, `t` among them, commas between.
struct TraceFile {
  struct Column {
    std::string name;
    std::vector<std::string> cells;  ///< as written, blanks around them left out
    std::vector<double> values;      ///< NaN for an empty cell or nan; of a column of words all NaN
  };
  std::vector<Column> columns;
  std::size_t rows = 0;

  const Column* column(std::string_view name) const;  ///< nullptr where there is none
};

/// Reads one with columns of those names only, those of `words` being words and the others numbers.
/// @throws SceneError naming file, line, column and what is wrong
TraceFile read_traces(const std::filesystem::path& file, const std::vector<std::string>& known,
                      const std::vector<std::string>& required, const std::vector<std::string>& words = {});

}  // namespace viscobar
