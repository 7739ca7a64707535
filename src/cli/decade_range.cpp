#include "cli/decade_range.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "viscobar/studies/limit/limit.hpp"

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
  constexpr double most = 1000.0;  // of runs, each with its own
  const double count = std::log10(std::max(a, b) / std::min(a, b)) * static_cast<double>(per_decade);
  if (!(count < most))
    throw std::invalid_argument(fmt::format("{}: \"{}\" gives {:.0f} values, at most {:.0f} are taken", option, text,
                                            std::min(count, 1e9), most));
  return decades(std::max(a, b), std::min(a, b), per_decade);
}

}  // namespace viscobar::cli
