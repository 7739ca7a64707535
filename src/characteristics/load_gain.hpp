#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "characteristics/piecewise_fit.hpp"
#include "dynamics/finite_load.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar::characteristics {

/// Gain of waves from a load on their way through a bar: a wave that has come the way l, in lengths of the bar, to the
/// place x at the time tau, in passages, has gained
///
///     L / (rho c) int_0^l f(x -+ r, tau - r) dr.
///
/// It is told window by window, a passage being `delay` of them.
class LoadGain {
 public:
  /// Path of one wave.
  struct Way {
    double place, time, length;
    bool rightward;
  };

  /// Gain of waves that began at `start`, or before it without a load, in a run up to `end`. The load is a function of
  /// the place in the bar.
  static std::unique_ptr<LoadGain> of(const Load& load, const Bar& bar, double passage, double delay, double start,
                                      double end);
  virtual ~LoadGain() = default;
  LoadGain(const LoadGain&) = delete;
  LoadGain& operator=(const LoadGain&) = delete;

  /// True if gains are the same at all times, once waves have come from the other end: waves are then told without
  /// them, and gain at once when they arrive what they gain on the whole way.
  virtual bool steady() const { return false; }
  /// To be called for window after window; a run that goes on in one recalls those of the passage before it first.
  void enter(std::size_t window);
  void recall(std::size_t window);
  /// Gains of the waves that arrive in the present window at the right end, and at the left.
  const Piecewise& arriving_right() const { return arriving_right_; }
  const Piecewise& arriving_left() const { return arriving_left_; }
  /// Computes the gains of waves under way at s of the present window, by place. Valid until the next call.
  virtual void look(double s);
  const Piecewise& rightward() const { return rightward_; }
  const Piecewise& leftward() const { return leftward_; }

  /// The memory that goes on with a run: approximation errors, as velocities, the sum over the passages entered, a
  /// window's part counting for its part of one, and the largest that was looked at; the largest load and slope that
  /// arrivals met.
  struct Memory {
    double arrivals = 0.0, looked_at = 0.0, largest = 0.0, steepest = 0.0;
    static void members(auto& memory, auto&& each) {
      each(memory.arrivals, memory.looked_at, memory.largest, memory.steepest);
    }
  };
  /// Evaluations for one output or window where the load is rough.
  std::size_t most_rough = 20'000'000;
  Memory memory;  ///< to be set where a run goes on from a checkpoint
  std::size_t evaluations() const { return evaluations_; }

 protected:
  explicit LoadGain(double delay) : delay_(delay) {}
  virtual void prepare() {}  // takes the terms that depend on the window only
  virtual double gain(const Way& way) = 0;
  virtual double size() const { return 0.0; }                    // of what gains are sums of
  virtual std::span<const double> places() const { return {}; }  // where the load breaks in x,
  virtual std::span<const double> times() const { return {}; }   // and in time, in passages
  virtual void arrivals();

  const Piecewise& represented(const std::function<double(double)>& f);
  void add_break(double s);
  double time(double s) const { return (static_cast<double>(window_) + s) / delay_; }  // of the present window

  double delay_;
  std::size_t window_ = 0;
  Piecewise arriving_right_, arriving_left_, rightward_, leftward_;
  PiecewiseFit fit_;
  std::vector<double> breaks_;
  std::size_t evaluations_ = 0;  // of the load itself
};

inline constexpr double sums = 8.0;  // roundings that a sum of some dozens of terms adds up

// The bar, in lengths of it and in passages.
struct Frame {
  double length, passage, delay, start, factor;  // factor: L / (rho c)
  double x(double place) const { return length * place; }
  double t(double time) const { return start + passage * time; }
};

// Breaks of a load in time, in passages, of the present window and the passage before. Those that are not `sharp` show
// where it is quick, in cells: of these a sixteenth is enough, since an integral looks at more places than cells.
class Breaks {
 public:
  Breaks(NextBreak next, const Frame& frame, std::optional<NextBreak> sharp = {})
      : next_(std::move(next)), sharp_(std::move(sharp)), frame_(frame) {}

  void enter(std::size_t window) {
    find(window);
    if (sharp_) thin();
  }
  std::span<const double> times() const { return sharp_ ? kept_ : times_; }

 private:
  static constexpr std::size_t most_breaks = 10'000;  // of a load, in one window

  void find(std::size_t window) {
    const auto first = static_cast<double>(window);
    const double begin = first / frame_.delay;
    std::erase_if(times_, [&](double time) { return time < begin - 1.0; });
    if (window == 0) times_.push_back(0.0);  // there the load begins
    if (!next_) return;
    const double until = frame_.t((first + 1.0) / frame_.delay);
    const double apart = 64.0 * rounding * std::max(std::abs(until), std::abs(frame_.start));
    double after = frame_.t(begin) - (window == 0 ? 0.0 : apart);
    for (std::size_t count = 0;; ++count) {
      const std::optional<double> at = next_(after, until);
      if (!at) return;
      if (count == most_breaks)
        throw LoadError(
            *at, fmt::format("the load breaks more than {} times while a wave crosses the shortest bar", most_breaks));
      after = *at + apart;
      const double time = (*at - frame_.start) / frame_.passage;
      if (times_.empty() || time > times_.back()) times_.push_back(time);
    }
  }

  void thin() {
    constexpr std::size_t cells = 16;
    kept_.clear();
    std::size_t passed = 0;
    for (std::size_t k = 0; k < times_.size(); ++k) {
      const double before = k > 0 ? times_[k] - times_[k - 1] : 0.0,
                   behind = k + 1 < times_.size() ? times_[k + 1] - times_[k] : 0.0;
      const bool inner = before < 4.0 * behind && behind < 4.0 * before;
      if (inner && ++passed < cells && !is_sharp(times_[k])) continue;
      passed = 0;
      kept_.push_back(times_[k]);
    }
  }
  bool is_sharp(double time) const {
    const double t = frame_.t(time), apart = 1e-12 * (std::abs(t) + frame_.passage);
    return *sharp_ && (*sharp_)(t - apart, t + apart).has_value();
  }

  NextBreak next_;
  std::optional<NextBreak> sharp_;
  Frame frame_;
  std::vector<double> times_, kept_;
};

// Gain from a load known by its values alone, in a run of so many passages.
std::unique_ptr<LoadGain> general_gain(const GeneralLoad& load, const Frame& frame, double passages);

}  // namespace viscobar::characteristics
