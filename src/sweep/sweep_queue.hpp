#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

/// Hands out the cases of a sweep that have no row yet: those that wait for nobody first, and of these the dearest. A
/// case waits for the row of its neighbour, whose settings its search begins with.
class SweepQueue {
 public:
  /// `costs` of all cases; `finished` are rows from before.
  SweepQueue(const SweepFile& sweep, std::span<const double> costs, std::span<const SweepRow* const> finished = {});

  /// To run now. Absent: none is left, or all that are left wait for cases that are under way.
  std::optional<SweepCase> take();
  void finish(const SweepRow& row);

  /// Cases that have not been handed out.
  std::size_t size() const { return left_.size(); }
  /// Estimated seconds of these cases.
  double seconds() const;

 private:
  const SweepFile& sweep_;
  std::span<const double> costs_;
  std::vector<std::optional<std::size_t>> neighbours_;
  std::vector<bool> finished_;
  std::vector<std::optional<AccuracyStart>> starts_;  // of finished cases, for their neighbours
  std::deque<std::size_t> left_;
};

}  // namespace viscobar
