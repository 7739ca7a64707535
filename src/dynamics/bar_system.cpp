#include "viscobar/dynamics/bar_system.hpp"

#include <cassert>

#include "discretisation/lane_factor.hpp"
#include "dynamics/finite_load.hpp"
#include "dynamics/moments.hpp"
#include "dynamics/pieces.hpp"
#include "scene/end_kinds.hpp"

namespace viscobar {

namespace {

std::vector<double> part_of(std::span<const double> entries, std::size_t first, std::size_t count) {
  const auto part = entries.subspan(first, count);
  return {part.begin(), part.end()};
}

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

// The block of the unknowns from `begin` to `end`, mostly all of them.
void factorise_block(TridiagonalFactor& factor, const BandedMatrix& matrix, std::size_t begin, std::size_t end) {
  if (begin == 0 && end == matrix.size()) return factor.factorise(matrix);
  factor.factorise(restrict_to(matrix, begin, end - begin));
}

double uniform_stiffness_diagonal(const BarSystem& system, std::size_t i) {
  const bool bare_left = i == 0 && !system.left_fixed();
  const bool bare_right = i + 1 == system.size() && !system.right_fixed();
  return (2.0 - (bare_left ? 1.0 : 0.0) - (bare_right ? 1.0 : 0.0)) / system.mesh().spacing();
}

}  // namespace

BarSystem::BarSystem(const Scene& scene, const Mesh& mesh, Mass mass)
    : mesh_(mesh),
      mass_(mass),
      bar_(scene.bar),
      chain_(!scene.chain.empty()),
      pieces_(std::make_shared<const std::vector<Piece>>(pieces_of(scene, mesh))),
      inputs_{scene.left_input, scene.right_input} {
  const std::array<EndNode, 2> ends = {end_node(scene.left, scene.displacement(0.0)),
                                       end_node(scene.right, scene.displacement(mesh.length))};
  walls_ = {ends[0].held, ends[1].held};
  const std::size_t fixed = static_cast<std::size_t>(left_fixed()) + static_cast<std::size_t>(right_fixed());
  if (mesh.nodes() <= fixed)
    throw std::invalid_argument("both ends are fixed and the mesh has no node between them: 2 elements are needed");
  const std::size_t first = first_node(), n = mesh.nodes() - fixed;

  const bool redistributed = mass == Mass::redistributed;
  if (redistributed && scene.span)
    throw std::invalid_argument(
        "mass \"redistributed\" does not fit a span obstacle: every node is a contact node and must keep its mass");
  if (chain_ && (redistributed || mass == Mass::paper))
    throw std::invalid_argument("masses \"redistributed\" and \"paper\" do not fit several bars in line");
  if (chain_ && scene.span) throw std::invalid_argument("several bars in line do not fit a span obstacle");
  massless_ = {redistributed && is_bare_obstacle(scene.left, scene.left_input),
               redistributed && is_bare_obstacle(scene.right, scene.right_input)};
  if (redistributed && end_obstacles(scene) > 0 && !has_massless())
    throw std::invalid_argument(
        "mass \"redistributed\" does not fit a spring, a dashpot, a mass or a stop with a law of its own at an end, whose "
        "node must keep its mass");
  if (chain_) {
    take_elements(scene);
  } else {
    const auto& section = pieces_->front().section;
    if (section) places_ = section->places();
    for (std::size_t j = 0; (section || !mesh.uniform()) && j < mesh.elements; ++j)
      inverse_spacing_.push_back(1.0 / stretch(j));
  }
  whole_inertia_ = inertia_of(*pieces_, mass, massless_);
  if (scene.side) {
    const auto unit_inertia = [&](const Piece& piece) {
      return inertia_matrix(piece.mesh, mass, massless_[0], massless_[1], piece.section.get());
    };
    side_.emplace(assembled(*pieces_, unit_inertia), side_values(scene.side->stiffness, scene.side->stiffness_places),
                  side_values(scene.side->drag, scene.side->drag_places));
  }
  inertia_ = restrict_to(whole_inertia_, first, n);
  for (const bool right : {false, true})
    if (walls_[right]) held_rows_[right] = whole_inertia_.end_row(right);
  factorise_block(massive_factor_, inertia_, massive_begin(), massive_end());

  const auto bound = [&](std::size_t unknown, const std::optional<Obstacle>& obstacle, double weight, Where where) {
    if (!obstacle) return;
    if (obstacle->bounds(Side::below)) contacts_.push_back({unknown, obstacle->gap, weight, where, 1.0});
    if (obstacle->bounds(Side::above)) contacts_.push_back({unknown, obstacle->gap, weight, where, -1.0});
  };
  bound(0, ends[0].obstacle, 1.0, Where::left);
  bound(n - 1, ends[1].obstacle, 1.0, Where::right);
  std::vector<double> displacement(mesh.nodes()), velocity(mesh.nodes());
  for (std::size_t p = pieces_->size(); p-- > 0;)  // a node that two have is the left one's
    for (std::size_t j = 0; j < (*pieces_)[p].mesh.nodes(); ++j) {
      const Piece& piece = (*pieces_)[p];
      displacement[piece.first + j] = piece.displacement(piece.mesh.node(j));
      velocity[piece.first + j] = piece.velocity(piece.mesh.node(j));
    }
  initial_ = {part_of(displacement, first, n), part_of(velocity, first, n)};
  for (std::size_t i = 0; scene.span && i < n; ++i) {
    const std::size_t node = i + first;
    const double before = node > 0 ? mesh.element(node - 1) : 0.0;
    const double after = node < mesh.elements ? mesh.element(node) : 0.0;
    bound(i, scene.span, (before + after) / 2, Where::span);
  }
  take_joints(scene);

  for (const bool right : {false, true}) {
    const EndInput& input = inputs_[right];
    if (walls_[right] || (input.stiffness == 0.0 && input.dashpot == 0.0 && input.mass == 0.0)) continue;
    supports_.push_back({end(right), input.stiffness, input.dashpot, input.mass});
  }
  const bool moved = inputs_[0].motion || inputs_[1].motion;
  if (moved && scene.span)
    throw std::invalid_argument("a span obstacle stands still, and does not fit ends that are moved");
  free_ = {std::holds_alternative<Free>(scene.left), std::holds_alternative<Free>(scene.right)};
  if (moving()) {
    enter_frame();
    const Lift rate = lift(0.0, 1);
    for (std::size_t i = 0; i < size(); ++i) initial_.v[i] -= rate.at(share(i));
  }
  if (auto moments = moments_of("the initial velocity", scene.velocity, scene.velocity_places, Moments::of_velocity);
      !moments.empty())
    start_from(std::move(moments));
  else if (mass == Mass::fourth_order && fixed > 0)
    stop_fixed_ends(scene);
  add_masses();
  if (!moved) whole_inertia_ = {};

  if (scene.load) {
    const BandedMatrix load_mass =
        assembled(*pieces_, [&](const Piece& piece) { return mass_matrix(piece.mesh, mass, piece.section.get()); });
    const auto weighted = [&](const SpaceFunction& profile, const Places& places) {
      std::vector<double> values(mesh.nodes()), product = moments_of("the load", profile, places, Moments::of_load);
      if (product.empty()) {
        product = values;
        for (std::size_t j = 0; j < values.size(); ++j) values[j] = profile(mesh.node(j));
        load_mass.multiply(values, product);
      }
      return SteadyVector{part_of(product, first, n), {product.front(), product.back()}};
    };
    if (const auto* steady = std::get_if<SteadyLoad>(&*scene.load)) load_ = weighted(steady->profile, steady->places);
    if (const auto* separable = std::get_if<SeparableLoad>(&*scene.load)) {
      const SteadyVector profile = weighted(separable->profile, separable->places);
      load_ = SeparableVector{profile.weighted, profile.held, separable->history, separable->breaks};
    }
    if (const auto* general = std::get_if<GeneralLoad>(&*scene.load))
      load_ = GeneralVector{general->density, general->breaks, general->breaks_at, general->breaks_in_x, load_mass};
  }
  take_forces();
}

// Springs and dashpots of the elements of a chain, in those of its bar().
void BarSystem::take_elements(const Scene& scene) {
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
}

void BarSystem::take_joints(const Scene& scene) {
  for (std::size_t k = 0; k + 1 < scene.chain.size(); ++k) {
    const Joint& joint = scene.chain[k].joint;
    joint_stops_.push_back(joint.stop);
    if (joint.kind == JointKind::bonded) continue;
    const std::size_t node = (*pieces_)[k + 1].first;
    joints_.push_back({k + 1, node, joint.stiffness, joint.damping, joint.kind == JointKind::contact});
    if (joint.kind != JointKind::contact) continue;
    if (node < first_node() + 1 || node >= first_node() + size())
      throw std::invalid_argument("a contact lies between two bars or bodies that move, and one of them is fixed");
    contacts_.push_back({node - first_node(), joint.gap, 1.0, Where::joint, 1.0, k + 1});
  }
}

bool BarSystem::is_element_of_bar(std::size_t element) const {
  return std::ranges::any_of(*pieces_,
                             [element](const Piece& one) { return one.first <= element && element < one.last(); });
}

std::size_t BarSystem::element_at(std::size_t unknown) const {
  const std::size_t node = unknown + first_node();
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

// The data at the beginning do not depend on them.
void BarSystem::add_masses() {
  if (std::ranges::all_of(supports_, [](const Support& support) { return support.mass == 0.0; })) return;
  for (const Support& support : supports_) {
    inertia_.diagonal[support.unknown] += support.mass;
    whole_inertia_.diagonal[support.unknown + first_node()] += support.mass;
  }
  factorise_block(massive_factor_, inertia_, massive_begin(), massive_end());
  if (moving()) enter_frame();
}

// Forces that are always the same become part of a load that is.
void BarSystem::take_forces() {
  if (!inputs_[0].force && !inputs_[1].force) return;
  varying_forces_ = (load_ && !std::holds_alternative<SteadyVector>(*load_)) ||
                    std::ranges::any_of(inputs_, [](const EndInput& one) { return one.force && !one.force->steady; });
  if (varying_forces_) return;
  if (!load_) load_ = SteadyVector{std::vector<double>(size(), 0.0)};
  std::vector<double>& weighted = std::get<SteadyVector>(*load_).weighted;
  for (const bool right : {false, true})
    if (inputs_[right].force && !walls_[right]) weighted[end(right)] += inputs_[right].force->value(0.0);
}

double BarSystem::held_inertia(bool right, std::span<const double> a) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, a.size()); ++k)
    sum += held_rows_[right][k] * a[right ? a.size() - 1 - k : k];
  return sum;
}

