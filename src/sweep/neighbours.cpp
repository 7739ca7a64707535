#include "sweep/neighbours.hpp"

#include <algorithm>
#include <map>
#include <string>
#include <variant>

namespace viscobar {

namespace {

// True if cases with different values of it need meshes that tell nothing of each other: a method, a mass, a formula,
// an error.
bool divides(const VariedKey& key) {
  return std::holds_alternative<std::vector<std::string>>(key.values) || key.key.starts_with("accuracy.");
}

}  // namespace

std::vector<std::optional<std::size_t>> neighbours(const SweepPlan& plan) {
  constexpr std::size_t most_together = 8, least_alone = 16;
  const std::size_t cases = plan.size(), together = std::min(most_together, cases / least_alone);
  std::vector<std::optional<std::size_t>> result(cases);
  if (!plan.accuracy || together < 2) return result;
  std::map<std::vector<std::size_t>, std::vector<std::size_t>> alike;
  for (std::size_t i = 0; i < cases; ++i) {
    std::vector<std::size_t> choice = plan.choice(i);
    for (std::size_t k = 0; k < choice.size(); ++k)
      if (!divides(plan.keys[k])) choice[k] = 0;
    alike[choice].push_back(i);
  }
  for (const auto& [choice, list] : alike)
    for (std::size_t begin = 0; begin < list.size(); begin += together) {
      const std::size_t end = std::min(begin + together, list.size()), middle = (begin + end) / 2;
      for (std::size_t k = begin; k < end; ++k)
        if (k != middle) result[list[k]] = list[middle];
    }
  return result;
}

}  // namespace viscobar
