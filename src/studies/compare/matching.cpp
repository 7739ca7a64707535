#include "studies/compare/matching.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace viscobar {

namespace {

// A pair, the weight of the best chain that ends with it, and the pair before it in that chain.
struct Link {
  Match match;
  double weight = 0.0;
  std::optional<std::size_t> before;
};

// Heaviest chain that ends in one of the first j columns, for every j: a Fenwick tree of maxima.
class HeaviestChains {
 public:
  HeaviestChains(const std::vector<Link>& links, std::size_t columns) : links_(links), best_(columns + 1) {}

  std::optional<std::size_t> before(std::size_t column) const {
    std::optional<std::size_t> found;
    for (std::size_t i = column; i > 0; i -= i & -i) found = heavier(found, best_[i]);
    return found;
  }

  void add(std::size_t column, std::size_t link) {
    for (std::size_t i = column + 1; i < best_.size(); i += i & -i) best_[i] = heavier(best_[i], link);
  }

 private:
  std::optional<std::size_t> heavier(std::optional<std::size_t> a, std::optional<std::size_t> b) const {
    if (!a || !b) return a ? a : b;
    return links_[*b].weight > links_[*a].weight ? b : a;
  }

  const std::vector<Link>& links_;
  std::vector<std::optional<std::size_t>> best_;
};

}  // namespace

std::vector<Match> match_times(std::span<const double> first, std::span<const double> other, double reach) {
  constexpr std::ptrdiff_t neighbours = 64;
  std::vector<Link> links;
  HeaviestChains chains(links, other.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    const auto nearest = std::lower_bound(other.begin(), other.end(), first[i]) - other.begin();
    const auto begin = std::max<std::ptrdiff_t>(0, nearest - neighbours);
    const auto end = std::min(std::ssize(other), nearest + neighbours);
    const std::size_t row = links.size();
    for (auto j = static_cast<std::size_t>(begin); j < static_cast<std::size_t>(end); ++j) {
      const double gain = reach - std::abs(first[i] - other[j]);
      if (gain <= 0.0) continue;
      const auto before = chains.before(j);
      links.push_back({{i, j}, gain + (before ? links[*before].weight : 0.0), before});
    }
    for (std::size_t k = row; k < links.size(); ++k) chains.add(links[k].match.other, k);
  }
  std::vector<Match> matches;
  for (auto link = chains.before(other.size()); link; link = links[*link].before) matches.push_back(links[*link].match);
  std::reverse(matches.begin(), matches.end());
  return matches;
}

}  // namespace viscobar
