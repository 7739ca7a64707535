#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/relaxing_rows.hpp"
#include "integration/error_weights.hpp"
#include "integration/stepper.hpp"

namespace viscobar {

/// I_j = int_0^s exp(-mu (s - r)) r^j dr, j = 0 .. 5, by I_j = (s^j - j I_{j-1}) / mu, which is taken in the direction
/// in which it forgets errors.
std::array<double, 6> relaxed_powers(double mu, double s);

/// Coefficients of the powers of s of the polynomial through n values at s = 0, 1/(n-1), ..., 1, by Newton's form.
template <std::size_t n>
std::array<double, n> powers_through(std::array<double, n> f) {
  constexpr double last = n - 1;
  for (std::size_t order = 1; order < n; ++order)
    for (std::size_t j = n - 1; j >= order; --j) f[j] = (f[j] - f[j - 1]) * last / static_cast<double>(order);
  std::array<double, n> power{f[n - 1]};
  for (std::size_t k = n - 1; k-- > 0;) {
    const double node = static_cast<double>(k) / last;
    for (std::size_t j = n - 1; j > 0; --j) power[j] = power[j - 1] - node * power[j];
    power[0] = f[k] - node * power[0];
  }
  return power;
}

/// A step of a one-step method as a polynomial. Since u' = w, the displacement, the velocity and the acceleration a at
/// the two ends of a step of length h determine a quintic in s = (t - t_0) / h: its rate is Hermite's cubic of w and a
/// with what is missing to u_1 - u_0 added,
///
///     w = cubic(w_0, a_0, w_1, a_1) + 30 s^2 (1-s)^2 D / h,   D = u_1 - u_0 - h (w_0 + w_1) / 2 + h^2 (a_1 - a_0) /
///     12,
///
/// wrong by h^6 u^(6) / 46080 in u and by 8e-5 h^5 u^(6) in w, in between: as little as a step of order five, for no
/// evaluation.
///
/// A massless node has no acceleration to rely on, it follows its neighbour as its row says: without viscosity at
/// once, with it by a relaxation that may be stiff beyond measure, and which is solved exactly for the neighbour's
/// quintic and a load that is interpolated at five points of the step.
///
/// Nor has a node on the spring of a closed contact that the step is too long to resolve: what its displacement is
/// wrong by is in it omega^2 times. It follows its row without its own inertia, the spring being as far in as the
/// neighbours' quintics press it. What its inertia adds is taken from the row without it, so that a term of 2 d /
/// (omega h)^3 is left out: where that would be more than the tolerance, the accelerations serve. The other
/// accelerations are those that satisfy their rows beside it.
///
/// The energy account of the step is the integral of its rates over the polynomial, by Gauss' formula.
///
/// Derivatives by parameters have a quintic likewise, by their own rates at the two ends. A massless node follows its
/// row, whose right-hand side is a polynomial through six points of the step. At resting nodes, where there is no
/// acceleration to rely on, and of impulses they have a cubic.
class StepPolynomial {
 public:
  static constexpr std::size_t degree = 5;

  /// One end of the step: time, state with the w of massless nodes, acceleration of massive nodes.
  struct End {
    double t = 0.0;
    std::vector<double> y, a;
    std::vector<double> derivative_rates;  ///< of the entries behind the account
  };

  StepPolynomial(PenalisedSystem& system, const Layout& layout, std::span<Derivative* const> derivatives = {});

  void begin_run(std::vector<std::size_t> sampled_entries);

  /// Sets the tolerated error of a step in u.
  void tolerate(double displacement) { tolerance_ = displacement; }

  /// True if viscosity makes of an error of w one of a = f(t, u, w) that spoils a step of that length: 12 eta / (rho
  /// h^2) of it, the fastest decay, and a enters u with 1/48 of its square.
  static bool spoils_acceleration(const PenalisedSystem& system, double length);

  /// Begins a leg at end(), which has been filled.
  void restart();
  /// Makes the end of the last step the beginning of the next; the new end is to be filled, then completed by finish().
  void advance() { std::swap(begin_, end_); }
  void finish() { known_.reset(), complete(); }
  /// The same, by a method that knows the length of the step without the rounding of the time, and u_1 - u_0 of all
  /// nodes without that of u, until the next step is made.
  void finish(double length, std::span<const double> increment) { known_ = Known{length, increment}, complete(); }

  const End& begin() const { return begin_; }
  End& end() { return end_; }
  /// The energy account there.
  std::span<const double> account() const { return std::span(end_.y).subspan(2 * layout_.nodes, layout_.account()); }

  /// The whole state, energy account included.
  void at(double t, std::span<double> y);
  /// Derivative (0 or 1) of the sampled entries of (u, w), of those selected (all at first).
  std::span<const double> sample(double t, int derivative);
  void select(std::span<const std::size_t> sampled) { selected_.assign(sampled.begin(), sampled.end()); }
  /// Bounds of each sampled entry over the step, by Bernstein's coefficients of the quintic; none for velocities and
  /// massless nodes.
  void hull(std::span<double> lowest, std::span<double> highest, std::span<double> last) const;
  /// Those entries at degree + 1 equidistant times.
  void sample(double begin, double end, std::span<const std::size_t> entries, std::span<PointValues> out) const;