double BarSystem::holding_force(bool right, std::span<const double> u, std::span<const double> v,
                                std::span<const double> a, double load) const {
  const std::size_t e = right ? mesh_.elements - 1 : 0;
  const double pull = inverse_rate_.empty()
                          ? (bar_.modulus * (u[e + 1] - u[e]) + bar_.viscosity * (v[e + 1] - v[e])) / stretch(e)
                          : bar_.modulus * (u[e + 1] - u[e]) * inverse_spacing_[e] +
                                bar_.viscosity * (v[e + 1] - v[e]) * inverse_rate_[e];
  const double force = (right ? pull : -pull) + held_inertia(right, a) - load;
  if (!side_) return force;
  return force + side_->at_end(right, side_->resistance([u](std::size_t j) { return u[j]; },
                                                        [v](std::size_t j) { return v[j]; }));
}

void BarSystem::internal_force(std::span<const double> u, std::span<const double> w, std::span<double> out) const {
  if (rows_alike())
    uniform_force(u, w, out);
  else
    inverse_rate_.empty() ? graded_force(u, w, out) : unlike_force(u, w, out);
  for (const Support& support : supports_)
    out[support.unknown] -= support.stiffness * u[support.unknown] + support.dashpot * w[support.unknown];
  if (side_) side_->subtract(side_->resistance(displacement_at_nodes(u), at_nodes(w)), first_node(), size(), out);
}

