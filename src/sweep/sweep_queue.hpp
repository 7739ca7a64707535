#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

/// Hands out cases of a sweep, the dearest first.
class SweepQueue {
 public:
  /// `costs` of all cases; `to_run` says which of them; empty: all.
  SweepQueue(const SweepFile& sweep, std::span<const double> costs, const std::vector<bool>& to_run = {});

  /// To run now; absent: none is left.
  std::optional<SweepCase> take();

  std::size_t size() const { return left_.size(); }
  double seconds() const;

 private:
  const SweepFile& sweep_;
  std::span<const double> costs_;
  std::deque<std::size_t> left_;
};

}  // namespace viscobar
