#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "characteristics/piecewise_fit.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar::characteristics {

/// What waves gain from a load on their way through the bar: a wave that has come the way l, in lengths of the bar, to
/// the place x at the time tau, in passages, has gained
///
///     L / (rho c) int_0^l f(x -+ r, tau - r) dr.
class LoadGain {
 public:
  /// Of one wave on its way.
  struct Way {
    double place, time, length;
    bool rightward;
  };

  /// Of waves that began at passage 0, at `start`, or before it without a load, in a run up to `end`.
  static std::unique_ptr<LoadGain> of(const Load& load, const Bar& bar, double passage, double start, double end);
  virtual ~LoadGain() = default;
  LoadGain(const LoadGain&) = delete;
  LoadGain& operator=(const LoadGain&) = delete;

  /// Whether gains are the same at all times, once waves have come from the other end: waves are then told without
  /// them, and gain at once when they arrive what they gain on the whole way.
  virtual bool steady() const { return false; }
  /// To be called for passage after passage, or passage k - 1 before passage k.
  void enter(std::size_t passage);
  /// Of what arrives in the present passage at the right end, and at the left.
  const Piecewise& arriving_right() const { return arriving_right_; }
  const Piecewise& arriving_left() const { return arriving_left_; }
  /// Of what is on its way at s of the present passage, by place. Valid until the next call.
  virtual void look(double s);
  const Piecewise& rightward() const { return rightward_; }
  const Piecewise& leftward() const { return leftward_; }

  /// Of the representations, as velocities: the sum over the passages entered, and the largest that was looked at.
  struct Errors {
    double arrivals = 0.0, looked_at = 0.0;
    static void members(auto& errors, auto&& each) { each(errors.arrivals, errors.looked_at); }
  };
  const Errors& errors() const { return errors_; }
  void restore(const Errors& errors) { errors_ = errors; }
  std::size_t evaluations() const { return evaluations_; }

 protected:
  LoadGain() = default;
  virtual void prepare(std::size_t) {}  // what depends on the passage only
  virtual double gain(const Way& way) = 0;
  virtual double size() const { return 0.0; }                    // of what gains are sums of
  virtual std::span<const double> places() const { return {}; }  // where the load breaks in x,
  virtual std::span<const double> times() const { return {}; }   // and in time, in passages
  virtual void arrivals();

  const Piecewise& represented(const std::function<double(double)>& f);
  void add_break(double s);

  std::size_t passage_ = 0;
  Piecewise arriving_right_, arriving_left_, rightward_, leftward_;
  PiecewiseFit fit_;
  std::vector<double> breaks_;
  Errors errors_;
  std::size_t evaluations_ = 0;  // of the load itself
};

}  // namespace viscobar::characteristics
