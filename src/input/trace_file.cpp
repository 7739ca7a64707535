#include "input/trace_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "input/input_text.hpp"
#include "input/seal.hpp"
#include "text/nearest_name.hpp"
#include "text/number.hpp"
#include "text/printable_text.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {

namespace {

constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();
using Cells = std::vector<std::string>;

bool contains(const Cells& names, std::string_view name) { return std::ranges::find(names, name) != names.end(); }

/// The text of a file without byte order mark, each line ended by \n. UTF-16 is read as far as it is ASCII.
std::string text_of(const std::filesystem::path& file) {
  constexpr std::size_t most_bytes = std::size_t{1} << 30;
  std::string raw = input_text(file, most_bytes), text;
  check_unchanged(file, raw);
  if (raw.starts_with("\xff\xfe") || raw.starts_with("\xfe\xff")) {
    const std::size_t low = raw[0] == '\xff' ? 0 : 1;
    for (std::size_t i = 2; i + 1 < raw.size(); i += 2) text += raw[i + 1 - low] == '\0' ? raw[i + low] : '?';
    raw.swap(text);
  }
  text.clear();
  for (std::size_t i = raw.starts_with("\xef\xbb\xbf") ? 3 : 0; i < raw.size(); ++i)
    if (raw[i] != '\r')
      text += raw[i];
    else if (i + 1 == raw.size() || raw[i + 1] != '\n')
      text += '\n';
  return text;
}

char separator_of(std::string_view line) {
  bool quoted = false;
  std::string seen;
  for (const char c : line) {
    quoted = quoted != (c == '"');
    if (!quoted) seen += c;
  }
  for (const char c : {'\t', ';', ','})
    if (seen.find(c) != seen.npos) return c;
  return ' ';
}

Cells cells_of(std::string_view line, char separator) {
  Cells cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (!quoted && (c == separator || (separator == ' ' && c == '\t')))
      cells.emplace_back();
    else
      cells.back() += c;
  }
  for (std::string& cell : cells) cell = std::string(trimmed(cell));
  if (separator == ' ') {
    std::erase(cells, "");
    // A unit in brackets belongs to the name before it.
    for (std::size_t k = cells.size(); k-- > 1;)
      if (cells[k].starts_with('[') || cells[k].starts_with('('))
        cells[k - 1] += cells[k], cells.erase(cells.begin() + static_cast<std::ptrdiff_t>(k));
  }
  while (!cells.empty() && cells.back().empty()) cells.pop_back();
  return cells;
}

/// Text behind the mark of a comment; absent for other lines.
std::optional<std::string_view> comment_in(std::string_view line) {
  for (const std::string_view mark : {"#", "%", "!", "//"})
    if (line.starts_with(mark)) return line.substr(std::min(line.find_first_not_of("#%!/ \t"), line.size()));
  return std::nullopt;
}

bool is_missing(const std::string& cell) {
  static const Cells words = {"",     "na",      "n/a",  "n.a.", "#n/a", "#na", "nan", "null", "nil",
                              "none", "missing", "void", "-",    "--",   "---", ".",   "?",    "*"};
  const std::string_view name = std::string_view(cell).substr(cell.starts_with('-') && cell.size() > 1 ? 1 : 0);
  return contains(words, plain_name(name)) || name.starts_with("nan(") ||
         (!cell.empty() && cell.find_first_not_of('-') == cell.npos);
}

struct Number {
  std::optional<double> value;
  bool comma = false;  ///< was its decimal point
};

Number number_of(std::string cell) {
  if (cell.starts_with("\xe2\x88\x92")) cell.replace(0, 3, "-");
  if (cell.starts_with('+')) cell.erase(0, 1);
  const std::size_t comma = cell.find(',');
  if (comma != cell.npos && cell.find('.') == cell.npos) cell[comma] = '.';
  if (const std::size_t d = cell.find_first_of("dD"); d != cell.npos && d > 0) cell[d] = 'e';  // Fortran's exponent
  auto value = number_in<double>(cell);
  if (value && !std::isfinite(*value)) value.reset();
  return {value, comma != cell.npos};
}

/// "U_Left [mm]" and the like: name and unit.
std::pair<std::string, std::string> name_and_unit(const std::string& cell) {
  std::string name = cell, unit;
  if (const std::size_t open = name.find_first_of("[(/"); open != name.npos && open > 0) {
    unit = name.substr(open + 1);
    if (name[open] != '/') unit = unit.substr(0, unit.find_first_of("])"));
    name.resize(open);
  }
  const std::size_t place = std::min(name.find('@'), name.size());  // from there on it is a number, such as 1e-05
  name = plain_name(name.substr(0, place)) + std::string(trimmed(std::string_view(name).substr(place)));
  if (const std::size_t low = name.rfind('_');
      unit.empty() && low != name.npos && unit_ratio(name.substr(low + 1), "s"))  // time_ms
    unit = name.substr(low + 1), name.resize(low);
  if (name == "time" || name == "times") name = "t";
  return {name, std::string(trimmed(unit))};
}

