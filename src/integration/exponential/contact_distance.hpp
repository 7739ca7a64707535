#pragma once

#include <array>
#include <optional>
#include <vector>

#include "integration/exponential/propagator.hpp"

namespace viscobar::exponential {

/// Range of a function on a step from its values at the quarters and its slopes (per half step) at begin, middle and
/// end: that of the quintic through all but the values at the first and third quarter, as Bernstein coefficients on
/// either half. How far these two are off says how well the function is resolved; four times that is the margin.
class SampledRange {
 public:
  struct Samples {
    std::array<double, 5> values;
    std::array<double, 3> slopes;
  };
  explicit SampledRange(const Samples& samples);
  double lowest() const;
  double highest() const;
  bool monotone() const;

 private:
  std::array<double, 12> control_;
  double margin_;
};

/// sum_k c_k sigma^k
double value(const Eigen::VectorXd& c, double sigma);

/// Its derivative.
double slope(const Eigen::VectorXd& c, double sigma);

/// Largest value on [0, sigma] of a polynomial that has one maximum there at most.
double largest_value(const Eigen::VectorXd& c, double sigma);

/// First sigma in [0, 1] at which the polynomial sum_k c_k sigma^k leaves [-band, infinity), traced back to its zero.
std::optional<double> first_passage(const Eigen::VectorXd& c, double band);

/// How far the contacts are from their changes during a step, and to what digit that is known: d = u - surface while
/// a contact is open, the opposite while it is closed; it changes where d < 0.
///
/// An undamped massless node has no displacement of its own in y: it follows its neighbour and the load, and is judged
/// by where it would be were it open, since a stiff contact leaves no digits of its own displacement.
///
/// A stop with k and c lets go (see push_weights()): it changes where d + (c/k) d' < 0, from closed, and
/// from open behind its surface. There the node moves out as long as that is positive: d' > (k/c) |d|.
class ContactDistance {
 public:
  using Series = LinearLeg<double>::Series;

  /// Sizes that the roundings are relative to.
  struct Largest {
    double displacement = 0.0, penetration = 0.0;
  };

  /// All arguments outlive this.
  ContactDistance(const BarSystem& system, const PenalisedSystem& penalised, const LoadInterpolation& load)
      : system_(system), penalised_(penalised), load_(load) {
    for (std::size_t c = 0; c < penalised.contacts().size(); ++c)
      if (const Stop* stop = penalised.contacts()[c].law.stop(); stop && stop->damping > 0.0) {
        lags_.resize(penalised.contacts().size());
        lags_[c] = stop->damping / stop->stiffness;
      }
  }

  Index node(std::size_t c) const { return static_cast<Index>(penalised_.contacts()[c].unknown); }
  /// True if the node of contact c has no displacement of its own.
  bool follows(std::size_t c) const { return !system_.bar().damped() && massless(c); }

  /// d's Taylor coefficients over a step.
  Eigen::VectorXd along(std::size_t c, const Series& series, const LoadPolynomial& p) const;

  /// True if a stop lets go.
  bool lets_go() const { return !lags_.empty(); }
  /// Indicator of a change of contact c in place of d: d + (c/k) d', with its rounding error.
  struct Push {
    Eigen::VectorXd along;
    double band;
  };
  /// The same from d's Taylor coefficients over a step of length tau; absent where d decides.
  std::optional<Push> push(std::size_t c, const Eigen::VectorXd& d, double tau, const Largest& largest) const;

  /// Penetration per d while contact c is closed.
  double penetration_share(std::size_t c) const {
    return follows(c) ? penalised_.contacts()[c].penetration_share() : 1.0;
  }

  /// How far behind zero d passes for a change. Closing, its rounding. Opening, less where it can be: a stiff contact
  /// has penetrations of that size, and would hold the bar back until its pull exceeds them.
  double band(std::size_t c, const Largest& largest) const;

  /// True if contact c surely stays as it is during a step of length tau and the maximum of its penetration is known
  /// to the rounding of a displacement, from the motion and the load expanded at equal parts of the step, a multiple
  /// of four. `penetration` rises to its maximum.
  bool keeps_state(std::size_t c, const std::vector<Series>& motion, const std::vector<LoadPolynomial>& p, double tau,
                   const Largest& largest, double& penetration) const;

  /// True if the node of open contact c surely does not come to its obstacle, which moves, during the same step from t
  /// on, in a run of length `whole`.
  bool stays_away(std::size_t c, const std::vector<Series>& motion, const std::vector<LoadPolynomial>& p, double t,
                  double tau, double whole, const Largest& largest) const;

  /// Power of what the forces on closed damped massless contacts cancel: a node's velocity is what its contact and the
  /// bar leave of each other, over its viscosity.
  double cancelled_power(double penetration) const;

 private:
  bool massless(std::size_t c) const { return system_.inertia().massless(penalised_.contacts()[c].unknown); }
  SampledRange::Samples samples(std::size_t c, const std::vector<Series>& motion,
                                const std::vector<LoadPolynomial>& p) const;
  bool keeps_push(std::size_t c, const std::vector<Series>& motion, const std::vector<LoadPolynomial>& p, double tau,
                  const Largest& largest) const;
  double slope_noise(std::size_t c, double tau, const Largest& largest) const;

  const BarSystem& system_;
  const PenalisedSystem& penalised_;
  const LoadInterpolation& load_;
  std::vector<double> lags_;  // c/k of each contact, 0 of one that does not let go; empty where none does
};

}  // namespace viscobar::exponential
