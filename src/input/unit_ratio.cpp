#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <system_error>
#include <utility>

#include "input/trace_file.hpp"

namespace viscobar {

namespace {

/// The size of a unit in metres, seconds and kilograms, and its powers of them.
struct Size {
  double factor = 1.0;
  std::array<double, 3> powers{};

  void multiply_by(const Size& other, double exponent) {
    factor *= exponent == 1.0 ? other.factor : exponent == -1.0 ? 1.0 / other.factor : std::pow(other.factor, exponent);
    for (std::size_t k = 0; k < powers.size(); ++k) powers[k] += exponent * other.powers[k];
  }
};

constexpr std::array<double, 3> length{1, 0, 0}, time{0, 1, 0}, mass{0, 0, 1}, force{1, -2, 1}, stress{-1, -2, 1};
constexpr std::pair<std::string_view, Size> whole[] = {{"%", {0.01, {}}},
                                                       {"min", {60.0, time}},
                                                       {"h", {3600.0, time}},
                                                       {"sec", {1, time}},
                                                       {"seconds", {1, time}},
                                                       {"in", {0.0254, length}},
                                                       {"ft", {0.3048, length}},
                                                       {"t", {1e3, mass}},
                                                       {"lbf", {4.4482216152605, force}},
                                                       {"psi", {6894.757293168361, stress}}};
constexpr std::pair<std::string_view, Size> with_prefix[] = {
    {"Pa", {1, stress}}, {"s", {1, time}}, {"m", {1, length}}, {"N", {1, force}}, {"g", {1e-3, mass}}};
constexpr std::pair<std::string_view, double> prefixes[] = {
    {"", 1.0},   {"k", 1e3},         {"M", 1e6},         {"G", 1e9},     {"c", 1e-2}, {"m", 1e-3},
    {"u", 1e-6}, {"\xc2\xb5", 1e-6}, {"\xce\xbc", 1e-6}, {"\xb5", 1e-6}, {"n", 1e-9}};

std::optional<Size> size_of_name(std::string_view name) {
  for (const auto& [known, size] : whole)
    if (name == known) return size;
  for (const auto& [known, size] : with_prefix)
    for (const auto& [prefix, times] : prefixes)
      if (name.ends_with(known) && name.substr(0, name.size() - known.size()) == prefix)
        return Size{times * size.factor, size.powers};
  return std::nullopt;
}

/// Reads "N s/(m^2 kg)", "m/s2", "kg m² s^-2": what follows a "/" up to the next mark divides, and so does all
/// of a parenthesis after it. Signs beyond ASCII may be in UTF-8 or, as instruments write them, in Latin-1.
class Reader {
 public:
  explicit Reader(std::string_view text) : rest_(text) {}

  std::optional<Size> all() {
    const auto size = product();
    return rest_.empty() ? size : std::nullopt;
  }

 private:
  bool skip(std::string_view mark) {
    if (!rest_.starts_with(mark)) return false;
    rest_.remove_prefix(mark.size());
    return true;
  }

  std::optional<double> exponent() {
    if (skip("\xc2\xb2") || skip("\xb2")) return 2.0;
    if (skip("\xc2\xb3") || skip("\xb3")) return 3.0;
    const bool marked = skip("^");
    double value = 1.0;
    const auto [end, error] =
        std::from_chars(rest_.data(), rest_.data() + rest_.size(), value, std::chars_format::fixed);
    if (error != std::errc() && marked) return std::nullopt;
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return value;
  }

  std::optional<Size> name() {
    const std::size_t micro = rest_.starts_with("\xc2\xb5") ? 2 : 0;
    const std::string_view text =
        rest_.substr(0, std::min(rest_.find_first_of(" */().^-0123456789\xc2\xb2\xb3\xb7", micro), rest_.size()));
    rest_.remove_prefix(text.size());
    return size_of_name(text);
  }

  std::optional<Size> factor() {
    if (skip("1")) return Size{};
    const bool inner = skip("(");
    const auto base = inner ? product() : name();
    if (!base || (inner && !skip(")"))) return std::nullopt;
    const auto power = exponent();
    if (!power) return std::nullopt;
    Size all;
    all.multiply_by(*base, *power);
    return all;
  }

  std::optional<Size> product() {
    Size all;
    double sign = 1.0;
    while (true) {
      const auto next = factor();
      if (!next) return std::nullopt;
      all.multiply_by(*next, sign);
      sign = 1.0;
      if (skip("/"))
        sign = -1.0;
      else if (!skip("*") && !skip("\xc2\xb7") && !skip("\xb7") && !skip(" "))
        return all;
    }
  }

  std::string_view rest_;
};

}  // namespace

std::optional<double> unit_ratio(std::string_view from, std::string_view to) {
  if (from == to) return 1.0;
  const auto size = Reader(from).all(), wanted = Reader(to).all();
  if (!size || !wanted || size->powers != wanted->powers) return std::nullopt;
  return size->factor / wanted->factor;
}

}  // namespace viscobar