 private:
  // Weights of h w_0, h w_1, h^2 a_0, h^2 a_1 and D in a derivative of u - u_0 by s.
  struct Weights {
    double w0, w1, a0, a1, defect;
  };
  struct Relaxation {
    RelaxingRow row;
    double load = 0.0;                 // at the end of the step
    std::array<double, 6> drive = {};  // right-hand side of the row, powers of s
  };

  struct Known {
    double length;
    std::span<const double> increment;
  };

  static Weights weights(double s, int derivative);
  double defect(std::size_t i) const;
  double massive(std::size_t i, const Weights& weights) const;
  auto all_massive(const Weights& weights) const;
  double relaxed(const Relaxation& relaxation, double s) const;
  static double relaxed_rate(const Relaxation& relaxation, double s, double u);
  double value(std::size_t unknown, double s, int derivative) const;
  double value(std::size_t unknown, double s, int derivative, const Weights& weights) const;
  void forget_acceleration();
  void smooth_unresolved();
  bool passes_over(std::size_t contact);
  void rest_unresolved(std::span<double> a);
  void drive(Relaxation& relaxation);
  void drive_by_load(Relaxation& relaxation);
  void motion_at(double t, std::span<double> y);
  void add_account(double until, std::span<double> y);
  void derivatives_at(double t, std::span<double> y) const;
  double relaxed_derivative(const Relaxation& relaxation, std::size_t k, double s) const;
  std::array<double, 2> derivative_at(std::size_t k, std::size_t i, double s) const;  // of u_i, and of w_i
  void complete();
  void relax(const RelaxingRow& row, double load);
  double length() const { return known_ ? known_->length : end_.t - begin_.t; }
  double increment(std::size_t i) const { return known_ ? known_->increment[i] : end_.y[i] - begin_.y[i]; }

  PenalisedSystem& system_;
  Layout layout_;
  std::span<Derivative* const> derivatives_;
  End begin_, end_;
  std::vector<Relaxation> relaxations_;     // of massless nodes, as long as the leg; behind them those of this step
  std::vector<std::size_t> relaxation_of_;  // of each unknown: its place among them and 1, 0 for none
  std::size_t massless_ = 0;
  double tolerance_ = 0.0;
  std::vector<std::size_t> entries_, selected_;
  std::vector<double> sampled_, inner_, accelerations_;
  std::vector<double> defects_;  // of all nodes, once the motion within the step is asked for
  std::optional<Known> known_;
  std::vector<std::size_t> unresolved_, replaced_;  // nodes; of those the factor is
  std::vector<double> change_;                      // of accelerations
  TridiagonalFactor beside_;                        // of rho M without the rows of replaced_
  bool first_of_leg_ = false, forgotten_ = false;
};

/// A stepper whose steps are such polynomials.
class PolynomialStepper : public LegStepper {
 public:
  void begin_run(std::vector<std::size_t> sampled_entries) final { step_.begin_run(std::move(sampled_entries)); }
  std::size_t order() const final { return StepPolynomial::degree; }
  void interpolate(double t, std::span<double> y) final { step_.at(t, y); }
  std::span<const double> account() const final { return step_.account(); }
  std::span<const double> sample(double t, int derivative) final { return step_.sample(t, derivative); }
  void select(std::span<const std::size_t> sampled) final { step_.select(sampled); }
  bool hull(std::span<double> lowest, std::span<double> highest, std::span<double> last) final {
    step_.hull(lowest, highest, last);
    return true;
  }
  std::span<const PointValues> form_samples(double begin, double end) final {
    if (forms_.empty()) return {};
    of_entries_.resize(form_entries_.size());
    step_.sample(begin, end, form_entries_, of_entries_);
    for (std::size_t i = 0; i < forms_.size(); ++i)
      Points<8>::Map(form_points_[i].data()) = forms_[i].of_points<8>(of_entries_);
    return form_points_;
  }
  ErrorWeights& weights() final { return weights_; }

 protected:
  PolynomialStepper(const StepperParts& parts, const Tolerance& tolerance)
      : motion_(parts.system, false, parts.derivatives.size()),
        weights_(parts.system, motion_, tolerance, parts.times.back(), one_step_accumulation, parts.derivatives),
        step_(parts.system, parts.layout, parts.derivatives),
        contacts_(parts.system.contacts()) {}

  /// A first step of a leg that resolves the springs of its closed contacts. The error estimate of L-stable formulas
  /// does not see an impact that a step passes over: it would end in rest, and the reaction could have either sign.
  double resolving(double step) const {
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      if (contacts_.closed(i) && contacts_[i].rate * step > 1.0) step = 1.0 / contacts_[i].rate;
    return step;
  }

  const Layout motion_;  // without the energy account
  ErrorWeights weights_;
  StepPolynomial step_;

 private:
  const Contacts& contacts_;
  std::vector<PointValues> of_entries_;
};

}  // namespace viscobar