void BarSystem::uniform_force(std::span<const double> u, std::span<const double> w, std::span<double> out) const {
  const std::size_t n = size();
  const double stiffness = bar_.modulus / mesh_.spacing(), damping = bar_.viscosity / mesh_.spacing();
  // Stress on the left of the first and on the right of the last unknown: none at an end that is not fixed.
  const double left = walls_[0] ? stiffness * (u[0] - *walls_[0]) + damping * w[0] : 0.0;
  const double right = walls_[1] ? stiffness * (*walls_[1] - u[n - 1]) - damping * w[n - 1] : 0.0;
  if (damped())
    forces_between(left, right, out,
                   [=](std::size_t i) { return stiffness * (u[i + 1] - u[i]) + damping * (w[i + 1] - w[i]); });
  else
    forces_between(left, right, out, [=](std::size_t i) { return stiffness * (u[i + 1] - u[i]); });
}

void BarSystem::graded_force(std::span<const double> u, std::span<const double> w, std::span<double> out) const {
  const double modulus = bar_.modulus, viscosity = bar_.viscosity;
  const auto stress = [=, per_size = inverse_spacing_.data()](std::size_t e, double strain, double rate) {
    return per_size[e] * (modulus * strain + viscosity * rate);
  };
  unlike_forces(u, w, out, stress);
}

