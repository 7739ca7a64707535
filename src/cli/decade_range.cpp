#include "cli/decade_range.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "viscobar/analysis/penalty_limit.hpp"

namespace viscobar::cli {

double DecadeRange::number(const std::string& word) const {
  std::size_t read = 0;
  double value = 0.0;
  try {
    value = std::stod(word, &read);
  } catch (const std::logic_error&) {
    read = 0;
  }
  if (read == 0 || read != word.size() || !(value >= low && value <= high))
    throw std::invalid_argument(fmt::format("{}: \"{}\" is not {}; write {}", option, word, expected, example));
  return value;
}

std::vector<double> DecadeRange::operator()(const std::string& text, std::size_t per_decade) const {
  const std::size_t colon = text.find(':');
  const double a = number(text.substr(0, colon));
  const double b = colon == std::string::npos ? a : number(text.substr(colon + 1));
  return decades(std::max(a, b), std::min(a, b), per_decade);
}

}  // namespace viscobar::cli