/// True if instruments write such a number for none: 999.., 999.25, 32767 and other ends of a range, 10^k from 10^4 on.
bool is_code(double value) {
  const double size = std::abs(value), tens = std::log10(size);
  for (const double end : {32767.0, 32768.0, 65535.0, 2147483647.0, 2147483648.0, 4294967295.0, 999.25})
    if (size == end) return true;
  if (size >= 1e20) return true;
  const double next = std::pow(10.0, std::ceil(tens)), power = std::pow(10.0, std::round(tens));
  return (size >= 999.0 && next > size && next - size <= 1.0) || (size >= 1e4 && std::abs(size - power) <= 1e-9 * size);
}

/// Takes values that stand for none, or for an instrument that was overloaded, out of a column: codes that are 10 times
/// as large as all other values, and the few that are 1000 times as large.
void remove_codes(const std::string& file, TraceFile& table, TraceFile::Column& column) {
  std::vector<double> sizes;
  for (const double value : column.values)
    if (std::isfinite(value)) sizes.push_back(std::abs(value));
  std::ranges::sort(sizes);
  while (!sizes.empty()) {
    const double most = sizes.back();
    const auto first = std::ranges::lower_bound(sizes, most);
    const auto count = static_cast<std::size_t>(sizes.end() - first);
    if (count == sizes.size()) return;
    const double below = *(first - 1);
    const auto same = [most](double value) { return std::abs(value) == most; };
    const auto at = std::ranges::find_if(column.values, same);
    const bool far = below > 0.0 && most > 1000.0 * below && 10 * count < sizes.size();
    if (!far && !(most > 10.0 * below && is_code(*at))) return;
    table.warnings.push_back(fmt::format(
        "{}: {} of {} values of {} are {} (the first at t = {}), all others at most {:.3g}: counted as not measured",
        file, count, sizes.size(), column.name, *at,
        table.column("t")->values[static_cast<std::size_t>(at - column.values.begin())], below));
    std::ranges::replace_if(column.values, same, not_measured);
    sizes.erase(first, sizes.end());
  }
}

// Sorts the rows by time, and says whether they were not.
bool sort_rows(TraceFile& table) {
  const std::vector<double> times = table.column("t")->values;
  if (std::ranges::is_sorted(times)) return false;
  std::vector<std::size_t> order(times.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t k) { return times[k]; });
  for (TraceFile::Column& column : table.columns) {
    const TraceFile::Column before = column;
    for (std::size_t k = 0; k < order.size(); ++k) {
      column.values[k] = before.values[order[k]];
      if (!before.cells.empty()) column.cells[k] = before.cells[order[k]];
    }
  }
  const std::vector<std::size_t> lines = table.lines;
  std::ranges::transform(order, table.lines.begin(), [&](std::size_t k) { return lines[k]; });
  return true;
}

class TraceReader {
 public:
  TraceReader(const std::filesystem::path& file, const Cells& known, const Cells& required, const Cells& words,
              std::string_view places)
      : file_(file.string()),
        known_(known),
        required_(required),
        words_(words),
        places_given_(places),
        places_name_(plain_name(places)) {}

  TraceFile read() {
    const std::string text = text_of(file_);
    std::string_view lines = text;
    if (lines.ends_with('\n')) lines.remove_suffix(1);
    const std::vector<std::string_view> all = split(lines, '\n');
    number_ = take_names(all);
    if (found_.empty())
      for (; number_ < all.size(); ++number_) read_line(trimmed(all[number_]));
    if (found_.empty() && table_.rows == 0 && !of_changes()) report(1, "", "holds no data");
    if (found_.empty()) finish();
    if (!found_.empty()) throw SceneError(std::move(found_));
    return std::move(table_);
  }

 private:
  void report(std::size_t column, const std::string& key, const std::string& what) {
    constexpr std::size_t most_faults = 20;
    if (found_.size() < most_faults)
      found_.push_back({file_, std::min(number_, lines_) + 1, column, one_line(key), one_line(what)});
  }

  std::pair<std::string, std::string> named(const std::string& cell) const {
    auto both = name_and_unit(cell);
    if (places_name_.empty() || places_name_ == "time" || both.first == places_name_)
      both.first = both.first == places_name_ ? "t" : both.first;
    else if (both.first == "t")
      both.first = "time";
    return both;
  }

  /// How many of time and of other known columns a line names: 0 to 2.
  int names_in(std::string_view line) const {
    bool time = false, other = false;
    for (const std::string& cell : cells_of(line, separator_of(line))) {
      const std::string name = named(cell).first;
      time = time || name == required_[0];
      other = other || (name != required_[0] && is_known(name));
    }
    return time ? 1 + int{other} : 0;
  }

