#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "studies/ensemble/alone.hpp"
#include "studies/ensemble/members.hpp"

namespace viscobar::bars {

/// The settings that the bars of an ensemble share.
struct Shared {
  double end, step;  ///< of the scene's scheme
  Start start;
  std::size_t elements;
  std::optional<double> error;
  bool rigid_beside;  ///< a bar that wants too many steps may run by `rigid`
};

/// Runs bars side by side, by (2.8). With a wanted error a bar runs on levels of 2^k steps, and is judged by the last
/// two or three of them; without one it runs once.
class LaneLevels {
 public:
  /// All outlive it. `tell` is given the bars that are done, `alone` those that must run by themselves.
  LaneLevels(const Members& members, const Layout& layout, const Shared& shared, const std::function<bool()>& stop,
             std::function<void(std::size_t bar, Told)> tell, std::function<void(std::size_t bar)> alone);

  void add(std::size_t bar, OwnMember own);
  /// Runs the bars added. @throws Stopped
  void run();

 private:
  // Steps double from level to level; level 0 has that of the scene, without a request.
  static constexpr std::size_t base_steps = 16, most_level = 11;

  struct Waiting {
    std::size_t bar;
    OwnMember own;
    std::unique_ptr<BarValues> coarse{};
    std::size_t coarse_level = 0;
    // How far the last two runs differ, and the order that three of neighbouring levels show.
    std::optional<double> difference{};
    std::optional<double> order{};
  };

  std::size_t steps_at(std::size_t level) const;
  double step_at(std::size_t level) const;
  std::size_t first_level(const Bar& bar) const;
  std::vector<std::unique_ptr<BarValues>> run_pack(std::span<const Waiting> pack, std::size_t level);
  void judge(Waiting bar, std::unique_ptr<BarValues> fine, std::size_t level);

  const Members& members_;
  const Layout& layout_;
  const Shared& shared_;
  const std::function<bool()>& stop_;
  std::function<void(std::size_t, Told)> tell_;
  std::function<void(std::size_t)> alone_;
  LaneScheme scheme_;
  std::array<std::vector<Waiting>, most_level + 1> waiting_;  // of each level
};

}  // namespace viscobar::bars
