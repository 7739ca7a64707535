#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "integration/error_weights.hpp"
#include "integration/linear_form.hpp"
#include "integration/point_values.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// A method that makes steps on legs of constant contact states and a smooth load, and interpolates the last one by
/// polynomials. What it samples are the entries of (u, w) that begin_run() names.
class LegStepper {
 public:
  virtual ~LegStepper() = default;

  /// Once, before all else.
  virtual void begin_run(std::vector<std::size_t> sampled_entries) = 0;
  /// Begins a leg that ends at `stop`, in the state y at t, its massless entries completed.
  virtual void restart(double t, double stop, std::span<const double> y) = 0;
  /// Before each step: to begin anew where the last one asks for it.
  virtual void before_step() {}
  /// Makes a step towards the end of the leg. Returns the time reached.
  virtual double advance() = 0;

  /// Degree of the polynomials.
  virtual std::size_t order() const = 0;
  /// The sampled entries' derivatives (0: the values) at t, valid until the next call.
  virtual std::span<const double> sample(double t, int derivative) = 0;
  /// The same at order() + 1 equidistant times of the last step, from `begin` to `end`, entry by entry; entries that
  /// are at no position of these may be missing. Valid until the next call with that derivative.
  virtual std::span<const PointValues> samples(double begin, double end, int derivative,
                                               std::span<const std::size_t> positions) {
    return sample_points(begin, end, order(), positions, points_[derivative == 0 ? 0 : 1],
                         [&](std::size_t, double t) { return sample(t, derivative); });
  }
  /// The forms that form_samples() is asked for from now on.
  void take_forms(std::span<const LinearForm> forms);
  /// Each of them at order() + 1 equidistant times from `begin` to `end`, the last step or a part of it. Valid until
  /// the next call.
  virtual std::span<const PointValues> form_samples(double begin, double end) = 0;
  /// A contact changes in the state y within the last step: for a method whose steps are so long that its maxima have
  /// not seen one like it.
  virtual void changes_at(std::span<const double> /*y*/) {}
  /// The whole state at a time within the last step.
  virtual void interpolate(double t, std::span<double> y) = 0;
  /// The same of u and w at the two ends and, where these have no mass, at their neighbours, and at all other nodes of
  /// contacts; the rest may be left.
  virtual void interpolate_ends(double t, std::span<double> y) { interpolate(t, y); }
  /// Energies of the account at the end of the last step, as the layout has them.
  virtual std::span<const double> account() const = 0;
  /// row_values() of the accelerations at a time within the last step, valid until the next call, for a method with an
  /// account_correction().
  virtual std::span<const double> accelerations(double /*t*/) { return {}; }
  /// Which of the entries sample() is to give from now on, by their positions.
  virtual void select(std::span<const std::size_t> sampled) = 0;
  /// Bounds of each entry over the last step, and its value at the end: a bound that is that value is attained there.
  /// False: the method has none, and sets nothing.
  virtual bool hull(std::span<double> /*lowest*/, std::span<double> /*highest*/, std::span<double> /*last*/) {
    return false;
  }
  /// Change of the energy account by the corrector of the last step; 0 where the account is a quadrature.
  virtual double account_correction() const { return 0.0; }
  /// Weights of its error test, with the maxima so far: they are in a checkpoint.
  virtual ErrorWeights& weights() = 0;

 protected:
  std::vector<std::size_t> form_entries_;  // each once
  std::vector<LinearForm> forms_;          // by their places
  std::vector<PointValues> form_points_;

 private:
  std::array<std::vector<PointValues>, 2> points_;  // of values and rates
};

inline void LegStepper::take_forms(std::span<const LinearForm> forms) {
  forms_.assign(forms.begin(), forms.end());
  form_points_.resize(forms.size());
  form_entries_.clear();
  for (const LinearForm& form : forms)
    form_entries_.insert(form_entries_.end(), form.entries.begin(),
                         form.entries.begin() + static_cast<std::ptrdiff_t>(form.count));
  std::ranges::sort(form_entries_);
  form_entries_.erase(std::unique(form_entries_.begin(), form_entries_.end()), form_entries_.end());
  for (LinearForm& form : forms_)
    for (std::size_t& entry : form.entries)
      entry = static_cast<std::size_t>(std::ranges::lower_bound(form_entries_, entry) - form_entries_.begin());
}

/// How long a step may be: a load that varies, and vanishes wherever a long step looks, could hide a pulse in between.
/// A load that lasts for a 64th of the run or longer is seen.
inline double longest_step(const PenalisedSystem& system, double duration) {
  return system.load().varies() ? duration / 64.0 : std::numeric_limits<double>::infinity();
}

/// Objects that a stepper works on and counts in; all outlive it.
struct StepperParts {
  PenalisedSystem& system;
  const Layout& layout;
  std::span<const double> times;
  Statistics& statistics;
  std::span<Derivative* const> derivatives{};  ///< as many as the layout has
};
using MakeStepper = std::function<std::unique_ptr<LegStepper>(const StepperParts&)>;

}  // namespace viscobar
