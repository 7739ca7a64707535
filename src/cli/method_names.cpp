#include "cli/method_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "text/nearest_name.hpp"

namespace viscobar::cli {

std::vector<MethodName> methods_named(const std::vector<std::string>& words) {
  std::vector<std::string> known;
  for (const MethodName method : all_methods) known.emplace_back(name(method));
  std::vector<MethodName> methods;
  for (const std::string& word : words) {
    const auto found = std::find(known.begin(), known.end(), word);
    if (found == known.end()) {
      const auto nearest = nearest_name(word, known);
      throw std::invalid_argument(fmt::format(
          "--methods: there is no method \"{}\"{}", word,
          nearest ? fmt::format("; did you mean {}?", *nearest) : fmt::format(", only {}", fmt::join(known, ", "))));
    }
    methods.push_back(all_methods[found - known.begin()]);
  }
  return methods;
}

}  // namespace viscobar::cli
