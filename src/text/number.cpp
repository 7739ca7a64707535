#include "text/number.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <limits>

namespace viscobar {

namespace {

void append(std::string& text, double value, std::chars_format format, int precision) {
  std::array<char, 350> room;  // the largest number has 309 digits before its point
  text.append(room.data(), std::to_chars(room.begin(), room.end(), value, format, precision).ptr);
}

}  // namespace

void append_digits(std::string& text, double value, int digits) {
  append(text, value, std::chars_format::general, digits);
}

void append_thousandths(std::string& text, double value) {
  constexpr double most = 1e12;  // a whole number of thousandths below it is exact in a double
  if (!(std::abs(value) < most)) return append(text, value, std::chars_format::fixed, 0);
  auto rest = static_cast<std::uint64_t>(std::abs(value) * 1000.0 + 0.5);
  if (value < 0.0 && rest > 0) text += '-';
  std::array<char, 20> room;
  char *const end = room.data() + room.size(), *begin = end;
  int decimals = 3;
  for (; decimals > 0 && rest % 10 == 0; --decimals) rest /= 10;
  for (int place = 0; rest > 0 || place <= decimals; ++place, rest /= 10) {
    if (place == decimals && decimals > 0) *--begin = '.';
    *--begin = static_cast<char>('0' + rest % 10);
  }
  text.append(begin, end);
}

std::string with_true_minus(std::string text) { return text.starts_with('-') ? "\u2212" + text.substr(1) : text; }

std::string power_of_ten(int exponent) {
  static constexpr const char* digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "10⁻" : "10";
  for (const char digit : fmt::format("{}", std::abs(exponent))) text += digits[digit - '0'];
  return text;
}

std::string readable(double value, int digits) {
  const double size = std::abs(value);
  if (value == 0.0) return "0";
  if (!std::isfinite(value)) return fmt::format("{}", value);
  if (size >= 1e-3 && size < 1e5) {
    const std::string plain = fmt::format("{:.{}g}", value, std::max(digits, static_cast<int>(std::log10(size)) + 1));
    return with_true_minus(plain);
  }
  const std::string scientific = fmt::format("{:.{}e}", value, digits - 1);
  const std::size_t at = scientific.find('e');
  std::string mantissa = scientific.substr(0, at);
  while (mantissa.ends_with('0')) mantissa.pop_back();
  if (mantissa.ends_with('.')) mantissa.pop_back();
  const std::string power = power_of_ten(std::stoi(scientific.substr(at + 1)));
  if (mantissa == "1") return power;
  return with_true_minus(mantissa) + "\u202f×\u202f" + power;
}

double above_rounding(double value, double size) {
  constexpr double roundings = 256.0 * std::numeric_limits<double>::epsilon();
  return std::abs(value) <= roundings * size ? 0.0 : value;
}

std::string with_readable_numbers(std::string_view sentence) {
  std::string text;
  const auto digit = [&](std::size_t i) { return i < sentence.size() && sentence[i] >= '0' && sentence[i] <= '9'; };
  for (std::size_t i = 0; i < sentence.size();) {
    const std::string_view rest = sentence.substr(i);
    const char before = i > 0 ? sentence[i - 1] : ' ';
    const bool inside = std::isalnum(static_cast<unsigned char>(before)) || before == '_' || before == '.';
    if (rest.starts_with("+- ")) {
      text += "±";
      i += 2;
      continue;
    }
    if (constexpr std::string_view word = "epsilon"; !inside && before != '-' && rest.starts_with(word)) {
      const std::size_t end = word.size() + (rest.substr(word.size()).starts_with('s') ? 1 : 0);
      if (end == rest.size() || (!std::isalnum(static_cast<unsigned char>(rest[end])) && rest[end] != '_')) {
        text += "ε";
        i += end;
        continue;
      }
    }
    double value = 0.0;
    const auto [stop, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    const std::string_view number(rest.data(), static_cast<std::size_t>(stop - rest.data()));
    const std::size_t mark = number.find('e');
    if (!inside && digit(i) && error == std::errc{} && mark != number.npos) {
      const auto digits =
          static_cast<int>(std::ranges::count_if(number.substr(0, mark), [](char c) { return c != '.'; }));
      text += readable(value, digits);
      i += number.size();
    } else {
      text += sentence[i++];
    }
  }
  return text;
}

std::string counted(std::size_t number, std::string_view what) {
  const std::size_t word = std::min(what.find(' '), what.size());
  return fmt::format("{} {}{}{}", number, what.substr(0, word), number == 1 ? "" : "s", what.substr(word));
}

std::string ordinal(std::size_t number) {
  const std::size_t last = number % 10;
  const bool teen = number / 10 % 10 == 1;
  return fmt::format("{}{}", number, teen || last == 0 || last > 3 ? "th" : last == 1 ? "st" : last == 2 ? "nd" : "rd");
}

}  // namespace viscobar
