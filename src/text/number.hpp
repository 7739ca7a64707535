#pragma once

#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace viscobar {

/// The number that the whole text is; absent where it is none, or something follows it.
template <class Number>
std::optional<Number> number_in(std::string_view text) {
  Number value{};
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && rest == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

/// Appends a finite number with so many significant digits, as fmt's "{:.{}g}", in less time.
void append_digits(std::string& text, double value, int digits);
/// Appends the nearest multiple of 1/1000 in its shortest form. A page has some ten thousand of them.
void append_thousandths(std::string& text, double value);

/// A number for people: a few digits, with a true minus sign; 1.2 x 10^k where it is very large or small.
std::string readable(double value, int digits = 4);

/// 0 for a value that is rounding beside numbers of that size.
double above_rounding(double value, double size);

/// A sentence as pages write it: numbers such as 1.2e-05 by readable(), +- as one sign, epsilon, but in keys and
/// options, as its letter.
std::string with_readable_numbers(std::string_view sentence);

std::string power_of_ten(int exponent);

/// 1st, 2nd, 3rd, 4th, ..., 11th, ..., 21st
std::string ordinal(std::size_t number);

/// 1 line, 2 lines, 2 lines of comments: the first word is in the plural.
std::string counted(std::size_t number, std::string_view what);

/// The text of a number with a true minus sign for its hyphen.
std::string with_true_minus(std::string text);

}  // namespace viscobar
