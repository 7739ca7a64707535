#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace viscobar {

struct Match {
  std::size_t first = 0, other = 0;
};

/// Pairs up two ascending lists of times, in order and each at most once, such that
///
///     sum over pairs (reach - |t_first - t_other|)
///
/// is largest. One time that is missing from a list therefore leaves its partner alone and does not shift the pairs
/// after it, while a drift below `reach` is followed. Considers the 64 neighbours on either side of the nearest time.
std::vector<Match> match_times(std::span<const double> first, std::span<const double> other, double reach);

}  // namespace viscobar
