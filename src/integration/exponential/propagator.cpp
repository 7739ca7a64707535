#include "integration/exponential/propagator.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace viscobar::exponential {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Bound of the rates |lambda| of the leg: sqrt(|M^-1| |K|) + |M^-1| |C|, of a side k / rho and c / rho, + the massless
// nodes' own relaxation.
double rate_bound(const BarSystem& system, double inverse_inertia, const std::vector<ClosedContact>& closed) {
  double stretch = std::numeric_limits<double>::infinity(), rate_stretch = stretch;
  for (std::size_t e = 0; e < system.mesh().elements; ++e)
    stretch = std::min(stretch, system.elements().stretch(e)),
    rate_stretch = std::min(rate_stretch, system.elements().rate_stretch(e));
  const double stiffness = system.bar().modulus / stretch, damping = system.bar().viscosity / rate_stretch;
  double contact_stiffness = 0.0, contact_damping = 0.0, massless_stiffness = 0.0;
  for (const ClosedContact& contact : closed) {
    const auto node = static_cast<std::size_t>(contact.unknown);
    if (system.inertia().massless(node)) {
      massless_stiffness = std::max(massless_stiffness, contact.law.stiffness);
    } else {
      contact_stiffness = std::max(contact_stiffness, contact.law.stiffness);
      contact_damping = std::max(contact_damping, contact.law.damping);
    }
  }
  const double rho = system.bar().density;
  const double side_stiffness = system.side() ? system.side()->largest_stiffness() / rho : 0.0;
  const double side_drag = system.side() ? system.side()->largest_drag() / rho : 0.0;
  double rate = std::sqrt(inverse_inertia * (4.0 * stiffness + 2.0 * contact_stiffness) + side_stiffness) +
                inverse_inertia * (4.0 * damping + 2.0 * contact_damping) + side_drag;
  if (system.inertia().has_massless() && system.bar().damped()) rate += (stiffness + massless_stiffness) / damping;
  return rate;
}

}  // namespace

Propagator::Propagator(const BarSystem& system, const VectorXd& origin, double inverse_inertia,
                       const LoadInterpolation& load, std::vector<ClosedContact> closed, std::size_t& exponentials)
    : leg_(system, origin, load.steady(), closed),
      extended_leg_(system, origin, load.steady(), closed),
      load_(load),
      exponentials_(exponentials),
      free_(closed.empty() && !system.unknowns().left_fixed() && !system.unknowns().right_fixed() && !system.side()),
      finest_(std::exp2(-std::ceil(std::log2(rate_bound(system, inverse_inertia, closed))))) {}

LinearLeg<double>::Series Propagator::expand(const VectorXd& y, const LoadPolynomial& load, double tau,
                                             Index order) const {
  return leg_.expand(y, 1.0, load_.varying(load), tau, order);
}

void Propagator::advance(int level, VectorXd& y, const LoadPolynomial& load) {
  const Index m = leg_.size();
  if (level <= 0) {
    const auto series = expand(y, load, step(level));
    y = leg_.pack(leg_.displacement(series, 1.0), leg_.velocity(series, 1.0, step(level)));
    return;
  }
  build_increments(level);
  const MatrixXd& increment = levels_[level].increment;
  // A rigid displacement changes nothing; the roundings of the entries would make it a force.
  const Index n = leg_.displacements();
  const double rigid = free_ ? y.head(n).mean() : 0.0;
  VectorXd change = increment.middleCols(n, m - n) * y.tail(m - n) + increment.col(m);
  change.noalias() += increment.leftCols(n) * (y.head(n).array() - rigid).matrix();
  if (load.size() > 0) change += response(level) * load.reshaped();
  y += change;
}

void Propagator::build_increments(int level) {
  const Index m = leg_.size();
  while (static_cast<int>(levels_.size()) <= level) {
    if (levels_.empty()) {
      coarsest_.resize(m, m + 1);
      const long double tau = finest_;
      for (Index j = 0; j <= m; ++j) {
        LinearLeg<long double>::Vector unit = LinearLeg<long double>::Vector::Zero(m);
        if (j < m) unit[j] = 1;
        // Without the terms of I: 1 + (a rate times tau_0) - 1 would keep few digits of the slow modes' rates.
        auto series = extended_leg_.expand(unit, j < m ? 0 : 1, {}, tau, taylor_order);
        series.col(0).setZero();
        const auto u = extended_leg_.displacement(series, 1);
        series.col(1).setZero();
        coarsest_.col(j) = extended_leg_.pack(u, extended_leg_.velocity(series, 1, tau));
      }
    } else {
      const ExtendedMatrix square = coarsest_.leftCols(m) * coarsest_;
      coarsest_ = 2 * coarsest_ + square;
    }
    if (free_) keep_rigid_motions(static_cast<long double>(step(static_cast<int>(levels_.size()))));
    levels_.push_back({coarsest_.cast<double>(), {}});
    ++exponentials_;
  }
}

