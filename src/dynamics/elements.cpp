#include "viscobar/dynamics/elements.hpp"

#include <algorithm>
#include <utility>

#include "discretisation/lanes.hpp"
#include "dynamics/pieces.hpp"

namespace viscobar {

namespace {

// Sum over the elements of weights[e], or 1, (difference of the ends' values)^2, the fixed neighbours being given.
double squared_differences(std::span<const double> x, const double* left, const double* right, const double* weights) {
  const std::size_t inner = x.size() - 1, first = left ? 1 : 0;
  const auto squared = [weights](double difference, std::size_t e) {
    return difference * difference * (weights ? weights[e] : 1.0);
  };
  const auto squares = [u = x.data()](auto&& at) {
    const Lanes difference = at(u + 1) - at(u);
    return Lanes(difference * difference);
  };
  double sum = weights ? sum_by_lanes(inner, [=, of = weights + first](auto&& at) { return squares(at) * at(of); })
                       : sum_by_lanes(inner, squares);
  if (left) sum += squared(x.front() - *left, 0);
  if (right) sum += squared(*right - x.back(), first + inner);
  return sum;
}

// The difference of the stresses on either side of each node; `left` and `right` are those beyond the first and the
// last one. Each stress is made twice, so that no node waits for another.
void forces_between(double left, double right, std::span<double> out, auto&& stress) {
  const std::size_t last = out.size() - 1;
  double* const force = out.data();
  force[0] = (last > 0 ? stress(0) : right) - left;
#pragma GCC ivdep
  for (std::size_t i = 1; i < last; ++i) force[i] = stress(i) - stress(i - 1);
  if (last > 0) force[last] = right - stress(last - 1);
}

double sum_beside(const std::vector<double>& of_elements, std::size_t node) {
  return (node > 0 ? of_elements[node - 1] : 0.0) + (node < of_elements.size() ? of_elements[node] : 0.0);
}

}  // namespace

Elements::Elements(const Scene& scene, const Mesh& mesh, const Unknowns& unknowns,
                   std::shared_ptr<const std::vector<Piece>> pieces)
    : mesh_(mesh), bar_(scene.bar), unknowns_(unknowns), chain_(!scene.chain.empty()), pieces_(std::move(pieces)) {
  const auto& section = pieces_->front().section;
  if (chain_)
    take_chain(scene);
  else if (section)
    places_ = section->places();
  for (std::size_t j = 0; !chain_ && (section || !mesh.uniform()) && j < mesh.elements; ++j)
    inverse_spacing_.push_back(1.0 / stretch(j));
  for (const double weight : inverse_spacing_) springs_.push_back(bar_.modulus * weight);
  for (const double weight : rate_weights()) dashpots_.push_back(bar_.viscosity * weight);
}

// Springs and dashpots of the elements of a chain, in those of its bar().
void Elements::take_chain(const Scene& scene) {
  inverse_spacing_.assign(mesh_.elements, 0.0);
  inverse_rate_ = inverse_spacing_;
  double fastest = 0.0;
  bool alike = true;
  for (std::size_t p = 0; p < pieces_->size(); ++p) {
    const Piece& piece = (*pieces_)[p];
    const double of_rate = bar_.viscosity > 0.0 ? piece.bar.viscosity / bar_.viscosity : 0.0;
    for (std::size_t e = 0; e < piece.mesh.elements; ++e) {
      inverse_spacing_[piece.first + e] = piece.bar.modulus / bar_.modulus / piece.stretch(e);
      inverse_rate_[piece.first + e] = of_rate / piece.stretch(e);
      fastest = std::max(fastest, piece.bar.wave_speed() / piece.mesh.element(e));
    }
    alike &= piece.rigid() || piece.bar.viscosity * bar_.modulus == bar_.viscosity * piece.bar.modulus;
    const Joint& joint = scene.chain[p].joint;
    if (p + 1 == pieces_->size() || joint.kind != JointKind::spring) continue;
    inverse_spacing_[piece.last()] = joint.stiffness / bar_.modulus;
    if (joint.damping > 0.0) inverse_rate_[piece.last()] = joint.damping / bar_.viscosity;
    alike &= joint.damping * bar_.modulus == joint.stiffness * bar_.viscosity;
  }
  if (alike) inverse_rate_.clear();
  finest_ = bar_.wave_speed() / fastest;
  for (std::size_t k = 0; k + 1 < scene.chain.size(); ++k)
    if (const Joint& joint = scene.chain[k].joint; joint.kind != JointKind::bonded)
      joints_.push_back(
          {k + 1, (*pieces_)[k + 1].first, joint.stiffness, joint.damping, joint.kind == JointKind::contact});
}

bool Elements::is_of_bar(std::size_t element) const {
  return std::ranges::any_of(*pieces_,
                             [element](const Piece& one) { return one.first <= element && element < one.last(); });
}

std::size_t Elements::beside(std::size_t unknown) const {
  const std::size_t node = unknown + unknowns_.first_node();
  if (!chain_) return std::min(node, mesh_.elements - 1);
  std::size_t nearest = 0;
  for (const Piece& piece : *pieces_) {
    if (piece.rigid()) continue;
    if (node < piece.first) break;
    if (node < piece.last()) return node;
    nearest = piece.last();
  }
  if (nearest > 0 && nearest == node) return node - 1;
  if (node < mesh_.elements && inverse_spacing_[node] > 0.0) return node;
  if (node > 0 && inverse_spacing_[node - 1] > 0.0) return node - 1;
  if (nearest > 0) return nearest - 1;
  return std::ranges::find_if(*pieces_, [](const Piece& piece) { return !piece.rigid(); })->first;
}

void Elements::force(std::span<const double> u, std::span<const double> w, std::span<double> out) const {
  const double stiffness = bar_.modulus / mesh_.spacing(), damping = bar_.viscosity / mesh_.spacing();
  if (!rows_alike())
    forces(u, w, out,
           [springs = springs_.data(), dashpots = dashpots_.data()](std::size_t e, double strain, double rate) {
             return springs[e] * strain + dashpots[e] * rate;
           });
  else if (bar_.damped())
    forces(u, w, out, [=](std::size_t, double strain, double rate) { return stiffness * strain + damping * rate; });
  else
    forces(u, w, out, [=](std::size_t, double strain, double) { return stiffness * strain; });
}

// By the stress(e, strain, rate) of each element, strains and rates times its length.
void Elements::forces(std::span<const double> u, std::span<const double> w, std::span<double> out,
                      auto&& stress) const {
  const std::size_t n = unknowns_.size();
  const double left = unknowns_.wall(false) ? stress(0, u[0] - *unknowns_.wall(false), w[0]) : 0.0;
  const double right =
      unknowns_.wall(true) ? stress(mesh_.elements - 1, *unknowns_.wall(true) - u[n - 1], -w[n - 1]) : 0.0;
  forces_between(left, right, out, [stress, u = u.data(), w = w.data(), first = unknowns_.first_node()](std::size_t i) {
    return stress(first + i, u[i + 1] - u[i], w[i + 1] - w[i]);
  });
}

double Elements::end_force(bool right, std::span<const double> u, std::span<const double> v) const {
  const std::size_t e = right ? mesh_.elements - 1 : 0;
  const double strain = u[e + 1] - u[e], rate = v[e + 1] - v[e];
  const double pull = rows_alike() ? (bar_.modulus * strain + bar_.viscosity * rate) / stretch(e)
                                   : springs_[e] * strain + dashpots_[e] * rate;
  return right ? pull : -pull;
}

double Elements::uniform_diagonal(std::size_t i) const {
  const bool bare_left = i == 0 && !unknowns_.left_fixed();
  const bool bare_right = i + 1 == unknowns_.size() && !unknowns_.right_fixed();
  return (2.0 - (bare_left ? 1.0 : 0.0) - (bare_right ? 1.0 : 0.0)) / mesh_.spacing();
}

double Elements::stiffness_diagonal(std::size_t i) const {
  if (rows_alike()) return uniform_diagonal(i);
  return sum_beside(inverse_spacing_, i + unknowns_.first_node());
}

void Elements::dynamic_stiffness(const BandedMatrix& inertia, double m, double c, double k, BandedMatrix& out) const {
  if (rows_alike()) {
    const double scale = c * bar_.viscosity + k * bar_.modulus, spring = scale / mesh_.spacing();
    assemble(
        inertia, m, [=](std::size_t) { return spring; }, out);
    for (const std::size_t i : {std::size_t{0}, unknowns_.size() - 1})
      out.diagonal[i] = m * inertia.diagonal[i] + scale * uniform_diagonal(i);
  } else {
    const auto spring = [=, springs = springs_.data(), dashpots = dashpots_.data()](std::size_t e) {
      return c * dashpots[e] + k * springs[e];
    };
    assemble(inertia, m, spring, out);
  }
  out.ties.clear();
  out.skew = inertia.skew;
  for (double& entry : out.skew) entry *= m;
  out.one_sided = inertia.one_sided;
  for (OneSidedRow& one : out.one_sided)
    for (double& entry : one.entries) entry *= m;
}

// out = m inertia + K of the spring(e) of each element.
void Elements::assemble(const BandedMatrix& inertia, double m, auto&& spring, BandedMatrix& out) const {
  const std::size_t n = unknowns_.size(), first = unknowns_.first_node(), last = mesh_.elements;
  out.diagonal.resize(n);
  out.off_diagonal.resize(n - 1);
  for (std::size_t i = 1; i + 1 < n; ++i)
    out.diagonal[i] = m * inertia.diagonal[i] + (spring(first + i - 1) + spring(first + i));
  for (const std::size_t i : {std::size_t{0}, n - 1}) {
    const std::size_t node = first + i;
    out.diagonal[i] =
        m * inertia.diagonal[i] + ((node > 0 ? spring(node - 1) : 0.0) + (node < last ? spring(node) : 0.0));
  }
  if (inertia.is_diagonal())
    for (std::size_t i = 0; i + 1 < n; ++i) out.off_diagonal[i] = -spring(first + i);
  else
    for (std::size_t i = 0; i + 1 < n; ++i) out.off_diagonal[i] = m * inertia.off_diagonal[i] - spring(first + i);
}

double Elements::squared_strain(std::span<const double> u) const {
  return squared_differences_of(u,
                                {unknowns_.wall(false) ? &*unknowns_.wall(false) : nullptr,
                                 unknowns_.wall(true) ? &*unknowns_.wall(true) : nullptr},
                                inverse_spacing_);
}

double Elements::squared_strain_rate(std::span<const double> w) const {
  const double still = 0.0;
  return squared_differences_of(w, {unknowns_.wall(false) ? &still : nullptr, unknowns_.wall(true) ? &still : nullptr},
                                rate_weights());
}

double Elements::squared_differences_of(std::span<const double> x, std::array<const double*, 2> walls,
                                        std::span<const double> weights) const {
  if (rows_alike()) return squared_differences(x, walls[0], walls[1], nullptr) / mesh_.spacing();
  return squared_differences(x, walls[0], walls[1], weights.data());
}

}  // namespace viscobar
