#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace viscobar {

/// A table of measured values, as instruments, spreadsheets and programs write it: a line of names, `t` or `time` among
/// them, and a line for each time.
///
/// Between values are commas, semicolons, tabs or blanks; with another separator than commas, and in quotes, a comma
/// may be the decimal point. Names may have units ("t [s]", "u_left (mm)"), also in a line of their own. Lines before
/// the names, comments (#, %, !, //), empty lines and columns of other names are left out. Empty cells and words such
/// as NA are values that were not measured; so are codes such as -9999 that stand far off from all other values. Rows
/// are sorted by time.
struct TraceFile {
  struct Column {
    std::string name;                ///< one of the known names
    std::string unit;                ///< as written; empty: none
    std::vector<std::string> cells;  ///< of a column of words: as written, blanks and quotes around them left out
    std::vector<double> values;      ///< NaN where there is none; of a column of words all NaN
    double factor = 1.0;             ///< that the values as written were multiplied by
  };
  std::vector<Column> columns;        ///< of known names
  std::size_t rows = 0;               ///< of data
  std::vector<std::size_t> lines;     ///< of the file, the first is 1: that of each row
  std::string understood;             ///< how the file was read, in a line
  std::vector<std::string> warnings;  ///< values that were left out as codes, in sentences

  const Column* column(std::string_view name) const;  ///< nullptr where there is none
  Column* column(std::string_view name);              ///< nullptr where there is none
};

/// Reads one with columns of those names, `t` first; those of `words` are words and the others numbers. A name that
/// ends with @ stands for all that begin so: u@ for u@0.25. With `places` it is the column of that name that stands for
/// `t`, and its numbers may be negative: a series that moves a bar, which has a value in each row, and its rows in
/// order.
/// @throws SceneError naming file, line, column and what is wrong; also for a file of a result that is damaged
TraceFile read_traces(const std::filesystem::path& file, const std::vector<std::string>& known,
                      const std::vector<std::string>& required, const std::vector<std::string>& words = {},
                      std::string_view places = {});

/// Factor from the unit `from` to the unit `to`: "s", "m", "g", "N", "Pa" with decimal prefixes, "min", "h", "t", "in",
/// "ft", "lbf", "psi", "%", products, quotients and powers of them such as "kg/(m s^2)"; absent for others and where
/// one measures another quantity.
std::optional<double> unit_ratio(std::string_view from, std::string_view to);

}  // namespace viscobar
