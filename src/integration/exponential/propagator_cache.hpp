#pragma once

#include <memory>
#include <vector>

#include "integration/exponential/propagator.hpp"
#include "viscobar/dynamics/penalised_system.hpp"

namespace viscobar::exponential {

/// The propagators of the contact states that a run comes back to, the least recently used forgotten when their
/// matrices would take too much memory.
class PropagatorCache {
 public:
  /// All arguments outlive this; `exponentials` counts the matrices that are built.
  PropagatorCache(const PenalisedSystem& system, const LoadInterpolation& load, std::size_t& exponentials);

  /// For the present contact states of the system. Valid until the next call.
  Propagator& present();

  /// What displacements are measured from.
  double origin() const { return origin_; }
  void measure_from(double origin);
  /// Where contact c begins, measured from the origin.
  double surface(std::size_t c) const { return -system_.contact(c).gap - origin_; }

 private:
  struct Entry {
    std::vector<bool> closed;
    std::unique_ptr<Propagator> propagator;
  };

  const PenalisedSystem& system_;
  const LoadInterpolation& load_;
  std::size_t& exponentials_;
  double inverse_inertia_;
  double origin_ = 0.0;
  std::vector<Entry> entries_;  // the last used at the end
};

}  // namespace viscobar::exponential
