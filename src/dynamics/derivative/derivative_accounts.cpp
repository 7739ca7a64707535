// Derivatives of forces, impulses and energies.
#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "dynamics/derivative/derivative.hpp"

namespace viscobar {

double Derivative::holding_force(bool right, double t, const Nodal& bar, const Nodal& s) const {
  const std::size_t element = right ? system_.bar().mesh().elements - 1 : 0;
  const auto stretch = [&](std::span<const double> x) { return x[element + 1] - x[element]; };
  const double pull = matrices_.elastic()[element] * stretch(bar.u) + matrices_.viscous()[element] * stretch(bar.v);
  double inertia = 0.0;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, bar.a.size()); ++k)
    inertia += matrices_.held(right)[k] * bar.a[right ? bar.a.size() - 1 - k : k];
  const auto at = [](std::span<const double> x) { return [x](std::size_t j) { return x[j]; }; };
  double resisted = 0.0;
  for (const SideRows& side : sides_) resisted += side.at_end(right, side.resistance(at(bar.u), at(bar.v)));
  return (right ? pull : -pull) + resisted + inertia +
         system_.bar().holding_force(right, s.u, s.v, s.a, motion_.load().held(right, t));
}

double Derivative::momentum(std::size_t end, const EndRows& rows, const Moment& at, std::span<const double> s,
                            std::span<const double> rate) const {
  if (rows.by_law) return 0.0;
  const std::size_t last = rows.last;
  const auto times = [&](const BandedMatrix& inertia, std::span<const double> x) {
    double sum = 0.0;
    for (std::size_t j = std::min(end, last); j <= std::max(end, last); ++j) {
      sum += inertia.diagonal[j] * x[j];
      if (!inertia.is_diagonal() && j > 0) sum += inertia.below(j - 1) * x[j - 1];
      if (!inertia.is_diagonal() && j + 1 < x.size()) sum += inertia.above(j) * x[j + 1];
      for (const OneSidedRow& one : inertia.one_sided)
        if (one.row == j) sum += one.times(x);
    }
    return sum;
  };
  const BarSystem& bar = system_.bar();
  double sum = times(bar.inertia().matrix(), rate) + (matrices_.inertial() ? times(matrices_.inertia(), at.w) : 0.0);
  if (rows.strained) {
    const std::size_t element = bar.elements().beside(last);
    sum += bar.bar().viscosity / bar.elements().rate_stretch(element) * stretch(end, last, s, {}, data_) +
           matrices_.viscous()[element] * stretch(end, last, at.u, contacts_.origin().values(), bar);
    if (bar.frame().moving()) sum += matrices_.viscous()[element] * lift_stretch(end, last, lift_[0]);
    if (const SideRows* own = bar.side()) {
      const auto of_s = data_.unknowns().displacement_at_nodes(s);
      sum += at_last(end, rows, *own, [&](std::size_t j) { return own->drag(j) * of_s(j); });
    }
    for (const SideRows& side : sides_)
      sum += at_last(end, rows, side, [&, u = placed(at.u)](std::size_t j) { return side.drag(j) * u(j); });
  }
  if (bar.frame().moving())
    for (std::size_t j = std::min(end, last); j <= std::max(end, last); ++j) sum += lift_inertia(j, lift_[1]);
  for (const Support& support : bar.supports())
    if (support.unknown == end) sum += support.dashpot * s[end];
  for (const Support& support : supports_)
    if (support.unknown == end)
      sum += support.dashpot * displacement(end, at.u) +
             support.mass * (at.w[end] + lift_[1].of(bar.unknowns().is_right(end)));
  return sum;
}

double Derivative::elastic_row(std::size_t end, const EndRows& rows, double u, double u_stretch, double s,
                               double s_stretch) const {
  const BarSystem& bar = system_.bar();
  double sum = 0.0;
  if (rows.strained) {
    const std::size_t element = bar.elements().beside(rows.last);
    sum = bar.bar().modulus / bar.elements().stretch(element) * s_stretch + matrices_.elastic()[element] * u_stretch;
  }
  for (const Support& support : bar.supports())
    if (support.unknown == end) sum += support.stiffness * s;
  for (const Support& support : supports_)
    if (support.unknown == end) sum += support.stiffness * u;
  return sum;
}

double Derivative::momentum_loss(std::size_t end, const Moment& at, std::span<const double> s, double s_rate) {
  const BarSystem& bar = system_.bar();
  const EndRows rows = end_rows(contacts_, end);
  if (rows.by_law) {
    const std::size_t i = *contact_of_body(contacts_, bar.unknowns().is_right(end));
    return contacts_.closed(i) ? law_reaction(i, at, s, s_rate) : 0.0;
  }
  const std::size_t last = rows.last;
  double sum = 0.0;
  if (rows.strained) {
    sum = elastic_row(end, rows, displacement(end, at.u), stretch(end, last, at.u, contacts_.origin().values(), bar),
                      s[end], stretch(end, last, s, {}, data_)) +
          side_row(end, rows, placed(at.u), data_.unknowns().displacement_at_nodes(s));
    if (bar.frame().moving())
      sum += matrices_.elastic()[bar.elements().beside(last)] * lift_stretch(end, last, lift_[0]);
  } else {
    sum = elastic_row(end, rows, displacement(end, at.u), 0.0, s[end], 0.0);
  }
  for (std::size_t j = std::min(end, last); j <= std::max(end, last); ++j)
    sum -= motion_.load().at(j, at.t) - added_[j];
  return sum;
}

