#include "studies/compare/matching.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace viscobar {

std::vector<Match> match_times(std::span<const double> first, std::span<const double> other, double reach) {
  constexpr std::size_t neighbours = 64;
  // A pair, the weight of the best chain that ends with it, and the pair before it in that chain.
  struct Link {
    Match match;
    double weight;
    std::optional<std::size_t> before;
  };
  std::vector<Link> links;
  const auto heavier = [&](std::optional<std::size_t> a, std::optional<std::size_t> b) {
    if (!a || !b) return a ? a : b;
    return links[*b].weight > links[*a].weight ? b : a;
  };
  std::vector<std::optional<std::size_t>> best(other.size());  // of the chains so far that end with each of `other`
  std::optional<std::size_t> passed;                           // of those that end before `begin`
  std::size_t begin = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const auto nearest = static_cast<std::size_t>(std::ranges::lower_bound(other, first[i]) - other.begin());
    for (; begin + neighbours < nearest; ++begin) passed = heavier(best[begin], passed);
    auto before = passed;
    for (std::size_t j = begin; j < std::min(other.size(), nearest + neighbours); ++j) {
      const auto ends_here = best[j];
      if (const double gain = reach - std::abs(first[i] - other[j]); gain > 0.0) {
        links.push_back({{i, j}, gain + (before ? links[*before].weight : 0.0), before});
        best[j] = heavier(ends_here, links.size() - 1);
      }
      before = heavier(ends_here, before);
    }
  }
  for (; begin < other.size(); ++begin) passed = heavier(best[begin], passed);
  std::vector<Match> matches;
  for (auto link = passed; link; link = links[*link].before) matches.push_back(links[*link].match);
  std::ranges::reverse(matches);
  return matches;
}

}  // namespace viscobar
