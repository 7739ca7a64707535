#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "characteristics/piecewise.hpp"

namespace viscobar::characteristics {

/// A way of waves through a bar: a face sends them, and after the delay D, in windows, they arrive at the other face.
/// Since 1 <= D, all that arrives in a window was sent before it. Where D is n windows to rounding, the n-th window
/// arrives as it was sent, and a break bit for bit where it was; else the ends of two windows make one.
class DelayLine {
 public:
  explicit DelayLine(double delay) : delay_(delay), whole_(std::floor(delay)), part_(delay - whole_) {
    constexpr double roundings = 16.0 * rounding;
    if (std::abs(delay - std::round(delay)) <= roundings * delay) delay_ = whole_ = std::round(delay), part_ = 0.0;
    windows_.resize(static_cast<std::size_t>(whole_) + (part_ > 0.0 ? 1 : 0));
  }

  double delay() const { return delay_; }
  /// The waves sent j windows ago, 1 <= j <= windows().
  const Piecewise& before(std::size_t j) const { return windows_[(newest_ + j - 1) % windows_.size()]; }
  std::size_t windows() const { return windows_.size(); }

  /// The waves on their way at the beginning of a window, by the part of the way that they have ahead.
  void fill(const Piecewise& wave) {
    if (delay_ == 1.0) {
      windows_[0] = wave;
      return;
    }
    for (std::size_t j = 1; j <= windows_.size(); ++j) {
      Piecewise& window = windows_[j - 1];
      const auto at = [&](double share) { return (share - 1.0) * delay_ + static_cast<double>(j); };
      window.clear();
      if (at(0.0) > 0.0) window.append(std::min(1.0, at(0.0)), 0.0, 1.0, Chebyshev::constant(0.0));  // never arrives
      for (std::size_t i = 0; i < wave.size(); ++i)
        if (const double end = std::min(1.0, at(wave[i].end)); end > window.end())
          window.append(end, at(wave[i].from()), at(wave[i].to()), wave.polynomial(i));
    }
  }

  /// The waves that arrive in this window; valid until the next call.
  const Piecewise& arriving() {
    if (part_ == 0.0) return before(windows_.size());
    arriving_.clear();
    const auto take = [&](const Piecewise& f, double shift, double until) {
      for (std::size_t i = 0; i < f.size(); ++i)
        if (const double end = i + 1 < f.size() ? std::min(until, f[i].end + shift) : until; end > arriving_.end())
          arriving_.append(end, f[i].from() + shift, f[i].to() + shift, f.polynomial(i));
    };
    take(before(windows_.size()), part_ - 1.0, part_);
    take(before(windows_.size() - 1), part_, 1.0);
    return arriving_;
  }

  /// A window has passed, in which that was sent.
  void leave(Piecewise& sent) {
    newest_ = (newest_ + windows_.size() - 1) % windows_.size();
    std::swap(windows_[newest_], sent);
  }

  static void members(auto& line, auto&& each) { each(line.windows_, line.newest_); }

 private:
  double delay_, whole_, part_;
  std::vector<Piecewise> windows_;
  std::size_t newest_ = 0;
  Piecewise arriving_;
};

/// A bar at one time, by place in lengths of it: the waves on their way through it, and what they have gained.
class Field {
 public:
  /// Waves of a way, of which those of this window, up to s, are with their sender.
  struct Sent {
    const DelayLine& line;
    const Piecewise& now;
  };
  /// `left` and `right` are the displacements of the ends, `transit` is L / c; gains are null without a load.
  Field(const Sent& rightward, const Sent& leftward, const Piecewise* rightward_gain, const Piecewise* leftward_gain,
        double s, double left, double right, double transit)
      : left_(left), transit_(transit), right_going_(rightward, s), left_going_(leftward, s) {
    if (rightward_gain) rightward_.emplace(*rightward_gain);
    if (leftward_gain) leftward_.emplace(*leftward_gain);
    whole_left_going_ = left_going_.integral(1.0);
    correction_ = right - displacement(1.0);
  }

  double rightward(double place) { return right_going_.value(place) + (rightward_ ? rightward_->value(place) : 0.0); }
  double leftward(double place) { return left_going_.value(1.0 - place) + (leftward_ ? leftward_->value(place) : 0.0); }
  double velocity(double place) { return 0.5 * (rightward(place) + leftward(place)); }
  /// From the left end by the strain; what it misses the right end by, a rounding, is spread over the bar.
  double displacement(double place) {
    double sum = whole_left_going_ - left_going_.integral(1.0 - place) - right_going_.integral(place);
    if (rightward_) sum -= rightward_->integral(place);
    if (leftward_) sum += leftward_->integral(place);
    return left_ + 0.5 * transit_ * sum + place * correction_;
  }

 private:
  // The wave that a face has sent, by the way that it has come, in lengths of the bar.
  class Train {
   public:
    Train(const Sent& sent, double s) : delay_(sent.line.delay()), s_(s) {
      windows_.emplace_back(sent.now);
      whole_.push_back(windows_[0].integral(s));
      for (std::size_t j = 1; j <= sent.line.windows(); ++j) {
        windows_.emplace_back(sent.line.before(j));
        whole_.push_back(whole_.back() + sent.line.before(j).integral());
      }
    }
    double value(double way) {
      const auto [window, at] = sent_at(way);
      return windows_[window].value(at);
    }
    double integral(double way) {
      const auto [window, at] = sent_at(way);
      return (whole_[window] - windows_[window].integral(at)) / delay_;
    }

   private:
    std::pair<std::size_t, double> sent_at(double way) const {
      const double ago = way * delay_;
      if (ago < s_) return {0, s_ - ago};
      const double window = std::clamp(std::ceil(ago - s_), 1.0, static_cast<double>(windows_.size() - 1));
      return {static_cast<std::size_t>(window), window + s_ - ago};
    }

    double delay_, s_;
    std::vector<Cursor> windows_;
    std::vector<double> whole_;  // integrals from the beginning of the window to now
  };

  double left_, transit_;
  Train right_going_, left_going_;
  std::optional<Cursor> rightward_, leftward_;
  double whole_left_going_ = 0.0, correction_ = 0.0;
};

}  // namespace viscobar::characteristics
