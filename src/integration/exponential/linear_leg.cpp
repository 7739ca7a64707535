#include "integration/exponential/linear_leg.hpp"

#include "dynamics/assembly/assembled.hpp"

namespace viscobar::exponential {

template <class Real>
LinearLeg<Real>::LinearLeg(const BarSystem& system, const Eigen::VectorXd& origin, std::span<const double> steady_load,
                           std::vector<ClosedContact> closed)
    : n_(static_cast<Index>(system.size())),
      massive_begin_(static_cast<Index>(system.inertia().massive_begin())),
      massive_end_(static_cast<Index>(system.inertia().massive_end())),
      left_fixed_(system.unknowns().left_fixed()),
      right_fixed_(system.unknowns().right_fixed()),
      damped_(system.bar().damped()),
      origin_(origin),
      steady_load_(steady_load.begin(), steady_load.end()),
      closed_(std::move(closed)),
      side_(system.side()),
      first_node_(static_cast<Index>(system.unknowns().first_node())) {
  moving_begin_ = system.bar().damped() ? 0 : massive_begin_;
  moving_ = system.bar().damped() ? n_ : massive_end_ - massive_begin_;

  const std::size_t elements = system.mesh().elements;
  for (std::size_t node = system.unknowns().first_node(); node <= system.unknowns().first_node() + system.size();
       ++node) {
    const std::size_t element = std::clamp<std::size_t>(node, 1, elements) - 1;  // beyond an end: any
    stiffness_.push_back(system.bar().modulus / system.elements().stretch(element));
    damping_.push_back(system.bar().viscosity / system.elements().rate_stretch(element));
  }

  std::vector<double> nodal(system.mesh().nodes());
  system.unknowns().expand_displacement(std::vector<double>(system.size(), 0.0), nodal);
  left_displacement_ = nodal.front() - origin[0];
  right_displacement_ = nodal.back() - origin[n_ - 1];

  factor_.factorise(restrict_to(system.inertia().matrix(), system.inertia().massive_begin(),
                                system.inertia().massive_end() - system.inertia().massive_begin()));
}

template <class Real>
typename LinearLeg<Real>::Series LinearLeg<Real>::expand(const Vector& y, Real one, const Eigen::MatrixXd& load,
                                                         Real tau, Index order) const {
  Series c = Series::Zero(n_, order + 1);
  const Index massive = massive_end_ - massive_begin_;
  c.col(0).segment(moving_begin_, moving_) = y.head(moving_);
  c.col(1).segment(massive_begin_, massive) = tau * y.tail(massive);

  Vector force(massive);
  for (Index k = 0; k <= order; ++k) {
    const Real constant = k == 0 ? one : Real(0);
    const auto p = [&](Index i) {
      Real value = k < load.cols() ? Real(load(i, k)) : Real(0);
      if (k == 0 && !steady_load_.empty()) value += one * steady_load_[i];
      return value;
    };
    const auto u = c.col(k);

    // Differences to the neighbour keep a rigid motion exactly rigid.
    const auto move_massless = [&](Index end, Index neighbour) {
      Real k_c = 0, surface = 0;
      for (const ClosedContact& contact : closed_)
        if (contact.unknown == end) k_c = contact.law.stiffness, surface = contact.surface;
      const Real stiffness = stiffness_[end == 0 ? 1 : end], viscous = damping_[end == 0 ? 1 : end];
      const Real beside = u[neighbour] + constant * (origin_[neighbour] - origin_[end]);
      if (!damped_)
        c(end, k) = beside + (p(end) - k_c * (beside - constant * surface)) / (stiffness + k_c);
      else if (k < order)
        c(end, k + 1) =
            c(neighbour, k + 1) + (p(end) + stiffness * (beside - u[end]) - k_c * (u[end] - constant * surface)) * tau /
                                      (Real(k + 1) * viscous);
    };
    if (massive_begin_ > 0) move_massless(0, 1);
    if (massive_end_ < n_) move_massless(n_ - 1, n_ - 2);
    if (k + 2 > order) continue;

    const auto v = c.col(k + 1);  // times tau / (k + 1) the velocity's coefficient
    const Real rate = Real(k + 1) / tau;
    const auto stress = [&](Index i) {
      const Real strain = u[i + 1] - u[i] + constant * (origin_[i + 1] - origin_[i]);
      return stiffness_[i + 1] * strain + damping_[i + 1] * rate * (v[i + 1] - v[i]);
    };
    Real left = 0;
    if (massive_begin_ > 0)
      left = stress(0);
    else if (left_fixed_)
      left = stiffness_[0] * (u[0] - constant * left_displacement_) + damping_[0] * rate * v[0];
    for (Index i = massive_begin_; i < massive_end_; ++i) {
      Real right = 0;
      if (i + 1 < n_)
        right = stress(i);
      else if (right_fixed_)
        right = stiffness_[n_] * (constant * right_displacement_ - u[i]) - damping_[n_] * rate * v[i];
      force[i - massive_begin_] = right - left + p(i);
      left = right;
    }
    for (const ClosedContact& contact : closed_) {
      const Index i = contact.unknown;
      if (i < massive_begin_ || i >= massive_end_) continue;
      const Real pull = contact.law.stiffness * (contact.of<Real>(u) - constant * contact.surface) +
                        contact.law.damping * rate * contact.of<Real>(v);
      force[i - massive_begin_] -= pull;
      if (contact.joint) force[i - 1 - massive_begin_] += pull;
    }
    if (side_) {
      const auto displacement = [&](std::size_t j) {
        const Index i = static_cast<Index>(j) - first_node_;
        if (i < 0) return constant * left_displacement_ + constant * Real(origin_[0]);
        if (i >= n_) return constant * right_displacement_ + constant * Real(origin_[n_ - 1]);
        return u[i] + constant * Real(origin_[i]);
      };
      const auto velocity = [&](std::size_t j) {
        const Index i = static_cast<Index>(j) - first_node_;
        return i < 0 || i >= n_ ? Real(0) : Real(v[i]);
      };
      side_->subtract(
          [&](std::size_t j) { return displacement(j) * side_->stiffness(j) + rate * velocity(j) * side_->drag(j); },
          static_cast<std::size_t>(first_node_ + massive_begin_), static_cast<std::size_t>(massive), force);
    }
    factor_.solve({force.data(), static_cast<std::size_t>(massive)});
    c.col(k + 2).segment(massive_begin_, massive) = force * (tau * tau / Real((k + 1) * (k + 2)));
  }
  return c;
}

template <class Real>
typename LinearLeg<Real>::Vector LinearLeg<Real>::displacement(const Series& series, Real sigma) {
  Vector u = series.rightCols(1);
  for (Index k = series.cols() - 1; k-- > 0;) u = u * sigma + series.col(k);
  return u;
}

template <class Real>
typename LinearLeg<Real>::Vector LinearLeg<Real>::velocity(const Series& series, Real sigma, Real tau) {
  const Index order = series.cols() - 1;
  Vector v = series.col(order) * Real(order);
  for (Index k = order - 1; k > 0; --k) v = v * sigma + series.col(k) * Real(k);
  return v / tau;
}

template <class Real>
typename LinearLeg<Real>::Vector LinearLeg<Real>::acceleration(const Series& series, Real sigma, Real tau) {
  const Index order = series.cols() - 1;
  Vector a = series.col(order) * Real(order * (order - 1));
  for (Index k = order - 1; k > 1; --k) a = a * sigma + series.col(k) * Real(k * (k - 1));
  return a / (tau * tau);
}

template <class Real>
typename LinearLeg<Real>::Vector LinearLeg<Real>::pack(const Vector& u, const Vector& v) const {
  Vector y(size());
  y << u.segment(moving_begin_, moving_), v.segment(massive_begin_, massive_end_ - massive_begin_);
  return y;
}

template class LinearLeg<double>;
template class LinearLeg<long double>;

}  // namespace viscobar::exponential
