#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace viscobar::cli {

/// What "1e-2:1e-8", or one value, means to an option: numbers within [low, high], the larger first, `per_decade` in a
/// decade. @throws std::invalid_argument that names the option and says with `expected` what its numbers are
struct DecadeRange {
  std::string_view option, expected, example;
  double low, high;

  std::vector<double> operator()(const std::string& text, std::size_t per_decade = 1) const;

 private:
  double number(const std::string& word) const;
};

}  // namespace viscobar::cli
