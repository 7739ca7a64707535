#include "viscobar/dynamics/bar_system.hpp"

#include <cassert>
#include <numeric>

#include "discretisation/varying_section.hpp"
#include "dynamics/finite_load.hpp"
#include "dynamics/moments.hpp"
#include "scene/end_kinds.hpp"

namespace viscobar {

namespace {

std::vector<double> part_of(std::span<const double> entries, std::size_t first, std::size_t count) {
  const auto part = entries.subspan(first, count);
  return {part.begin(), part.end()};
}

SymmetricTridiagonal restrict_to(const SymmetricTridiagonal& matrix, std::size_t first, std::size_t count) {
  SymmetricTridiagonal part;
  part.diagonal = part_of(matrix.diagonal, first, count);
  if (!matrix.off_diagonal.empty() && count > 1) part.off_diagonal = part_of(matrix.off_diagonal, first, count - 1);
  if (!matrix.skew.empty() && count > 1) part.skew = part_of(matrix.skew, first, count - 1);
  const bool with_first = first == 0, with_last = first + count == matrix.size();
  if (matrix.end_rows && (with_first || with_last)) {
    part.end_rows.emplace();
    if (with_first) part.end_rows->first = matrix.end_rows->first;
    if (with_last) part.end_rows->last = matrix.end_rows->last;
  }
  return part;
}

// Sum over the elements of (difference of the ends' values)^2 / h.
double graded_squared_strain(std::span<const double> x, const double* left, const double* right,
                             std::span<const double> inverse_spacing) {
  double sum = 0.0;
  const auto add = [&](std::size_t element, double difference) {
    sum += difference * difference * inverse_spacing[element];
  };
  const std::size_t first = left ? 1 : 0;
  for (std::size_t i = 0; i + 1 < x.size(); ++i) add(first + i, x[i + 1] - x[i]);
  if (left) add(0, x.front() - *left);
  if (right) add(inverse_spacing.size() - 1, *right - x.back());
  return sum;
}

// Sum of the squared differences of neighbours, the fixed neighbours being given.
double squared_differences(std::span<const double> x, const double* left, const double* right) {
  // Partial sums, since one alone would wait for each addition.
  constexpr std::size_t lanes = 16;
  std::array<double, lanes> sums{};
  std::size_t i = 0;
  for (; i + lanes < x.size(); i += lanes)
    for (std::size_t l = 0; l < lanes; ++l) {
      const double difference = x[i + l + 1] - x[i + l];
      sums[l] += difference * difference;
    }
  double sum = std::accumulate(sums.begin(), sums.end(), 0.0);
  for (; i + 1 < x.size(); ++i) sum += (x[i + 1] - x[i]) * (x[i + 1] - x[i]);
  if (left) sum += (x.front() - *left) * (x.front() - *left);
  if (right) sum += (*right - x.back()) * (*right - x.back());
  return sum;
}

std::array<double, 3> row_of_end(const SymmetricTridiagonal& matrix, bool right) {
  const std::size_t end = right ? matrix.size() - 1 : 0;
  std::array<double, 3> row = matrix.end_rows ? matrix.end_rows->row(end) : std::array<double, 3>{};
  row[0] += matrix.diagonal[end];
  if (!matrix.off_diagonal.empty()) row[1] += right ? matrix.off_diagonal.back() : matrix.off_diagonal.front();
  return row;
}

double uniform_stiffness_diagonal(const BarSystem& system, std::size_t i) {
  const bool bare_left = i == 0 && !system.left_fixed();
  const bool bare_right = i + 1 == system.size() && !system.right_fixed();
  return (2.0 - (bare_left ? 1.0 : 0.0) - (bare_right ? 1.0 : 0.0)) / system.mesh().spacing();
}

}  // namespace

BarSystem::BarSystem(const Scene& scene, const Mesh& mesh, Mass mass)
    : mesh_(mesh), mass_(mass), bar_(scene.bar), inputs_{scene.left_input, scene.right_input} {
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
  massless_ = {redistributed && is_bare_obstacle(scene.left, scene.left_input),
               redistributed && is_bare_obstacle(scene.right, scene.right_input)};
  if (redistributed && end_obstacles(scene) > 0 && !has_massless())
    throw std::invalid_argument(
        "mass \"redistributed\" does not fit a spring, a dashpot, a mass or a stop with a law of its own at an end, whose "
        "node must keep its mass");
  if (scene.section) {
    section_ = std::make_shared<VaryingSection>(scene.section, scene.section_places.breaks, mesh);
    places_ = section_->places();
  }
  for (std::size_t j = 0; (section_ || !mesh.uniform()) && j < mesh.elements; ++j)
    inverse_spacing_.push_back(1.0 / stretch(j));
  whole_inertia_ = inertia_matrix(mesh, mass, massless_[0], massless_[1], section_.get());
  if (scene.side) {
    const auto nodal = [&](const SpaceFunction& f) {
      std::vector<double> values;
      for (std::size_t j = 0; f && j < mesh.nodes(); ++j) values.push_back(f(mesh.node(j)));
      return values;
    };
    side_.emplace(whole_inertia_, nodal(scene.side->stiffness), nodal(scene.side->drag));
  }
  whole_inertia_ *= bar_.density;
  inertia_ = restrict_to(whole_inertia_, first, n);
  for (const bool right : {false, true})
    if (walls_[right]) held_rows_[right] = row_of_end(whole_inertia_, right);
  massive_factor_.factorise(restrict_to(inertia_, massive_begin(), massive_end() - massive_begin()));

  const auto bound = [&](std::size_t unknown, const std::optional<Obstacle>& obstacle, double weight, Where where) {
    if (!obstacle) return;
    if (obstacle->bounds(Side::below)) contacts_.push_back({unknown, obstacle->gap, weight, where, 1.0});
    if (obstacle->bounds(Side::above)) contacts_.push_back({unknown, obstacle->gap, weight, where, -1.0});
  };
  bound(0, ends[0].obstacle, 1.0, Where::left);
  bound(n - 1, ends[1].obstacle, 1.0, Where::right);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t node = i + first;
    const double before = node > 0 ? mesh.element(node - 1) : 0.0;
    const double after = node < mesh.elements ? mesh.element(node) : 0.0;
    bound(i, scene.span, (before + after) / 2, Where::span);
    initial_.u.push_back(scene.displacement(mesh.node(node)));
    initial_.v.push_back(scene.velocity(mesh.node(node)));
  }