  /// Takes the line of names, and tells that of the first value. Names in a comment are those of the numbers below it.
  std::size_t take_names(const std::vector<std::string_view>& all) {
    lines_ = all.size() - 1;
    std::optional<std::size_t> found, first, timed, remark;
    for (std::size_t k = 0; k < all.size() && !found; ++k) {
      const std::string_view line = trimmed(all[k]);
      if (line.empty() || line.starts_with("sep=")) continue;
      if (const auto said = comment_in(line)) {
        if (names_in(*said) > 0) remark = k;
        continue;
      }
      const int names = names_in(line);
      if (!first) first = k;
      if (!timed && names == 1) timed = k;
      if (names == 2) found = k;
      const Cells cells = cells_of(line, separator_of(line));
      if (!found && remark && !cells.empty() && number_of(cells[0]).value) found = remark;
    }
    number_ = found.value_or(timed.value_or(first.value_or(lines_)));
    left_out_ = found ? static_cast<std::size_t>(
                            std::ranges::count_if(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(number_),
                                                  [](std::string_view line) { return !trimmed(line).empty(); }))
                      : 0;
    const std::string_view line = trimmed(all[number_]);
    take_columns(comment_in(line).value_or(line));
    return number_ + 1;
  }

  bool is_known(std::string_view name) const {
    return std::ranges::any_of(known_, [&](const std::string& one) {
      return one.ends_with('@') || one.ends_with(':') ? name.starts_with(one) : name == one;
    });
  }

  void take_columns(std::string_view line) {
    separator_ = separator_of(line);
    const Cells cells = cells_of(line, separator_);
    for (const std::string& cell : cells) {
      const auto [name, unit] = named(cell);
      places_.push_back(is_known(name) ? table_.columns.size() : none);
      if (places_.back() == none) continue;
      if (table_.column(name)) report(places_.size(), cell, "is there twice");
      table_.columns.push_back({name, unit, {}, {}});
    }
    Cells extra;
    for (std::size_t k = 0; k < cells.size(); ++k) {
      if (places_[k] != none || cells[k].empty()) continue;
      extra.push_back(cells[k]);
      // One that is there under its own name is not meant by another.
      const auto nearest = nearest_name(named(cells[k]).first, known_);
      if (!nearest || table_.column(*nearest)) continue;
      const auto written = std::ranges::find_if(required_, [&](auto& one) { return plain_name(one) == *nearest; });
      report(k + 1, cells[k],
             fmt::format("unknown column; nearest is \"{}\"", written == required_.end() ? *nearest : *written));
    }
    const bool names =
        std::ranges::none_of(cells, [](const std::string& cell) { return number_of(cell).value.has_value(); });
    for (const std::string& name : required_)
      if (!table_.column(plain_name(name)))
        report(1, name == "t" && !places_given_.empty() ? places_given_ : name,
               cells.empty() ? "is missing: the file has no values"
               : names       ? fmt::format("is missing; the columns are {}", fmt::join(cells, ", "))
                             : "is missing: a line above the values names the columns");
    if (!extra.empty()) left(fmt::format("columns {}", fmt::join(extra, ", ")));
  }

  void read_line(std::string_view line) {
    if (comment_in(line)) ++comments_;
    if (line.empty() || comment_in(line)) return;
    Cells cells = cells_of(line, separator_);
    if (std::ranges::all_of(cells, &std::string::empty)) return;
    // As many as are named; what a spreadsheet leaves out at the end is empty.
    if (separator_ != ' ' && cells.size() < places_.size() &&
        std::ranges::count(line, separator_) + 1 >= std::ssize(places_))
      cells.resize(places_.size());
    const auto is_number = [](const std::string& cell) { return number_of(cell).value.has_value(); };
    if (table_.rows == 0 && !units_ && std::ranges::none_of(cells, is_number) &&
        !is_missing(cells[std::min(place_of_time(), cells.size() - 1)])) {
      units_ = true;
      for (std::size_t k = 0; k < std::min(cells.size(), places_.size()); ++k)
        if (places_[k] != none) table_.columns[places_[k]].unit = trimmed_unit(cells[k]);
      return left("a line of units");
    }
    if (cells.size() != places_.size())
      return report(1, "", fmt::format("has {} values for {} columns", cells.size(), places_.size()));
    ++table_.rows;
    table_.lines.push_back(number_ + 1);
    for (std::size_t k = 0; k < cells.size(); ++k)
      if (places_[k] != none) take(k, cells[k], table_.columns[places_[k]]);
  }

