#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <span>

#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

/// Hands out the cases of a sweep that have no row yet, the dearest first.
class SweepQueue {
 public:
  /// `costs` of all cases; `finished` are rows from before.
  SweepQueue(const SweepFile& sweep, std::span<const double> costs, std::span<const SweepRow* const> finished = {});

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
