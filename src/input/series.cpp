#include "input/series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <stdexcept>
#include <system_error>
#include <tuple>
#include <utility>

#include "input/known.hpp"
#include "input/trace_file.hpp"
#include "text/nearest_name.hpp"

namespace viscobar {

namespace {

// The slope at s[0] of the polynomial through the first `count` values; `step` is 1, or -1 from the end on.
double slope_at_end(const double* s, const double* y, std::ptrdiff_t step, std::size_t count) {
  double sum = 0.0;
  for (std::size_t j = 1; j < count; ++j) {
    const auto at = [&](std::size_t k) { return s[static_cast<std::ptrdiff_t>(k) * step]; };
    double weight = 1.0 / (at(j) - at(0));  // of y_j - y_0, by Lagrange's polynomials
    for (std::size_t k = 1; k < count; ++k)
      if (k != j) weight *= (at(0) - at(k)) / (at(j) - at(k));
    sum += weight * (y[static_cast<std::ptrdiff_t>(j) * step] - y[0]);
  }
  return sum;
}

/// The number next to zero where both have one sign, else 0.
double least_of(double a, double b) {
  const auto [low, high] = std::minmax(a, b);
  return low > 0.0 ? low : high < 0.0 ? high : 0.0;
}

/// Limits the slopes m of a cubic spline through y(t): it rises, falls and stays where the samples do, and does not
/// swing beside a jump or a kink. Between chords of slopes d and d' that is so where m has their sign and is at most
/// 3 min(|d|, |d'|) [Fritsch and Carlson 1980]. It may leave that where the samples bend one way over five intervals
/// alike, as those of a smooth function do at a maximum: then it is no further from the parabolas of both sides than
/// they bend.
void limit_slopes(std::span<const double> t, std::span<const double> y, std::vector<double>& m) {
  constexpr double alike = 4.0;
  const std::size_t n = t.size();
  const auto length = [&](std::size_t i) { return t[i + 1] - t[i]; };
  const auto chord = [&](std::size_t i) { return (y[i + 1] - y[i]) / length(i); };
  // By how much slopes change over half of the i-th interval at least, 0 where the samples beside it do not bend alike.
  const auto bend = [&](std::size_t i) {
    double least = std::numeric_limits<double>::infinity(), sign = 0.0, shortest = length(i), longest = length(i);
    for (std::size_t k = std::max<std::size_t>(i, 2) - 1; k <= std::min(i + 2, n - 2); ++k) {
      const double second = (chord(k) - chord(k - 1)) / (t[k + 1] - t[k - 1]);
      if (sign * second < 0.0) return 0.0;
      sign = std::copysign(1.0, second);
      least = std::min(least, std::abs(second));
      shortest = std::min({shortest, length(k - 1), length(k)});
      longest = std::max({longest, length(k - 1), length(k)});
    }
    return longest <= alike * shortest ? sign * least * length(i) : 0.0;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = i > 0 ? i - 1 : 0, behind = std::min(i, n - 2);
    const double most = 3.0 * least_of(chord(before), chord(behind));
    const double limited = std::clamp(m[i], std::min(most, 0.0), std::max(most, 0.0));
    if (limited == m[i]) continue;
    const double of_before = bend(before), of_behind = bend(behind), bends = std::abs(least_of(of_before, of_behind));
    const double left = i > 0 ? chord(before) + of_before : chord(0) - of_behind;
    const double right = i + 1 < n ? chord(behind) - of_behind : left;
    m[i] = bends > 0.0 ? std::clamp(m[i], std::min(left, right) - bends, std::max(left, right) + bends) : limited;
  }
}

}  // namespace

Series::Series(std::vector<double> places, std::vector<double> values, Interpolation interpolation, Outside outside)
    : places_(std::move(places)), values_(std::move(values)), interpolation_(interpolation), outside_(outside) {
  if (smooth()) find_slopes();
  find_breaks();
}

// m_{k-1} / h_{k-1} + 2 (1 / h_{k-1} + 1 / h_k) m_k + m_{k+1} / h_k = 3 (d_{k-1} / h_{k-1} + d_k / h_k), with the
// widths h and the slopes d of the chords: the second derivative does not jump.
void Series::find_slopes() {
  const std::size_t n = places_.size(), count = std::min<std::size_t>(n, 4);
  slopes_.assign(n, 0.0);
  if (n < 2) return;
  slopes_.front() = slope_at_end(places_.data(), values_.data(), 1, count);
  slopes_.back() = slope_at_end(&places_.back(), &values_.back(), -1, count);
  std::vector<double> upper(n, 0.0);
  for (std::size_t k = 1; k + 1 < n; ++k) {
    const double before = places_[k] - places_[k - 1], after = places_[k + 1] - places_[k];
    const double pivot = 2.0 * (1.0 / before + 1.0 / after) - upper[k - 1] / before;
    upper[k] = 1.0 / (after * pivot);
    slopes_[k] = (3.0 * (chord(k - 1) / before + chord(k) / after) - slopes_[k - 1] / before) / pivot;
  }
  for (std::size_t k = n - 1; k-- > 1;) slopes_[k] -= upper[k] * slopes_[k + 1];
  if (n > 2) limit_slopes(places_, values_, slopes_);
}

// Kinks and jumps; and jumps of the second derivative, which limited slopes leave, and the ends of stretches over which
// one cubic is the function to a hundredth of its range, so that no step passes a pulse by.
void Series::find_breaks() {
  const std::size_t n = places_.size();
  const auto [low, high] = std::ranges::minmax_element(values_);
  const double range = *high - *low, largest = std::max(std::abs(*low), std::abs(*high));
  double steepest = 0.0;
  for (std::size_t k = 0; k + 1 < n; ++k)
    if (places_[k + 1] > places_[k]) steepest = std::max(steepest, std::abs(chord(k)));
  const auto jumps = [&](std::size_t k) {
    if (k == 0 || k + 1 == n) {
      if (outside_ == Outside::zero && values_[k] != 0.0) return true;
      if (outside_ == Outside::goes_on) return false;
    }
    if (n > 1 && (places_[k] == places_[k > 0 ? k - 1 : 1] || places_[k] == places_[k + 1 < n ? k + 1 : n - 2]))
      return n > 1 && places_.front() < places_.back();
    const double left = k > 0 ? smooth() ? slopes_[k] : chord(k - 1) : 0.0;
    const double right = k + 1 < n ? smooth() ? slopes_[k] : chord(k) : 0.0;
    return std::abs(right - left) > 1e-9 * steepest;
  };
  const auto plain = [&](std::size_t a, std::size_t b) {
    std::array<double, 4> s, y;
    for (std::size_t j = 0; j < 4; ++j)
      s[j] = std::lerp(places_[a], places_[b], static_cast<double>(j) / 3.0), y[j] = (*this)(s[j]);
    for (std::size_t k = a + 1; k < b; ++k) {
      double sum = 0.0;
      for (std::size_t j = 0; j < 4; ++j) {
        double weight = 1.0;
        for (std::size_t i = 0; i < 4; ++i)
          if (i != j) weight *= (places_[k] - s[i]) / (s[j] - s[i]);
        sum += weight * y[j];
      }
      if (!(std::abs(sum - values_[k]) <= 0.01 * range)) return false;
    }
    return true;
  };
  const auto add = [&](std::vector<double>& to, std::size_t k) {
    if (to.empty() || to.back() < places_[k]) to.push_back(places_[k]);
  };
  auto& [kinks, of_load, of_motion] = breaks_;
  for (std::size_t k = 0; k < n && largest > 0.0; ++k)
    if (jumps(k)) add(kinks, k);
  const auto bends = [&](std::size_t k) {
    const double before = places_[k] - places_[k - 1], after = places_[k + 1] - places_[k];
    const double left = (4.0 * slopes_[k] + 2.0 * slopes_[k - 1] - 6.0 * chord(k - 1)) / before;
    const double right = (6.0 * chord(k) - 4.0 * slopes_[k] - 2.0 * slopes_[k + 1]) / after;
    return std::abs(right - left) > 1e-6 * steepest / std::min(before, after);
  };
  // Less than this, as of some thousand samples in a period, spoils no tolerance of 1e-9.
  const auto twists = [&](std::size_t k) {
    const auto third = [&](std::size_t j) {
      const double h = places_[j + 1] - places_[j];
      return 6.0 * (slopes_[j] + slopes_[j + 1] - 2.0 * chord(j)) / (h * h);
    };
    const double shorter = std::min(places_[k] - places_[k - 1], places_[k + 1] - places_[k]);
    return std::abs(third(k) - third(k - 1)) * shorter * shorter > 1e-7 * steepest;
  };
  std::vector<double> ends;
  for (std::size_t a = 0; a + 1 < n;) {
    std::size_t step = 1, b = a + 1;
    for (; b + step < n && plain(a, b + step); step *= 2) b += step;
    for (; step > 0; step /= 2)
      if (b + step < n && plain(a, b + step)) b += step;
    if (b + 1 < n) add(ends, b);
    a = b;
  }
  std::vector<double> bent, twisted;
  for (std::size_t k = 1; smooth() && k + 1 < n; ++k) {
    if (bends(k)) add(bent, k);
    if (twists(k)) add(twisted, k);
  }
  const auto both = [](const std::vector<double>& x, const std::vector<double>& y) {
    std::vector<double> all;
    std::ranges::set_union(x, y, std::back_inserter(all));
    return all;
  };
  of_load = both(kinks, both(ends, bent));
  of_motion = both(of_load, twisted);
}

double Series::operator()(double s, int derivative) const {
  const std::size_t n = places_.size();
  const auto next = std::ranges::upper_bound(places_, s);
  const bool before = next == places_.begin(), behind = next == places_.end();
  const bool at_end = behind && s == places_.back();
  // Two values at an end are no line to go on with.
  const bool goes_on =
      outside_ == Outside::goes_on && n > 1 && (before ? places_[0] < places_[1] : places_[n - 2] < places_[n - 1]);
  if ((before || behind) && !goes_on) {
    if (derivative > 0 && !(at_end && n > 1)) return 0.0;
    if (derivative == 0) return outside_ == Outside::zero && !at_end ? 0.0 : before ? values_.front() : values_.back();
  }
  const std::size_t k = before ? 0 : behind ? n - 2 : static_cast<std::size_t>(next - places_.begin()) - 1;
  const double h = places_[k + 1] - places_[k], z = s - places_[k], chord = this->chord(k);
  if (!smooth()) return derivative == 0 ? values_[k] + chord * z : derivative == 1 ? chord : 0.0;
  const double b = (3.0 * chord - 2.0 * slopes_[k] - slopes_[k + 1]) / h;
  const double c = (slopes_[k] + slopes_[k + 1] - 2.0 * chord) / (h * h);
  if (derivative == 0) return values_[k] + z * (slopes_[k] + z * (b + z * c));
  return derivative == 1 ? slopes_[k] + z * (2.0 * b + 3.0 * c * z) : 2.0 * b + 6.0 * c * z;
}

std::optional<double> Series::next_break(double after, double until, Breaks which) const {
  const std::vector<double>& all = breaks_[static_cast<std::size_t>(which)];
  const auto next = std::ranges::upper_bound(all, after);
  return next != all.end() && *next < until ? std::optional(*next) : std::nullopt;
}

// FNV-1a, 64 bits.
std::uint64_t Series::checksum() const {
  std::uint64_t sum = 14695981039346656037u;
  for (const std::vector<double>* all : {&places_, &values_})
    for (const double value : *all)
      for (std::uint64_t bits = std::bit_cast<std::uint64_t>(value), k = 0; k < 8; ++k, bits >>= 8)
        sum = (sum ^ (bits & 255)) * 1099511628211u;
  return sum;
}

namespace {

struct SeriesTable {
  const SceneTable& entries;