// A rigid displacement stays where it is, and moves at a rigid velocity by it times tau. Squaring loses that: what is
// missing acts as a spring to the origin, and grows fourfold a level.
void Propagator::keep_rigid_motions(long double tau) {
  const Index m = leg_.size(), u = leg_.displacements(), v = m - u;
  using Vector = LinearLeg<long double>::Vector;
  auto increment = coarsest_.leftCols(m);
  const Vector of_displacement = increment.leftCols(u).rowwise().mean();
  Vector of_velocity = increment.rightCols(v).rowwise().mean();
  of_velocity.head(u).array() -= tau / static_cast<long double>(v);
  increment.leftCols(u).colwise() -= of_displacement;
  increment.rightCols(v).colwise() -= of_velocity;
}

const MatrixXd& Propagator::response(int level) {
  const Index m = leg_.size(), rank = load_.basis().cols();
  MatrixXd& out = levels_[level].response;
  const Index columns = rank * (load_degree + 1);
  if (out.cols() == columns) return out;  // else the basis has grown
  MatrixXd result(m, columns);
  if (level == 0) {
    MatrixXd unit = MatrixXd::Zero(load_.basis().rows(), load_degree + 1);
    for (Index j = 0; j <= load_degree; ++j, unit.setZero())
      for (Index q = 0; q < rank; ++q) {
        unit.col(j) = load_.basis().col(q);
        const auto series = leg_.expand(VectorXd::Zero(m), 0.0, unit, finest_, taylor_order);
        result.col(j * rank + q) = leg_.pack(leg_.displacement(series, 1.0), leg_.velocity(series, 1.0, finest_));
      }
  } else {
    const MatrixXd& half = response(level - 1);
    result = half;
    result.noalias() += levels_[level - 1].increment.leftCols(m) * half;
    double scale = 1.0;
    for (Index j = 0; j <= load_degree; ++j, scale /= 2) {
      auto weights = result.middleCols(j * rank, rank);
      double binomial = 1.0;
      for (Index i = 0; i <= j; ++i) {
        weights += binomial * half.middleCols(i * rank, rank);
        binomial *= static_cast<double>(j - i) / static_cast<double>(i + 1);
      }
      weights *= scale;
    }
  }
  return out = std::move(result);
}

namespace {

// The largest sum of a row's magnitudes, of (rho M)^{-1}.
double largest_row_of_inverse(const BandedMatrix& inertia) {
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
  const auto begin = static_cast<Index>(bar.inertia().massive_begin());
  const Index count = static_cast<Index>(bar.inertia().massive_end()) - begin;
  const BandedMatrix& inertia = bar.inertia().matrix();
  if (inertia.unsymmetric()) return largest_row_of_inverse(inertia);
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

Propagator& PropagatorCache::present() {
  const Contacts& contacts = system_.contacts();
  if (const auto origin = contacts.origin().values();
      !origin.empty() && !std::ranges::equal(origin, entries(origin_))) {
    std::ranges::copy(origin, origin_.data());
    entries_.clear();
  }
  std::vector<bool> state(contacts.size());
  for (std::size_t c = 0; c < state.size(); ++c) state[c] = contacts.closed(c);
  const auto known = std::ranges::find(entries_, state, &Entry::closed);
  if (known != entries_.end()) {
    std::rotate(known, known + 1, entries_.end());
  } else {
    std::vector<ClosedContact> closed;
    for (std::size_t c = 0; c < state.size(); ++c)
      if (state[c])
        closed.push_back({static_cast<Index>(contacts[c].unknown), contacts.surface(c), contacts[c].law.linear(),
                          contacts[c].joint > 0});
    for (const Support& support : system_.bar().supports()) {
      const auto at = static_cast<Index>(support.unknown);
      closed.push_back({at, -origin_[at], {support.stiffness, support.dashpot}, false});
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
