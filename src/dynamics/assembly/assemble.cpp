#include <algorithm>
#include <stdexcept>
#include <vector>

#include "dynamics/assembly/assembled.hpp"
#include "dynamics/assembly/initial_state.hpp"
#include "dynamics/load/nodal_load.hpp"
#include "dynamics/load/nodal_moments.hpp"
#include "scene/end_kinds.hpp"
#include "viscobar/dynamics/bar_system.hpp"

// How a BarSystem is made of a scene.

namespace viscobar {

namespace {

std::array<EndNode, 2> end_nodes(const Scene& scene, double length) {
  return {end_node(scene.left, scene.displacement(0.0)), end_node(scene.right, scene.displacement(length))};
}

Unknowns unknowns_of(const Scene& scene, const Mesh& mesh) {
  const std::array<EndNode, 2> ends = end_nodes(scene, mesh.length);
  return {mesh.nodes(), {ends[0].held, ends[1].held}};
}

// Ends without mass.
std::array<bool, 2> massless_ends(const Scene& scene, Mass mass) {
  const bool redistributed = mass == Mass::redistributed;
  return {redistributed && is_bare_obstacle(scene.left, scene.left_input),
          redistributed && is_bare_obstacle(scene.right, scene.right_input)};
}

void refuse_misfits(const Scene& scene, Mass mass) {
  const bool redistributed = mass == Mass::redistributed, chain = !scene.chain.empty();
  if (redistributed && scene.span)
    throw std::invalid_argument(
        "mass \"redistributed\" does not fit a span obstacle: every node is a contact node and must keep its mass");
  if (chain && (redistributed || mass == Mass::paper))
    throw std::invalid_argument("masses \"redistributed\" and \"paper\" do not fit several bars in line");
  if (chain && scene.span) throw std::invalid_argument("several bars in line do not fit a span obstacle");
  if (redistributed && end_obstacles(scene) > 0 && bare_obstacles(scene) == 0)
    throw std::invalid_argument(
        "mass \"redistributed\" does not fit a spring, a dashpot, a mass or a stop with a law of its own at an end, whose "
        "node must keep its mass");
}

std::shared_ptr<const Elements> elements_of(const Scene& scene, const Mesh& mesh, const Unknowns& unknowns, Mass mass) {
  refuse_misfits(scene, mass);
  return std::make_shared<const Elements>(scene, mesh, unknowns,
                                          std::make_shared<const std::vector<Piece>>(pieces_of(scene, mesh)));
}

SideRows side_rows(const SideResistance& side, const Elements& elements, Mass mass,
                   const std::array<bool, 2>& massless) {
  const auto unit_inertia = [&](const Piece& piece) {
    return inertia_matrix(piece.mesh, mass, massless[0], massless[1], piece.section.get());
  };
  return {assembled(elements.pieces(), unit_inertia),
          side_values(elements, mass, side.stiffness, side.stiffness_places),
          side_values(elements, mass, side.drag, side.drag_places)};
}

}  // namespace

BarSystem::BarSystem(const Scene& scene, const Mesh& mesh, Mass mass)
    : mass_(mass),
      unknowns_(unknowns_of(scene, mesh)),
      inputs_{scene.left_input, scene.right_input},
      elements_(elements_of(scene, mesh, unknowns_, mass)) {
  const std::array<bool, 2> massless = massless_ends(scene, mass);
  const bool moved = inputs_[0].motion || inputs_[1].motion;
  BandedMatrix whole = inertia_of(elements_->pieces(), mass, massless);
  const auto take_inertia = [&] {
    inertia_ = std::make_shared<const Inertia>(whole, unknowns_, massless, moved);
    frame_ = std::make_shared<const MovingFrame>(scene, unknowns_, elements_, inertia_, side());
  };
  if (scene.side) side_.emplace(side_rows(*scene.side, *elements_, mass, massless));
  take_inertia();
  find_contacts(scene);
  if (moved && scene.span)
    throw std::invalid_argument("a span obstacle stands still, and does not fit ends that are moved");
  initial_ = viscobar::initial_state(scene, *this, whole);
  for (const bool right : {false, true}) {
    const EndInput& input = inputs_[right];
    if (unknowns_.wall(right) || (input.stiffness == 0.0 && input.dashpot == 0.0 && input.mass == 0.0)) continue;
    supports_.push_back({unknowns_.end(right), input.stiffness, input.dashpot, input.mass});
    whole.diagonal[supports_.back().unknown + unknowns_.first_node()] += input.mass;
  }
  if (std::ranges::any_of(supports_, [](const Support& support) { return support.mass != 0.0; })) take_inertia();
  load_ = nodal_load(scene, *this);
}

void BarSystem::find_contacts(const Scene& scene) {
  const auto bound = [&](std::size_t unknown, const std::optional<Obstacle>& obstacle, double weight, Where where) {
    if (!obstacle) return;
    if (obstacle->bounds(Side::below)) contacts_.push_back({unknown, obstacle->gap, weight, where, 1.0});
    if (obstacle->bounds(Side::above)) contacts_.push_back({unknown, obstacle->gap, weight, where, -1.0});
  };
  const std::array<EndNode, 2> ends = end_nodes(scene, mesh().length);
  bound(0, ends[0].obstacle, 1.0, Where::left);
  bound(size() - 1, ends[1].obstacle, 1.0, Where::right);
  const std::size_t first = unknowns_.first_node();
  for (std::size_t i = 0; scene.span && i < size(); ++i) {
    const std::size_t node = i + first;
    const double before = node > 0 ? mesh().element(node - 1) : 0.0;
    const double after = node < mesh().elements ? mesh().element(node) : 0.0;
    bound(i, scene.span, (before + after) / 2, Where::span);
  }
  for (std::size_t k = 0; k + 1 < scene.chain.size(); ++k) joint_stops_.push_back(scene.chain[k].joint.stop);
  for (const JointNodes& joint : elements_->joints()) {
    if (!joint.contact) continue;
    if (joint.node < first + 1 || joint.node >= first + size())
      throw std::invalid_argument("a contact lies between two bars or bodies that move, and one of them is fixed");
    contacts_.push_back(
        {joint.node - first, scene.chain[joint.number - 1].joint.gap, 1.0, Where::joint, 1.0, joint.number});
  }
}

}  // namespace viscobar