// Where elasticity and viscosity differ from one element to the next.
void BarSystem::unlike_force(std::span<const double> u, std::span<const double> w, std::span<double> out) const {
  const auto stress = [modulus = bar_.modulus, viscosity = bar_.viscosity, elastic = inverse_spacing_.data(),
                       viscous = inverse_rate_.data()](std::size_t e, double strain, double rate) {
    return modulus * elastic[e] * strain + viscosity * viscous[e] * rate;
  };
  unlike_forces(u, w, out, stress);
}

// Forces by the stress(e, strain, rate) of each element.
void BarSystem::unlike_forces(std::span<const double> u, std::span<const double> w, std::span<double> out,
                              auto&& stress) const {
  const std::size_t n = size();
  const double left = walls_[0] ? stress(0, u[0] - *walls_[0], w[0]) : 0.0;
  const double right = walls_[1] ? stress(mesh_.elements - 1, *walls_[1] - u[n - 1], -w[n - 1]) : 0.0;
  forces_between(left, right, out, [stress, u = u.data(), w = w.data(), first = first_node()](std::size_t i) {
    return stress(first + i, u[i + 1] - u[i], w[i + 1] - w[i]);
  });
}

namespace {

double sum_beside(const std::vector<double>& of_elements, std::size_t node) {
  return (node > 0 ? of_elements[node - 1] : 0.0) + (node < of_elements.size() ? of_elements[node] : 0.0);
}

}  // namespace

double BarSystem::stiffness_diagonal(std::size_t i) const {
  if (rows_alike()) return uniform_stiffness_diagonal(*this, i);
  return sum_beside(inverse_spacing_, i + first_node());
}

void BarSystem::dynamic_stiffness(double m, double c, double k, BandedMatrix& out) const {
  const double scale = c * bar_.viscosity + k * bar_.modulus;
  if (rows_alike())
    uniform_stiffness(m, scale, out);
  else
    inverse_rate_.empty() ? graded_stiffness(m, scale, out) : unlike_stiffness(m, c, k, out);
  out.ties.clear();
  out.skew = inertia_.skew;
  for (double& entry : out.skew) entry *= m;
  out.one_sided = inertia_.one_sided;
  for (OneSidedRow& one : out.one_sided)
    for (double& entry : one.entries) entry *= m;
  for (const Support& support : supports_) out.diagonal[support.unknown] += c * support.dashpot + k * support.stiffness;
  if (side_) side_->add_to(out, first_node(), c, k);
}