  for (const bool right : {false, true}) {
    const EndInput& input = inputs_[right];
    if (walls_[right] || (input.stiffness == 0.0 && input.dashpot == 0.0 && input.mass == 0.0)) continue;
    mounts_.push_back({end(right), input.stiffness, input.dashpot, input.mass});
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
  if (const auto moments = moments_of("the initial velocity", scene.velocity, scene.velocity_places); !moments.empty())
    start_from(moments);
  else if (mass == Mass::fourth_order && fixed > 0)
    stop_fixed_ends(scene);
  add_masses();
  if (!moved) whole_inertia_ = {};

  if (scene.load) {
    const SymmetricTridiagonal load_mass = mass_matrix(mesh, mass, section_.get());
    const auto weighted = [&](const SpaceFunction& profile, const Places& places) {
      std::vector<double> values(mesh.nodes()), product = moments_of("the load", profile, places);
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

// The data at the beginning do not depend on them.
void BarSystem::add_masses() {
  if (std::ranges::all_of(mounts_, [](const Mount& mount) { return mount.mass == 0.0; })) return;
  for (const Mount& mount : mounts_) {
    inertia_.diagonal[mount.unknown] += mount.mass;
    whole_inertia_.diagonal[mount.unknown + first_node()] += mount.mass;
  }
  massive_factor_.factorise(restrict_to(inertia_, massive_begin(), massive_end() - massive_begin()));
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
  const double pull = (bar_.modulus * (u[e + 1] - u[e]) + bar_.viscosity * (v[e + 1] - v[e])) / stretch(e);
  const double force = (right ? pull : -pull) + held_inertia(right, a) - load;
  if (!side_) return force;
  return force + side_->at_end(right, side_->resistance([u](std::size_t j) { return u[j]; },
                                                        [v](std::size_t j) { return v[j]; }));
}

void BarSystem::internal_force(std::span<const double> u, std::span<const double> w, std::span<double> out) const {
  if (rows_alike())
    uniform_force(u, w, out);
  else
    graded_force(u, w, out);
  for (const Mount& mount : mounts_)
    out[mount.unknown] -= mount.stiffness * u[mount.unknown] + mount.dashpot * w[mount.unknown];
  if (side_) side_->subtract(side_->resistance(displacement_at_nodes(u), at_nodes(w)), first_node(), size(), out);
}

void BarSystem::uniform_force(std::span<const double> u, std::span<const double> w, std::span<double> out) const {
  const std::size_t n = size();
  const double stiffness = bar_.modulus / mesh_.spacing();
  const double damping = bar_.viscosity / mesh_.spacing();
  // Stress on the left of the first and on the right of the last unknown: none at an end that is not fixed.
  const double left = walls_[0] ? stiffness * (u[0] - *walls_[0]) + damping * w[0] : 0.0;
  const double right = walls_[1] ? stiffness * (*walls_[1] - u[n - 1]) - damping * w[n - 1] : 0.0;
  if (n == 1) {
    out[0] = right - left;
    return;
  }
  const auto inner = [&](auto stress) {
    out[0] = stress(0) - left;
    for (std::size_t i = 1; i + 1 < n; ++i) out[i] = stress(i) - stress(i - 1);
    out[n - 1] = right - stress(n - 2);
  };
  if (damped())
    inner([=](std::size_t i) { return stiffness * (u[i + 1] - u[i]) + damping * (w[i + 1] - w[i]); });
  else
    inner([=](std::size_t i) { return stiffness * (u[i + 1] - u[i]); });
}

void BarSystem::graded_force(std::span<const double> u, std::span<const double> w, std::span<double> out) const {
  const std::size_t n = size(), first = first_node();
  const double modulus = bar_.modulus, viscosity = bar_.viscosity;
  double before = walls_[0] ? inverse_spacing_[0] * (modulus * (u[0] - *walls_[0]) + viscosity * w[0]) : 0.0;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double next = inverse_spacing_[first + i] * (modulus * (u[i + 1] - u[i]) + viscosity * (w[i + 1] - w[i]));
    out[i] = next - before;
    before = next;
  }
  const double right = walls_[1] ? modulus * (*walls_[1] - u[n - 1]) - viscosity * w[n - 1] : 0.0;
  out[n - 1] = inverse_spacing_.back() * right - before;
}

double BarSystem::stiffness_diagonal(std::size_t i) const {
  if (rows_alike()) return uniform_stiffness_diagonal(*this, i);
  const std::size_t node = i + first_node();
  return (node > 0 ? inverse_spacing_[node - 1] : 0.0) + (node < mesh_.elements ? inverse_spacing_[node] : 0.0);
}

void BarSystem::dynamic_stiffness(double m, double c, double k, SymmetricTridiagonal& out) const {
  const double scale = c * bar_.viscosity + k * bar_.modulus;
  if (rows_alike())
    uniform_stiffness(m, scale, out);
  else
    graded_stiffness(m, scale, out);
  out.skew = inertia_.skew;
  for (double& entry : out.skew) entry *= m;
  out.end_rows.reset();
  if (inertia_.end_rows) out.end_rows = inertia_.end_rows->times(m);
  for (const Mount& mount : mounts_) out.diagonal[mount.unknown] += c * mount.dashpot + k * mount.stiffness;
  if (side_) side_->add_to(out, first_node(), c, k);
}

void BarSystem::uniform_stiffness(double m, double scale, SymmetricTridiagonal& out) const {
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

void BarSystem::graded_stiffness(double m, double scale, SymmetricTridiagonal& out) const {
  const std::size_t n = size(), first = first_node();
  out.diagonal.resize(n);
  out.off_diagonal.resize(n - 1);
  for (std::size_t i = 0; i < n; ++i) out.diagonal[i] = m * inertia_.diagonal[i] + scale * stiffness_diagonal(i);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double mass = inertia_.is_diagonal() ? 0.0 : m * inertia_.off_diagonal[i];
    out.off_diagonal[i] = mass - scale * inverse_spacing_[first + i];
  }
}

double BarSystem::squared_strain(std::span<const double> u) const {
  const double *left = walls_[0] ? &*walls_[0] : nullptr, *right = walls_[1] ? &*walls_[1] : nullptr;
  if (!rows_alike()) return graded_squared_strain(u, left, right, inverse_spacing_);
  return squared_differences(u, left, right) / mesh_.spacing();
}

double BarSystem::squared_strain_rate(std::span<const double> w) const {
  const double still = 0.0;
  const double *left = walls_[0] ? &still : nullptr, *right = walls_[1] ? &still : nullptr;
  if (!rows_alike()) return graded_squared_strain(w, left, right, inverse_spacing_);
  return squared_differences(w, left, right) / mesh_.spacing();
}

double BarSystem::energy(std::span<const double> u, std::span<const double> w) const {
  double sum = 0.5 * inertia_.quadratic_form(w) + 0.5 * bar_.modulus * squared_strain(u);
  for (const Mount& mount : mounts_) sum += 0.5 * mount.stiffness * u[mount.unknown] * u[mount.unknown];
  return side_ ? sum + side_->energy(displacement_at_nodes(u)) : sum;
}

bool BarSystem::has_dashpots() const {
  return std::ranges::any_of(mounts_, [](const Mount& mount) { return mount.dashpot > 0.0; });
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

// None where nothing is known; and what is smooth has none but on `fourth_order`, unless its detail is finer than a
// quarter of an element.
std::vector<double> BarSystem::moments_of(std::string_view what, const SpaceFunction& f, const Places& places) const {
  std::vector<double> moments;
  if (!places.breaks) return moments;
  const double length = mesh_.length;
  const std::vector<double> detail = graded(places.detail, length);
  bool needed = mass_ == Mass::fourth_order || places.breaks(0.0, length);
  for (std::size_t k = 1; k < detail.size() && !needed; ++k) needed = detail[k] - detail[k - 1] < mesh_.spacing() / 4.0;
  if (!needed) return moments;
  const auto next_detail = [&](double after, double until) -> std::optional<double> {
    const auto next = std::ranges::upper_bound(detail, after);
    return next != detail.end() && *next < until ? std::optional(*next) : std::nullopt;
  };
  moments.resize(mesh_.nodes());
  const auto value = [&](double x) {
    return finite_load(
        0.0, [&] { return f(x); }, [&] { return fmt::format("{} at x = {}", what, x); });
  };
  add_moments(mesh_, mass_, section_.get(), 0, mesh_.elements, value, either_of(places.breaks, next_detail),
              [&](std::size_t node, double part) { moments[node] += part; });
  return moments;
}

// rho M w = rho int phi_i u_1 over the unknowns, held nodes at rest from the first moment on. A node without mass has
// the velocity to which its neighbours' extends, and they have its moment.
void BarSystem::start_from(std::vector<double> moments) {
  for (double& moment : moments) moment *= bar_.density;
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
  if (contact.where != Where::span) return effective_masses()[i];
  double sum = inertia_.diagonal[i];
  if (i > 0 && !inertia_.off_diagonal.empty()) sum += inertia_.off_diagonal[i - 1];
  if (i < inertia_.off_diagonal.size()) sum += inertia_.off_diagonal[i];
  return sum;
}

}  // namespace viscobar