  const SceneTable::mapped_type* find(std::string_view name) const {
    const auto found = entries.find(std::string(name));
    return found == entries.end() ? nullptr : &found->second;
  }
  /// The value, if of the kind wanted; null where there is none. @throws std::invalid_argument where it is another
  template <class Value>
  const Value* get(std::string_view name, std::string_view kind) const {
    const auto* found = find(name);
    if (!found) return nullptr;
    if (const auto* value = std::get_if<Value>(found)) return value;
    throw std::invalid_argument(fmt::format("{} must be {}", name, kind));
  }
  std::string word(std::string_view name, std::initializer_list<std::string_view> known,
                   std::string_view otherwise) const {
    const auto* value = get<std::string>(name, "a string");
    if (!value) return std::string(otherwise);
    if (std::ranges::find(known, *value) == known.end())
      throw std::invalid_argument(
          fmt::format("{} cannot be \"{}\"; there are \"{}\"", name, *value, fmt::join(std::vector(known), "\", \"")));
    return *value;
  }
};

// Factor from the numbers of a column to those of the scene.
double ratio(const TraceFile::Column& column, const std::string& name, const std::string& unit, bool names_units) {
  if (column.unit.empty()) return 1.0;
  if (unit.empty() && names_units)
    throw std::invalid_argument(
        fmt::format("column {} is in {}, and [units] of the scene does not say what its own numbers are in: name "
                    "those units too, or give a scale",
                    name, column.unit));
  if (unit.empty()) return 1.0;
  const auto ratio = unit_ratio(column.unit, unit);
  if (!ratio)
    throw std::invalid_argument(
        fmt::format("column {} is in {}, and the scene's unit for it is {}: give a scale that "
                    "converts it",
                    name, column.unit, unit));
  return *ratio;
}

std::pair<std::vector<double>, std::vector<double>> measured(const SeriesTable& table, const SeriesRequest& request) {
  const std::string name(1, request.variable);
  const auto* file = table.get<std::string>("file", "a string");
  const auto* column = table.get<std::string>("column", "a string");
  if (!file || !column)
    throw std::invalid_argument(
        fmt::format("a series has a file and a column, or places {} and values", request.variable));
  if (table.find("values")) throw std::invalid_argument("a series has a file, or values, and not both");
  const auto* of_places = table.get<std::string>(table.find("time") ? "time" : name, "the name of a column");
  const std::string places_name = of_places ? *of_places : name;
  const std::string named = column->substr(0, column->find_first_of("[(/")), values_name = plain_name(named);
  TraceFile read = read_traces(request.folder / *file, {"t", values_name}, {"t", named}, {}, places_name);
  if (!read.warnings.empty()) throw std::invalid_argument(read.warnings.front());
  const TraceFile::Column &at = *read.column("t"), &of = *read.column(values_name);
  const double place_ratio = ratio(at, places_name, request.place_unit, request.names_units);
  const double value_ratio = table.find("scale") ? 1.0 : ratio(of, *column, request.unit, request.names_units);
  std::pair<std::vector<double>, std::vector<double>> all;
  for (std::size_t k = 0; k < read.rows; ++k) {
    if (!std::isfinite(of.values[k])) continue;
    all.first.push_back(place_ratio * at.values[k]);
    all.second.push_back(value_ratio * of.values[k]);
  }
  return all;
}

std::pair<std::vector<double>, std::vector<double>> given(const SeriesTable& table, const SeriesRequest& request) {
  const auto* places = table.get<std::vector<double>>(std::string(1, request.variable), "an array of numbers here");
  const auto* values = table.get<std::vector<double>>("values", "an array of numbers");
  if (!places || !values)
    throw std::invalid_argument(
        fmt::format("a series has a file and a column, or places {} and values", request.variable));
  if (table.find("column")) throw std::invalid_argument("column is one of a file, and values stand here: leave it out");
  if (places->size() != values->size())
    throw std::invalid_argument(
        fmt::format("{} has {} numbers and values {}", request.variable, places->size(), values->size()));
  for (const std::vector<double>* all : {places, values})
    for (const double value : *all)
      if (!std::isfinite(value)) throw std::invalid_argument(fmt::format("a series is finite, and one is {}", value));
  if (!std::ranges::is_sorted(*places))
    throw std::invalid_argument(fmt::format("{} must not decrease", request.variable));
  return {*places, *values};
}

std::shared_ptr<const Series> read_series(const SceneTable& entries, const SeriesRequest& request) {
  const SeriesTable table{entries};
  const std::string variable(1, request.variable);
  std::vector<std::string> known = {"file",          "column", variable,  "values",
                                    "interpolation", "scale",  "outside", "checksum"};
  if (request.variable == 't') known.emplace_back("time");
  for (const auto& [name, value] : entries)
    if (std::ranges::find(known, name) == known.end()) {
      const auto nearest = nearest_name(name, known);
      throw std::invalid_argument(fmt::format(
          "a series has no \"{}\"; {}", name,
          nearest ? fmt::format("nearest is \"{}\"", *nearest) : fmt::format("there are {}", fmt::join(known, ", "))));
    }
  if (table.find("time") && (table.find("t") || !table.find("file")))
    throw std::invalid_argument("time is the column of times in a file, and t another name of it");
  auto [places, values] = table.find("file") ? measured(table, request) : given(table, request);
  if (places.empty()) throw std::invalid_argument("a series has a value at least, and this one has none");
  if (const double* scale = table.get<double>("scale", "a number"))
    for (double& value : values) value *= *scale;
  const Interpolation interpolation = table.word("interpolation", {"linear", "cubic"}, "cubic") == "cubic"
                                          ? Interpolation::cubic
                                          : Interpolation::linear;
  const std::string word = table.word("outside", {"hold", "zero"}, "");
  const Outside outside = word == "zero" ? Outside::zero : word == "hold" ? Outside::hold : Outside::goes_on;
  if (outside == Outside::zero && !request.jumps)
    throw std::invalid_argument("the motion of a fixed end does not jump: outside is \"hold\"");
  for (std::size_t k = 0; k + 1 < places.size(); ++k) {
    if (places[k] != places[k + 1]) continue;
    const bool thrice = k + 2 < places.size() && places[k] == places[k + 2];
    if (interpolation == Interpolation::cubic || !request.jumps || thrice)
      throw std::invalid_argument(fmt::format("has {} values at {} = {}{}", thrice ? "three" : "two", request.variable,
                                              places[k],
                                              thrice           ? ""
                                              : !request.jumps ? ", and the motion of a fixed end does not jump"
                                                               : ": a jump, for which interpolation is \"linear\""));
  }
  for (const double value : values)
    if (!std::isfinite(value)) throw std::invalid_argument("a value times the scale is not finite");
  auto series = std::make_shared<const Series>(std::move(places), std::move(values), interpolation, outside);
  if (const auto* sum = table.get<std::string>("checksum", "a string");
      sum && *sum != fmt::format("{:016x}", series->checksum()))
    throw std::invalid_argument(
        fmt::format("{} has changed since the result was made", *table.get<std::string>("file", "a string")));
  return series;
}

}  // namespace

// A file that has not changed is read once: a scene asks for its series several times, and a sweep in each of its
// cases.
std::shared_ptr<const Series> series_of(const SceneTable& entries, const SeriesRequest& request) {
  using Key = std::tuple<std::string, std::filesystem::file_time_type, std::uintmax_t, SceneTable, std::string,
                         std::string, char>;
  static Known<Key, std::shared_ptr<const Series>> all;
  const auto entry = entries.find("file");
  const auto* name = entry == entries.end() ? nullptr : std::get_if<std::string>(&entry->second);
  if (!name) return read_series(entries, request);
  std::error_code none;
  const std::filesystem::path file = request.folder / *name;
  const auto written = std::filesystem::last_write_time(file, none);
  const auto size = std::filesystem::file_size(file, none);
  if (none) return read_series(entries, request);
  return all({file.string(), written, size, entries, request.unit, request.place_unit, request.variable},
             [&] { return read_series(entries, request); });
}

// Near the start by Taylor's series, for a run looks for a jump there, and roundings of f would be one.
characteristics::FunctionOfTime function_of(std::shared_ptr<const Series> series) {
  const Series& f = *series;
  const double start = f(0.0), rate = f(0.0, 1), second = f(0.0, 2),
               early = 1e-9 * (f.last() - std::max(0.0, f.first()));
  const auto derivative = [series](int order) -> TimeFunction {
    return [series, order](double t) { return (*series)(t, order); };
  };
  return {
      start,
      {[=](double t) { return t < early ? (rate + 0.5 * second * t) * t : (*series)(t)-start; }, derivative(1),
       derivative(2),
       [series](double after, double until) { return series->next_break(after, until, Series::Breaks::of_motion); }}};
}

}  // namespace viscobar
