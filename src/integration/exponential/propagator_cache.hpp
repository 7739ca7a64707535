#pragma once

#include <memory>
#include <vector>

#include "dynamics/penalised_system.hpp"
#include "integration/exponential/propagator.hpp"

namespace viscobar::exponential {

/// The propagators of the contact states that a run comes back to, the least recently used forgotten when their
/// matrices would take too much memory.
class PropagatorCache {
 public:
  /// All arguments outlive this; `exponentials` counts the matrices that are built.
  PropagatorCache(const PenalisedSystem& system, const LoadInterpolation& load, std::size_t& exponentials);

  /// For the present contact states of the system. Valid until the next call.
  Propagator& present();

  /// What the displacements of the unknowns are measured from, and from where in future that of contact c's node.
  const Eigen::VectorXd& origin() const { return origin_; }
  void measure_from_obstacle(std::size_t c);
  /// Norm of (rho M)^{-1} on the massive nodes.
  double inverse_inertia() const { return inverse_inertia_; }
  /// Where contact c begins, measured from the origin.
  double surface(std::size_t c) const { return -system_.contact(c).sign * system_.contact(c).gap - origin_[node(c)]; }

 private:
  Index node(std::size_t c) const { return static_cast<Index>(system_.contact(c).unknown); }

  struct Entry {
    std::vector<bool> closed;
    std::unique_ptr<Propagator> propagator;
  };

  const PenalisedSystem& system_;
  const LoadInterpolation& load_;
  std::size_t& exponentials_;
  double inverse_inertia_;
  Eigen::VectorXd origin_;
  std::vector<Entry> entries_;  // the last used at the end
};

}  // namespace viscobar::exponential
