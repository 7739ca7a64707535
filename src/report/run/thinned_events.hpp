#pragma once

#include <cstddef>
#include <vector>

#include "viscobar/run/run.hpp"

namespace viscobar {

/// Contact changes as far as a page can mark them: all while they are no more than 2000; beyond, of every 2^k in a row
/// the fastest one, k growing with their number.
class ThinnedEvents {
 public:
  void add(const Event& event);

  const std::vector<Event>& events() const { return kept_; }
  /// 2^k
  std::size_t stride() const { return stride_; }

  static void members(auto& self, auto&& each) { each(self.kept_, self.stride_, self.in_last_); }

 private:
  static constexpr std::size_t most = 2000;
  std::vector<Event> kept_;
  std::size_t stride_ = 1, in_last_ = 0;
};

}  // namespace viscobar