double Derivative::energy(const Moment& at, std::span<const double> s, std::span<const double> rate) const {
  const BarSystem& bar = system_.bar();
  const Mesh& mesh = bar.mesh();
  // Fields of the bar itself, over all nodes.
  std::vector<double> u(mesh.nodes()), w(u), of_u(u), of_w(u);
  bar.unknowns().expand_displacement(at.u, u);
  const std::span<const double> origin = contacts_.origin().values();
  for (std::size_t i = 0; i < origin.size(); ++i) u[i + bar.unknowns().first_node()] += origin[i];
  bar.unknowns().expand_velocity(at.w, w);
  bar.frame().add_lift(lift_[0], u);
  bar.frame().add_lift(lift_[1], w);
  expand(at.t, s, rate, of_u, of_w);
  const bool whole = bar.frame().moving();
  const BandedMatrix& inertia = whole ? bar.inertia().whole() : bar.inertia().matrix();
  const std::size_t first = whole ? 0 : bar.unknowns().first_node(), n = inertia.size();
  const double *v = w.data() + first, *of_v = of_w.data() + first;
  double sum = 0.0;
  if (matrices_.inertial()) sum = 0.5 * (whole ? matrices_.whole() : matrices_.inertia()).quadratic_form({v, n});
  for (std::size_t i = 0; i < n; ++i) sum += inertia.diagonal[i] * v[i] * of_v[i];
  for (std::size_t i = 0; i + 1 < n && !inertia.off_diagonal.empty(); ++i)
    sum += inertia.off_diagonal[i] * (v[i] * of_v[i + 1] + v[i + 1] * of_v[i]);
  for (std::size_t j = 0; j < mesh.elements; ++j) {
    const double strain = u[j + 1] - u[j], of_strain = of_u[j + 1] - of_u[j];
    sum += bar.bar().modulus / bar.elements().stretch(j) * strain * of_strain +
           0.5 * matrices_.elastic()[j] * strain * strain;
  }
  const auto nodal = [](const std::vector<double>& x) { return [&x](std::size_t j) { return x[j]; }; };
  if (bar.side()) sum += bar.side()->energy_product(nodal(u), nodal(of_u));
  for (const SideRows& side : sides_) sum += side.energy(nodal(u));
  const auto end = [&](const Support& support) { return support.unknown + bar.unknowns().first_node(); };
  for (const Support& support : bar.supports()) sum += support.stiffness * u[end(support)] * of_u[end(support)];
  for (const Support& support : supports_)
    sum += 0.5 * support.stiffness * u[end(support)] * u[end(support)] +
           0.5 * support.mass * w[end(support)] * w[end(support)];
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    const double clearance = contacts_.clearance(i, at.u);
    if (contacts_[i].holds || contacts_[i].moves || clearance >= 0.0) continue;
    if (contacts_[i].law.stop() && !contacts_.closed(i)) continue;
    if (const Stop* law = contacts_[i].law.bent()) {
      sum += law->energy(-clearance) * laws_[i].stiffness / law->stiffness;
      sum -= law->force(-clearance, 0.0) * of_contacts_.clearance(i, s);
      continue;
    }
    sum += clearance *
           (contacts_[i].law.linear().stiffness * of_contacts_.clearance(i, s) + 0.5 * laws_[i].stiffness * clearance);
  }
  return sum;
}

std::vector<double> Derivative::joint_forces(const Moment& at, std::span<const double> s,
                                             std::span<const double> rate) {
  std::vector<double> forces;
  const BarSystem& bar = system_.bar();
  for (const JointNodes& joint : bar.elements().joints()) {
    const std::size_t element = joint.node - 1;
    const auto apart = [&](auto&& of) { return of(joint.node) - of(element); };
    if (!joint.contact) {
      forces.push_back(-joint.stiffness * apart(data_.unknowns().displacement_at_nodes(s)) -
                       joint.damping * apart(data_.unknowns().at_nodes(rate)) -
                       matrices_.elastic()[element] * apart(bar.unknowns().displacement_at_nodes(at.u)) -
                       matrices_.viscous()[element] * apart(bar.unknowns().at_nodes(at.w)));
      continue;
    }
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      if (contacts_[i].joint == joint.number) forces.push_back(reaction(i, at, s, rate));
  }
  return forces;
}

}  // namespace viscobar