void BarSystem::uniform_stiffness(double m, double scale, BandedMatrix& out) const {
  const std::size_t n = size();
  const double off = -scale / mesh_.spacing();
  out.diagonal.resize(n);
  out.off_diagonal.resize(n - 1);
  const double inner = 2.0 * scale / mesh_.spacing();
  for (std::size_t i = 0; i < n; ++i) out.diagonal[i] = m * inertia_.diagonal[i] + inner;
  out.diagonal[0] = m * inertia_.diagonal[0] + scale * uniform_stiffness_diagonal(*this, 0);
  out.diagonal[n - 1] = m * inertia_.diagonal[n - 1] + scale * uniform_stiffness_diagonal(*this, n - 1);
  if (inertia_.is_diagonal())
    std::ranges::fill(out.off_diagonal, off);
  else
    for (std::size_t i = 0; i + 1 < n; ++i) out.off_diagonal[i] = m * inertia_.off_diagonal[i] + off;
}

void BarSystem::graded_stiffness(double m, double scale, BandedMatrix& out) const {
  const std::size_t n = size(), first = first_node();
  out.diagonal.resize(n);
  out.off_diagonal.resize(n - 1);
  for (std::size_t i = 0; i < n; ++i) out.diagonal[i] = m * inertia_.diagonal[i] + scale * stiffness_diagonal(i);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double mass = inertia_.is_diagonal() ? 0.0 : m * inertia_.off_diagonal[i];
    out.off_diagonal[i] = mass - scale * inverse_spacing_[first + i];
  }
}

void BarSystem::unlike_stiffness(double m, double c, double k, BandedMatrix& out) const {
  const std::size_t n = size(), first = first_node();
  out.diagonal.resize(n);
  out.off_diagonal.resize(n - 1);
  const double viscous = c * bar_.viscosity, elastic = k * bar_.modulus;
  for (std::size_t i = 0; i < n; ++i)
    out.diagonal[i] = m * inertia_.diagonal[i] + elastic * sum_beside(inverse_spacing_, first + i) +
                      viscous * sum_beside(inverse_rate_, first + i);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double mass = inertia_.is_diagonal() ? 0.0 : m * inertia_.off_diagonal[i];
    out.off_diagonal[i] = mass - (elastic * inverse_spacing_[first + i] + viscous * inverse_rate_[first + i]);
  }
}

double BarSystem::squared_strain(std::span<const double> u) const {
  return squared_differences_of(u, {walls_[0] ? &*walls_[0] : nullptr, walls_[1] ? &*walls_[1] : nullptr},
                                inverse_spacing_);
}

double BarSystem::squared_strain_rate(std::span<const double> w) const {
  const double still = 0.0;
  return squared_differences_of(w, {walls_[0] ? &still : nullptr, walls_[1] ? &still : nullptr}, rate_weights());
}

double BarSystem::squared_differences_of(std::span<const double> x, std::array<const double*, 2> walls,
                                         std::span<const double> weights) const {
  if (rows_alike()) return squared_differences(x, walls[0], walls[1], nullptr) / mesh_.spacing();
  return squared_differences(x, walls[0], walls[1], weights.data());
}

double BarSystem::energy(std::span<const double> u, std::span<const double> w) const {
  double sum = 0.5 * inertia_.quadratic_form(w) + 0.5 * bar_.modulus * squared_strain(u);
  for (const Support& support : supports_) sum += 0.5 * support.stiffness * u[support.unknown] * u[support.unknown];
  return side_ ? sum + side_->energy(displacement_at_nodes(u)) : sum;
}

bool BarSystem::has_dashpots() const {
  return std::ranges::any_of(supports_, [](const Support& support) { return support.dashpot > 0.0; });
}

void BarSystem::expand_displacement(std::span<const double> u, std::span<double> nodal) const {
  assert(nodal.size() == mesh_.nodes());
  if (walls_[0]) nodal.front() = *walls_[0];
  if (walls_[1]) nodal.back() = *walls_[1];
  std::ranges::copy(u, nodal.subspan(first_node()).begin());
}

void BarSystem::expand_velocity(std::span<const double> w, std::span<double> nodal) const {
  assert(nodal.size() == mesh_.nodes());
  if (walls_[0]) nodal.front() = 0.0;
  if (walls_[1]) nodal.back() = 0.0;
  std::ranges::copy(w, nodal.subspan(first_node()).begin());
}

