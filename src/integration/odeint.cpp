#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <vector>

#include "integration/odeint/rosenbrock4.hpp"
#include "integration/stepwise_run.hpp"
#include "run/parts.hpp"
#include "run/step_failure.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

namespace {

/// Steps of Odeint's formulas on the legs of a run. Their size is controlled here, by the error of Tolerance in the
/// maximum norm, because Odeint's own controllers know other norms; and they are interpolated by the quintic, whose
/// order is above that of Odeint's own (four for dopri5, three for rosenbrock4).
template <class Formulas>
class OdeintStepper final : public PolynomialStepper {
 public:
  OdeintStepper(const StepperParts& parts, const Odeint& method, double stable_step)
      : PolynomialStepper(parts, method.tolerance),
        system_(parts.system),
        statistics_(parts.statistics),
        formulas_(system_, statistics_),
        end_(parts.times.back()),
        longest_(longest_step(system_, end_ - parts.times.front())),
        stable_(stable_step),
        size_(1e-3 * (end_ - parts.times.front())),
        scales_(motion_.size) {}

  void restart(double t, double stop, std::span<const double> y) override {
    stop_ = stop;
    weights_.tighten(statistics_.events);
    StepPolynomial::End& start = step_.end();
    start.t = t;
    std::ranges::copy(y, start.y.begin());
    formulas_.begin_leg(start);
    step_.restart();
    size_ = resolving(size_);
  }

  double advance() override {
    step_.advance();
    const StepPolynomial::End& from = step_.begin();
    weights_.fill(motion(from.y), scales_);
    make_controlled_step(from.t);
    step_.tolerate(weights_.displacement_tolerance());
    step_.finish();
    return step_.end().t;
  }

 private:
  std::span<const double> motion(const std::vector<double>& y) const { return std::span(y).first(motion_.size); }

  double rounding(double t) const {
    return 16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t), std::abs(end_));
  }
  // The time that a step of the present size leads to: the end of the leg, where it would leave a rounding to go.
  double target(double t) const {
    return t + size_ * (1.0 + 1e-9) >= stop_ || stop_ - t <= rounding(t) ? stop_ : t + size_;
  }

  // True if neighbours differ in their accelerations by more than a thousandth of a tolerance of the mesh's fastest
  // mode has: a bar that flies without strain may take long steps.
  bool strained() const {
    const std::vector<double>& a = step_.begin().a;
    double largest = system_.bar().unknowns().left_fixed() || system_.bar().unknowns().right_fixed() || a.size() == 1
                         ? std::abs(a[0])
                         : 0.0;
    for (std::size_t i = 0; i + 1 < a.size(); ++i) largest = std::max(largest, std::abs(a[i + 1] - a[i]));
    return largest * stable_ * stable_ > 1e-3 * weights_.displacement_tolerance();
  }

  void make_controlled_step(double t) {
    if (stable_ > 0.0 && size_ > stable_ && strained()) size_ = stable_;
    StepPolynomial::End& reached = step_.end();
    for (double growth = 5.0;; growth = 1.0) {
      reached.t = target(t);
      const double h = reached.t - t;
      if (h <= rounding(t) && reached.t < stop_)
        throw StepFailure(Failure::accuracy, fmt::format("no step, however short, keeps the tolerance at t = {}", t));
      const double error = formulas_.attempt(t, h, scales_, reached);
      const double factor = std::clamp(0.9 * std::pow(error, -1.0 / Formulas::error_order), 0.2, growth);
      if (error > 1.0) {
        size_ = h * factor;
        continue;
      }
      // The last step may have been cut short: it says nothing against a longer one.
      size_ = std::min(std::max(size_ * (factor < 1.0 ? factor : 1.0), h * factor), longest_);
      return;
    }
  }

  PenalisedSystem& system_;
  Statistics& statistics_;
  Formulas formulas_;
  double end_, longest_, stable_, size_, stop_ = 0.0;  // end of the run; end of the leg
  std::vector<double> scales_;
};

}  // namespace

Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Odeint& method, const Observers& observers) {
  refuse_directions("odeint", observers);
  const OdeintPlan what = plan(system, times.back() - times.front(), method);
  if (what.refusal) throw Unfit("odeint", *what.refusal);
  return run_stepwise("odeint", system, method.penalty, start, times, observers,
                      [&](const StepperParts& parts) -> std::unique_ptr<LegStepper> {
                        switch (what.stepper) {
                          case Stepper::rosenbrock4:
                            return std::make_unique<OdeintStepper<Rosenbrock4>>(parts, method, 0.0);
                          default: return std::make_unique<OdeintStepper<Dopri5>>(parts, method, what.longest_step);
                        }
                      });
}

}  // namespace viscobar
