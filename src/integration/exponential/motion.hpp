#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "integration/exponential/contact_distance.hpp"
#include "integration/exponential/propagator.hpp"

namespace viscobar::exponential {

using Eigen::VectorXd;
using Series = LinearLeg<double>::Series;

/// The motion of a bar by matrix exponentials where the run is: y on the present leg, measured as the contacts do, and
/// the load on the present step. Steps double as long as they resolve what a run looks for in them.
class Motion {
 protected:
  static constexpr double rounding = std::numeric_limits<double>::epsilon();

  /// The system outlives it.
  Motion(const BarSystem& system, const Penalty& penalty, std::span<const double> times, double t)
      : system_(system),
        penalised_(system, penalty),
        load_(system, times.front(), times.back()),
        propagators_(penalised_, load_, exponentials_),
        distance_(system_, penalised_, load_),
        duration_(times.back() - times.front()),
        t_(t) {}

  const LinearLeg<double>& leg() const { return propagator_->leg(); }
  Contacts& contacts() { return penalised_.contacts(); }
  const Contacts& contacts() const { return penalised_.contacts(); }
  double sign(std::size_t c) const { return contacts()[c].sign; }

  /// For the contacts as they are now.
  void begin_leg() {
    propagator_ = &propagators_.present();
    level_ = wait_ = 0;
  }

  /// The unknown whose displacement is the first of y.
  std::size_t first_displacement() const {
    return static_cast<std::size_t>(leg().displacements()) == system_.size() ? 0 : system_.inertia().massive_begin();
  }
  double& displacement_of(Index node) { return y_[node - static_cast<Index>(first_displacement())]; }
  /// Displacements and velocities of all unknowns as far as y has them, those of others 0.
  State unpacked() const {
    State all{std::vector<double>(system_.size()), std::vector<double>(system_.size())};
    const Index n = leg().displacements();
    std::copy_n(y_.data(), n, all.u.begin() + static_cast<std::ptrdiff_t>(first_displacement()));
    std::copy(y_.data() + n, y_.data() + y_.size(),
              all.v.begin() + static_cast<std::ptrdiff_t>(system_.inertia().massive_begin()));
    return all;
  }
  /// The same, nodes without mass where their rows put them.
  State state() {
    State now = unpacked();
    penalised_.complete_displacement(t_, now.u);
    return now;
  }
  void put(std::span<const double> u, std::span<const double> w) {
    const auto vector = [](std::span<const double> x) {
      return VectorXd(Eigen::Map<const VectorXd>(x.data(), static_cast<Index>(x.size())));
    };
    y_ = leg().pack(vector(u), vector(w));
  }
  /// Measures the displacement of a node from the obstacle that it has come to: the penetration keeps all its digits.
  void measure_from_obstacle(std::size_t closing) {
    if (distance_.follows(closing)) return;
    State now = unpacked();
    contacts().measure(closing, now.u);
    put(now.u, now.v);
  }

  /// To be called where a step begins.
  void notice_displacement() {
    const std::span<const double> u(y_.data(), static_cast<std::size_t>(leg().displacements()));
    for (std::size_t k = 0; k < u.size(); ++k)
      largest_displacement_ =
          std::max(largest_displacement_, std::abs(u[k] + contacts().origin().at(first_displacement() + k)));
  }
  /// A force that displaces the bar by less than the rounding of its displacement: over the run by T^2 / mass, and a
  /// massless node by h / E.
  double negligible_load() const {
    const double massless = system_.inertia().has_massless() ? system_.mesh().spacing() / system_.bar().modulus : 0.0;
    return rounding * largest_displacement_ /
           std::max(duration_ * duration_ * propagators_.inverse_inertia(), massless);
  }

  void shorten() { --level_, wait_ = patience; }
  void lengthen() { wait_ > 0 ? --wait_ : ++level_; }

  /// The Taylor series that covers a part of the present step, of length tau, in which t lies.
  struct Part {
    Series series;
    LoadPolynomial p;
    double sigma, length;
  };
  Part part_at(double t, double tau) {
    VectorXd y = y_;
    LoadPolynomial p = p_;
    double s = t - t_, width = tau;
    for (int level = level_ - 1; level >= 0; --level) {
      width /= 2;
      const LoadPolynomial first_half = rescaled(p, 0.0, 0.5);
      if (s < width) {
        p = first_half;
        continue;
      }
      propagator_->advance(level, y, first_half);
      p = rescaled(p, 0.5, 0.5);
      s -= width;
    }
    Series series = propagator_->expand(y, p, width);
    return {std::move(series), std::move(p), s / width, width};
  }

  Index node(std::size_t c) const { return distance_.node(c); }

  const BarSystem& system_;
  std::size_t exponentials_ = 0;  // matrices that have been built
  PenalisedSystem penalised_;
  LoadInterpolation load_;
  PropagatorCache propagators_;
  ContactDistance distance_;
  Propagator* propagator_ = nullptr;
  double duration_, t_;
  VectorXd y_;
  LoadPolynomial p_;  // on the current step
  int level_ = 0;     // of the current step; below 0 where the load asks for less than a Taylor series could do
  double largest_displacement_ = 0.0;

 private:
  static constexpr int patience = 8;  // steps before a length that failed is tried again
  int wait_ = 0;                      // steps until a longer one is tried
};

}  // namespace viscobar::exponential
