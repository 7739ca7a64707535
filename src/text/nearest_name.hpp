#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace viscobar {

/// Number of insertions, deletions, replacements and exchanges of neighbours that turn `a` into `b` (optimal string
/// alignment).
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last, last, row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before_last = last;
    last = row;
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
  }
  return row[b.size()];
}

/// A name as names are compared: in lower case, blanks around it left out, - and inner blanks as _.
inline std::string plain_name(std::string_view name) {
  while (!name.empty() && name.front() == ' ') name.remove_prefix(1);
  while (!name.empty() && name.back() == ' ') name.remove_suffix(1);
  std::string plain(name);
  for (char& c : plain) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (c == '-' || c == ' ') c = '_';
  }
  return plain;
}

/// The candidate that `name` was probably meant to be: the one at the smallest distance, if no more than about a third
/// of the letters differ. The first of several at the same distance.
template <class Names>
std::optional<std::string_view> nearest_name(std::string_view name, const Names& candidates) {
  constexpr std::size_t longest = 64;  // no name of ours is longer; keeps the cost bounded
  if (name.size() > longest) return std::nullopt;
  const std::string wanted = plain_name(name);
  std::optional<std::string_view> nearest;
  std::size_t smallest = longest;
  for (const std::string_view candidate : candidates) {
    const auto [shorter, longer] = std::minmax({wanted.size(), candidate.size()});
    const std::size_t fewer_than = std::min(smallest, (longer + 2) / 3 + 1);
    if (longer - shorter >= fewer_than) continue;  // so many insertions at least
    const std::size_t distance = edit_distance(wanted, plain_name(candidate));
    if (distance < fewer_than) {
      smallest = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

}  // namespace viscobar