// Held nodes that the initial velocity does not leave at rest stop at once, and the rows beside them keep their share
// of the momentum: rho M (w - u_1) = 0 over the unknowns, u_1 of the held nodes included. Without it the error is
// O(h^2).
void BarSystem::stop_fixed_ends(const Scene& scene) {
  const Lift rate = moving() ? lift(0.0, 1) : Lift{};
  const std::vector<double>& coupling = whole_inertia_.off_diagonal;
  std::vector<double> gained(size());
  if (left_fixed()) gained.front() += coupling.front() * (scene.velocity(0.0) - rate.at(0.0));
  if (right_fixed()) gained.back() += coupling.back() * (scene.velocity(mesh_.length) - rate.at(1.0));
  if (std::ranges::all_of(gained, [](double momentum) { return momentum == 0.0; })) return;
  accelerate(gained);
  for (std::size_t i = 0; i < size(); ++i) initial_.v[i] += gained[i];
}

namespace {

// Those places of detail, and between them pieces that grow to either side of a stretch by no more than two: the flanks
// of a pulse have their share of its moment.
std::vector<double> graded(const NextBreak& detail, double length) {
  std::vector<double> places, all;
  for (auto at = detail(0.0, length); at; at = detail(*at, length)) places.push_back(*at);
  const auto towards_middle = [&](double from, double size, double middle) {
    for (double at = from + size; (middle - at) * size > 0.0; size *= 2.0, at += size) all.push_back(at);
  };
  for (std::size_t k = 0; k <= places.size() && !places.empty(); ++k) {
    const double a = k > 0 ? places[k - 1] : 0.0, b = k < places.size() ? places[k] : length;
    const double middle = k == 0 ? a : k == places.size() ? b : 0.5 * (a + b);
    if (k > 0) all.push_back(a);
    if (k > 1) towards_middle(a, a - places[k - 2], middle);
    if (k + 1 < places.size()) towards_middle(b, b - places[k + 1], middle);
  }
  std::ranges::sort(all);
  return all;
}

}  // namespace

// Where k jumps, or has detail that nodes do not see, int phi_i k dx / int phi_i dx: their sum has all of it.
std::vector<double> BarSystem::side_values(const SpaceFunction& f, const Places& places) const {
  std::vector<double> values;
  if (!f) return values;
  for (std::size_t j = 0; j < mesh_.nodes(); ++j) values.push_back(f(mesh_.node(j)));
  const std::vector<double> moments = moments_of("the resistance of the side", f, places, Moments::of_side);
  if (moments.empty()) return values;
  const std::vector<double> weights = moments_of(
      "one", [](double) { return 1.0; }, places, Moments::of_side);
  for (std::size_t j = 0; j < values.size(); ++j)
    if (weights[j] > 0.0) values[j] = moments[j] / weights[j];
  return values;
}

// None where nothing is known; and what is smooth has none but on `fourth_order`, unless its detail is finer than a
// quarter of an element. Bonded members of unlike velocities have one by their momentum.
std::vector<double> BarSystem::moments_of(std::string_view what, const SpaceFunction& f, const Places& places,
                                          Moments of) const {
  std::vector<double> moments;
  if (!places.breaks) return moments;
  const bool velocity = of == Moments::of_velocity;
  const double length = mesh_.length;
  const std::vector<double> detail = graded(places.detail, length);
  bool needed = (mass_ == Mass::fourth_order && of != Moments::of_side) || places.breaks(0.0, length);
  for (std::size_t p = 1; p < pieces_->size() && velocity; ++p) {
    const Piece &left = (*pieces_)[p - 1], &right = (*pieces_)[p];
    needed |= left.last() == right.first && left.velocity(left.mesh.length) != right.velocity(0.0);  // bonded
  }
  for (std::size_t k = 1; k < detail.size() && !needed; ++k) needed = detail[k] - detail[k - 1] < mesh_.spacing() / 4.0;
  if (!needed) return moments;
  const auto next_detail = [&](double after, double until) -> std::optional<double> {
    const auto next = std::ranges::upper_bound(detail, after);
    return next != detail.end() && *next < until ? std::optional(*next) : std::nullopt;
  };
  const NextBreak next_break = either_of(places.breaks, next_detail);
  moments.resize(mesh_.nodes());
  std::vector<double> own;
  for (const Piece& piece : *pieces_) {
    const auto value = [&](double x) {
      return finite_load(
          0.0, [&] { return velocity ? piece.velocity(x) : f(piece.begin + x); },
          [&] { return fmt::format("{} at x = {}", what, piece.begin + x); });
    };
    own.assign(piece.mesh.nodes(), 0.0);
    add_moments(piece.mesh, mass_, piece.section.get(), 0, piece.mesh.elements, value, shifted(next_break, piece.begin),
                [&](std::size_t node, double part) { own[node] += part; });
    const double density = velocity ? piece.bar.density : 1.0;
    for (std::size_t j = 0; j < own.size(); ++j) moments[piece.first + j] += density * own[j];
    if (piece.rigid() && velocity) moments[piece.first] += piece.mass * piece.velocity(0.0);
  }
  return moments;
}

