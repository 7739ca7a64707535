#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "integration/bernstein.hpp"
#include "viscobar/dynamics/penalised_system.hpp"

namespace viscobar {

/// Finds the contact changes inside one step of a multistep method on the step's own interpolant.
///
/// An open contact changes when its clearance becomes negative, a closed one when it becomes positive: both are the
/// descent of an oriented clearance p through zero. On a step p is a polynomial of the method's order, taken in
/// Bernstein form, so that no crossing is missed: neither two within a step nor a touch. A descent counts once it
/// passes the rounding of the clearance, and its time is that of p = 0. (Only for an undamped massless node under a
/// load that varies in time is p more than a polynomial; the load is then interpolated at the order of the method.)
class EventSearch {
 public:
  explicit EventSearch(PenalisedSystem& system)
      : system_(system), count_(system.contact_count()), samples_(count_ * (Bernstein::max_degree + 1)) {}

  /// Entries of u that the search samples, one for each contact.
  std::vector<std::size_t> sampled_entries() const {
    std::vector<std::size_t> entries(count_);
    for (std::size_t i = 0; i < count_; ++i) entries[i] = system_.watched(i);
    return entries;
  }

  /// Time of the first change in [begin, end] of the interpolant of degree `order`; `sample(t, derivative)` gives its
  /// value or rate at the sampled entries. `largest` bounds |u|. Absent: no contact changes.
  template <class Sample>
  std::optional<double> first_change(double begin, double end, std::size_t order, double largest, Sample&& sample) {
    for (std::size_t j = 0; j <= order; ++j) {
      const double t = j == order ? end : begin + (end - begin) * static_cast<double>(j) / static_cast<double>(order);
      const std::span<const double> u = sample(t, 0);
      for (std::size_t i = 0; i < count_; ++i) samples_[i * (order + 1) + j] = oriented(i, t, u[i]);
    }
    double first = 2.0;
    std::size_t which = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const std::span<const double> values(samples_.data() + i * (order + 1), order + 1);
      if (system_.closed(i))
        for (double value : values) max_penetration_ = std::max(max_penetration_, system_.penetration_share(i) * value);
      const auto s = Bernstein::through(values).first_descent(-system_.clearance_rounding(i, largest));
      if (s && *s < first) first = *s, which = i;
    }
    if (first > 1.0) return std::nullopt;
    return polished(begin, end, begin + first * (end - begin), which, sample);
  }

  /// Whether contact i changes at an event: its oriented clearance is used up to rounding and falls.
  bool changes(std::size_t i, double t, std::span<const double> u, double rate, double largest) {
    return oriented(i, t, u[system_.watched(i)]) <= system_.clearance_rounding(i, largest) &&
           (system_.closed(i) ? rate > 0.0 : rate < 0.0);
  }
  std::size_t first_contact() const { return which_; }
  double max_penetration() const { return max_penetration_; }

 private:
  double oriented(std::size_t i, double t, double u) {
    const double clearance = u + system_.offset(i, t);
    return system_.closed(i) ? -clearance : clearance;
  }

  // The descent through the threshold is a rounding late; Newton's method leads back to the zero.
  template <class Sample>
  double polished(double begin, double end, double t, std::size_t i, Sample&& sample) {
    which_ = i;
    const double sign = system_.closed(i) ? -1.0 : 1.0;
    for (int iteration = 0; iteration < 4; ++iteration) {
      const double value = oriented(i, t, sample(t, 0)[i]);
      const double rate = sign * sample(t, 1)[i];
      if (!(rate < 0.0)) break;
      const double next = std::clamp(t - value / rate, begin, end);
      if (std::abs(next - t) > 1e-3 * (end - begin) || next == t) break;  // a graze: the descent itself is the event
      t = next;
    }
    return t;
  }

  PenalisedSystem& system_;
  std::size_t count_;
  std::vector<double> samples_;
  std::size_t which_ = 0;
  double max_penetration_ = 0.0;
};

}  // namespace viscobar
