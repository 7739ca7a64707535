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

/// Runs bars side by side, by (2.8). With a wanted error a bar runs with n and 2n steps, and then with as many as its
/// error seems to ask for; without one it runs once.
class LaneLevels {
 public:
  /// All outlive it. `tell` is given the bars that are done, `alone` those that must run by themselves.
  LaneLevels(const Members& members, const Layout& layout, const Shared& shared, const std::function<bool()>& stop,
             std::function<void(std::size_t bar, Told)> tell, std::function<void(std::size_t bar)> alone);

  void add(std::size_t bar, OwnMember own);
  /// Runs the bars added. @throws StudyStopped
  void run();

 private:
  // Levels have n, 2 n, 3 n, 4 n, 5 n, 6 n, 7 n, 8 n, 10 n, 12 n, ... steps, n a period of the layout; without a
  // request there is one level, that of the scene.
  static constexpr std::size_t most_level = 40;

  struct Waiting {
    std::size_t bar;
    OwnMember own;
    // The finest run so far, its level, and its error in second order as it and the run before tell.
    std::unique_ptr<BarValues> coarse{};
    std::size_t coarse_level = 0;
    std::optional<double> error{};
  };

  static std::size_t multiple(std::size_t level);
  double step_at(std::size_t level) const;
  std::size_t steps_at(std::size_t level) const;
  bool meets_outputs(std::size_t level) const;
  double ways(const Bar& bar) const;  // that a wave takes through it until the end
  std::size_t level_of(double steps) const;
  std::size_t first_level(const Bar& bar) const;
  bool is_of_rigid(const Member& bar) const;
  std::vector<std::unique_ptr<BarValues>> run_pack(std::span<const Waiting> pack, std::size_t level);
  void look(std::span<const Waiting> pack, const LaneSample& at);
  void told(std::size_t bar, std::size_t lane, std::unique_ptr<BarValues> values, double error, std::size_t level);
  void judge(Waiting bar, std::size_t lane, std::unique_ptr<BarValues> fine, std::size_t level);

  const Members& members_;
  const Layout& layout_;
  const Shared& shared_;
  const std::function<bool()>& stop_;
  std::function<void(std::size_t, Told)> tell_;
  std::function<void(std::size_t)> alone_;
  LaneScheme scheme_;
  double finest_ = 1.0;                                       // the smallest element over the bar's length
  std::array<std::vector<Waiting>, most_level + 1> waiting_;  // of each level

  // The values of the bars of the pack that ran last, and what tells their error.
  std::vector<Lanes> values_;
  std::array<std::array<Lanes, BarValues::probes>, 2> ends_{}, ways_{};  // of LaneSample
  Lanes largest_;
  LaneAccounts accounts_;
  std::size_t next_look_ = 0;
  std::vector<double> u_, v_, reading_;  // of one bar, where all of its nodes are looked at
};

}  // namespace viscobar::bars
