#pragma once

#include <cstddef>
#include <string>

namespace viscobar {

/// A number for people: a few digits, with a true minus sign; 1.2 x 10^k where it is very large or small.
std::string readable(double value, int digits = 4);

/// 10^exponent
std::string power_of_ten(int exponent);

/// 1st, 2nd, 3rd, 4th, ..., 11th, ..., 21st
std::string ordinal(std::size_t number);

/// The text of a number with a true minus sign for its hyphen.
std::string with_true_minus(std::string text);

}  // namespace viscobar
