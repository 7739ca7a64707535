#include "integration/exponential/propagator_cache.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace viscobar::exponential {

using Eigen::VectorXd;

namespace {

// The largest sum of a row's magnitudes, of (rho M)^{-1} with end rows.
double largest_row_of_inverse(const SymmetricTridiagonal& inertia) {
  const TridiagonalFactor factor(inertia);
  VectorXd sums = VectorXd::Zero(static_cast<Index>(inertia.size()));
  std::vector<double> column(inertia.size());
  for (std::size_t j = 0; j < column.size(); ++j) {
    std::ranges::fill(column, 0.0);
    column[j] = 1.0;
    factor.solve(column);
    sums += Eigen::Map<const VectorXd>(column.data(), sums.size()).cwiseAbs();
  }
  return sums.maxCoeff();
}

// Norm of (rho M)^{-1} on the massive nodes.
double norm_of_inverse_inertia(const BarSystem& bar) {
  const auto begin = static_cast<Index>(bar.massive_begin());
  const Index count = static_cast<Index>(bar.massive_end()) - begin;
  const SymmetricTridiagonal& inertia = bar.inertia();
  if (inertia.end_rows) return largest_row_of_inverse(inertia);
  const VectorXd diagonal = Eigen::Map<const VectorXd>(inertia.diagonal.data() + begin, count);
  if (inertia.off_diagonal.empty() || count == 1) return 1.0 / diagonal.minCoeff();
  const VectorXd off = Eigen::Map<const VectorXd>(inertia.off_diagonal.data() + begin, count - 1);
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum;
  spectrum.computeFromTridiagonal(diagonal, off, Eigen::EigenvaluesOnly);
  return 1.0 / spectrum.eigenvalues().minCoeff();
}

}  // namespace

PropagatorCache::PropagatorCache(const PenalisedSystem& system, const LoadInterpolation& load,
                                 std::size_t& exponentials)
    : system_(system),
      load_(load),
      exponentials_(exponentials),
      inverse_inertia_(norm_of_inverse_inertia(system.bar())),
      origin_(VectorXd::Zero(static_cast<Index>(system.size()))) {}

void PropagatorCache::measure_from_obstacle(std::size_t c) {
  origin_[node(c)] = -system_.contact(c).sign * system_.contact(c).gap;
  entries_.clear();
}

Propagator& PropagatorCache::present() {
  std::vector<bool> state(system_.contact_count());
  for (std::size_t c = 0; c < state.size(); ++c) state[c] = system_.closed(c);
  const auto known = std::ranges::find(entries_, state, &Entry::closed);
  if (known != entries_.end()) {
    std::rotate(known, known + 1, entries_.end());
  } else {
    std::vector<ClosedContact> closed;
    for (std::size_t c = 0; c < state.size(); ++c)
      if (state[c]) closed.push_back({node(c), surface(c), system_.law(c)});
    for (const Mount& mount : system_.bar().mounts()) {
      const auto at = static_cast<Index>(mount.unknown);
      closed.push_back({at, -origin_[at], {mount.stiffness, mount.dashpot}});
    }
    entries_.push_back({state, std::make_unique<Propagator>(system_.bar(), origin_, inverse_inertia_, load_,
                                                            std::move(closed), exponentials_)});
    // Twenty levels of (2n)^2 numbers, and one of twice the length; a quarter of a GiB for all states.
    const std::size_t bytes = 22 * 4 * system_.size() * system_.size() * sizeof(double);
    if (entries_.size() > std::max<std::size_t>(4, (std::size_t{1} << 28) / bytes)) entries_.erase(entries_.begin());
  }
  return *entries_.back().propagator;
}

}  // namespace viscobar::exponential