// rho M w = int rho phi_i u_1 over the unknowns, held nodes at rest from the first moment on. A node without mass has
// the velocity to which its neighbours' extends, and they have its moment.
void BarSystem::start_from(std::vector<double> moments) {
  if (moving()) {
    const Lift rate = lift(0.0, 1);
    std::vector<double> frame(mesh_.nodes()), product(frame);
    add_lift(rate, frame);
    whole_inertia_.multiply(frame, product);
    for (std::size_t j = 0; j < moments.size(); ++j) moments[j] -= product[j];
  }
  const std::size_t last = mesh_.elements, first = first_node();
  const double left = stretch(0) / stretch(std::min<std::size_t>(1, last - 1));
  const double right = stretch(last - 1) / stretch(last < 2 ? 0 : last - 2);
  const auto give = [&](std::size_t end, std::size_t next, std::size_t inner, double ratio) {
    moments[next] += (1.0 + ratio) * moments[end];
    moments[inner] -= ratio * moments[end];
  };
  if (massless_[0]) give(0, 1, 2, left);
  if (massless_[1]) give(last, last - 1, last - 2, right);
  std::vector<double>& w = moments;  // over all nodes
  accelerate(std::span(w).subspan(first, size()));
  if (left_fixed()) w.front() = 0.0;
  if (right_fixed()) w.back() = 0.0;
  if (massless_[0]) w[0] = (1.0 + left) * w[1] - left * w[2];
  if (massless_[1]) w[last] = (1.0 + right) * w[last - 1] - right * w[last - 2];
  initial_.v = part_of(w, first, size());
}

void BarSystem::accelerate(std::span<double> force) const {
  if (massless_[0]) force.front() = 0.0;
  if (massless_[1]) force.back() = 0.0;
  massive_factor_.solve(force.subspan(massive_begin(), massive_end() - massive_begin()));
}

std::vector<double> BarSystem::effective_masses() const {
  const std::size_t begin = massive_begin();
  const std::vector<double> inverse = inverse_diagonal(restrict_to(inertia_, begin, massive_end() - begin));
  std::vector<double> masses(size(), 0.0);
  for (std::size_t i = 0; i < inverse.size(); ++i) masses[begin + i] = 1.0 / inverse[i];
  return masses;
}

double BarSystem::contact_mass(const Contact& contact) const {
  const std::size_t i = contact.unknown;
  if (contact.joint > 0) {  // of two nodes that a force pushes apart
    std::vector<double> gained(size());
    gained[i] = 1.0, gained[i - 1] = -1.0;
    accelerate(gained);
    return 1.0 / (gained[i] - gained[i - 1]);
  }
  if (contact.where != Where::span) return effective_masses()[i];
  double sum = inertia_.diagonal[i];
  if (i > 0 && !inertia_.off_diagonal.empty()) sum += inertia_.off_diagonal[i - 1];
  if (i < inertia_.off_diagonal.size()) sum += inertia_.off_diagonal[i];
  return sum;
}

}  // namespace viscobar