  void take(std::size_t k, const std::string& cell, TraceFile::Column& column) {
    double value = not_measured;
    if (contains(words_, column.name)) {
      column.cells.push_back(cell);
    } else if (!of_series() && is_missing(cell)) {
      ++missing_;
    } else {
      const Number number = number_of(cell);
      if (!number.value)
        report(k + 1, column.name,
               fmt::format("\"{}\" is no number{}", cell,
                           of_series() ? ", and the run needs one: leave the line out to go on between its neighbours"
                                       : "; leave the cell empty where nothing was measured"));
      value = number.value.value_or(not_measured);
      commas_ = commas_ || number.comma;
      points_ = points_ || (!number.comma && cell.find('.') != cell.npos);
      if (commas_ && points_ && found_.empty())
        report(k + 1, column.name, fmt::format("\"{}\": decimal commas and decimal points in one file", cell));
    }
    column.values.push_back(value);
  }

  void finish() {
    const std::vector<double>& t = table_.column("t")->values;
    for (std::size_t k = 0; k < t.size() && found_.empty(); ++k)
      if (of_series() ? std::isnan(t[k]) : !(t[k] >= 0.0)) {
        number_ = table_.lines[k] - 1;
        report(1, "t", std::isnan(t[k]) ? "is missing" : fmt::format("must be a time, not negative, is {}", t[k]));
      }
    for (std::size_t k = 1; k < t.size() && of_series(); ++k)
      if (t[k] < t[k - 1]) {
        number_ = table_.lines[k] - 1;
        report(1, places_name_, fmt::format("must not decrease: {} comes after {}", t[k], t[k - 1]));
      }
    if (!found_.empty()) return;
    const bool sorted = sort_rows(table_);
    Cells names;
    for (TraceFile::Column& column : table_.columns) {
      if (column.name != "t") names.push_back(labelled(column));
      if (column.name != "t" && !contains(words_, column.name)) remove_codes(file_, table_, column);
    }
    const auto equal = std::ranges::adjacent_find(t);
    const std::string from_to =
        t.empty() ? "" : fmt::format(", {} from {} to {}", labelled(*table_.column("t")), t.front(), t.back());
    table_.understood =
        fmt::format("{}: {}{}, of {}", file_, counted(table_.rows, "row"), from_to, fmt::join(names, ", "));
    const auto add = [&](bool holds, const std::string& what) {
      if (holds) table_.understood += "; " + what;
    };
    add(separator_ != ',', separator_ == ' '   ? "blanks between values"
                           : separator_ == ';' ? "semicolons between values"
                                               : "tabs between values");
    add(commas_, "decimal commas");
    add(missing_ > 0, counted(missing_, "value not measured"));
    add(sorted, "sorted by time");
    add(equal != t.end(), "some times are equal");
    add(comments_ > 0, counted(comments_, "line of comments left out"));
    add(left_out_ > 0, counted(left_out_, "line before the names left out"));
    for (const std::string& what : left_) add(true, what + " left out");
  }

  static std::string labelled(const TraceFile::Column& column) {
    return column.name + (column.unit.empty() ? "" : " [" + column.unit + "]");
  }
  bool of_series() const { return !places_name_.empty(); }
  /// A table of contact changes, of a motion that may have none.
  bool of_changes() const {
    return std::ranges::any_of(words_, [&](const std::string& word) { return table_.column(word); });
  }
  void left(std::string what) { left_.push_back(one_line(what)); }
  std::size_t place_of_time() const {
    for (std::size_t k = 0; k < places_.size(); ++k)
      if (places_[k] != none && table_.columns[places_[k]].name == "t") return k;
    return 0;
  }
  static std::string trimmed_unit(std::string cell) {
    std::erase_if(cell, [](char c) { return std::string_view("[]()").find(c) != std::string_view::npos; });
    return cell == "-" ? "" : cell;
  }

  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  std::string file_;
  const Cells &known_, &required_, &words_;
  const std::string places_given_, places_name_;  // of another column than t
  TraceFile table_;
  std::vector<Diagnostic> found_;
  std::vector<std::size_t> places_;  // of each column of the file, its place in the table
  std::size_t number_ = 0, lines_ = 0, comments_ = 0, missing_ = 0, left_out_ = 0;
  char separator_ = ',';
  bool commas_ = false, points_ = false, units_ = false;
  Cells left_;
};

}  // namespace

const TraceFile::Column* TraceFile::column(std::string_view name) const {
  const auto found = std::ranges::find(columns, name, &Column::name);
  return found == columns.end() ? nullptr : &*found;
}

TraceFile::Column* TraceFile::column(std::string_view name) {
  return const_cast<Column*>(std::as_const(*this).column(name));
}

TraceFile read_traces(const std::filesystem::path& file, const std::vector<std::string>& known,
                      const std::vector<std::string>& required, const std::vector<std::string>& words,
                      std::string_view places) {
  return TraceReader(file, known, required, words, places).read();
}

}  // namespace viscobar
