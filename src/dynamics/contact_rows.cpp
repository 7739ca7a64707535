#include "dynamics/contact_rows.hpp"

#include <algorithm>
#include <cmath>

namespace viscobar {

namespace {

void add_supports(const BarSystem& bar, JointRow& row) {
  for (const Support& support : bar.supports())
    if (support.unknown == row.node) row.ground_stiffness += support.stiffness, row.ground_viscosity += support.dashpot;
}

// True if a node of contact i is a rigid body that nothing else holds, beyond which lies that element.
bool is_free_body(const Contacts& contacts, std::size_t i, std::size_t node, std::size_t element) {
  const BarSystem& bar = contacts.bar();
  if (bar.elements().is_of_bar(element)) return false;
  if (element < bar.mesh().elements && std::isfinite(bar.elements().stretch(element))) return false;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const bool has_node = contacts[k].unknown == node || (contacts[k].joint > 0 && contacts[k].unknown == node + 1);
    if (k != i && contacts.closed(k) && has_node) return false;
  }
  return true;
}

// The row of the node beside contact i alone.
JointRow row_of_node(const Contacts& contacts, std::size_t i) {
  const BarSystem& bar = contacts.bar();
  const std::size_t b = contacts[i].unknown, first = bar.unknowns().first_node();
  const bool of_joint = contacts[i].joint > 0, to_right = contacts[i].to_right;
  if (contacts[i].by_law) return {.node = b, .next = b - 1, .beyond = b, .sign = 1.0, .scale = 1.0};
  const std::size_t node = of_joint && !to_right ? b - 1 : b, place = node + first;
  JointRow row{.node = node, .next = node, .beyond = node, .sign = to_right ? 1.0 : -1.0, .scale = 0.0};
  if (!of_joint) row.sign = contacts[i].sign;
  const BandedMatrix& inertia = bar.inertia().matrix();
  row.inertia[0] = inertia.diagonal[node];
  const std::size_t element = to_right ? place : place - 1;
  if (to_right ? place < bar.mesh().elements : place > 0) {
    const double stiffness = bar.bar().modulus / bar.elements().stretch(element),
                 viscosity = bar.bar().viscosity / bar.elements().rate_stretch(element);
    if (to_right ? node + 1 < bar.size() : node > 0) {
      row.stiffness = stiffness, row.viscosity = viscosity;
      row.next = to_right ? node + 1 : node - 1;
      row.beyond = to_right ? std::min(node + 2, bar.size() - 1) : node < 2 ? 0 : node - 2;
    } else {
      row.ground_stiffness = stiffness, row.ground_viscosity = viscosity;
      row.ground_force = stiffness * bar.unknowns().wall(to_right).value_or(0.0);
    }
  }
  const bool of_bar = bar.elements().is_of_bar(element);
  row.scale = of_bar && row.stiffness > 0.0 ? row.stiffness : bar.bar().modulus / bar.elements().stretch_beside(b);
  add_supports(bar, row);
  if (!of_bar) return row;
  const std::array<double, 3> one_sided = inertia.one_sided_entries(node, !to_right);
  for (std::size_t k = 0; k < 3; ++k) row.inertia[k] += one_sided[k];
  const bool beside = row.next != node;
  if (!inertia.is_diagonal() && beside) row.inertia[1] += to_right ? inertia.above(node) : inertia.below(row.next);
  const SideRows* side = bar.side();
  if (!side) return row;
  const std::array<double, 3> weights = side->end_row(place, !to_right);
  const std::array<std::size_t, 3> unknowns = {node, row.next, row.beyond};
  for (std::size_t k = 0; k < 3 && (beside || k == 0); ++k) {
    row.side_stiffness[k] = weights[k] * side->stiffness(unknowns[k] + first);
    row.side_drag[k] = weights[k] * side->drag(unknowns[k] + first);
  }
  if (!beside)  // it is held
    row.ground_force -= weights[1] * side->stiffness(to_right ? place + 1 : place - 1) * *bar.unknowns().wall(to_right);
  return row;
}

}  // namespace

JointRow joint_row(const Contacts& contacts, std::size_t i) {
  JointRow row = row_of_node(contacts, i);
  if (contacts[i].by_law || !contacts[i].beyond) return row;
  const std::size_t k = *contacts[i].beyond;
  const JointRow far = joint_row(contacts, k);
  row.next = far.next, row.beyond = far.beyond;
  row.stiffness = row.viscosity = 0.0;  // of the element of the joint, which has none
  if (!contacts.closed(k)) return row;
  const double apart = (contacts[i].to_right ? -1.0 : 1.0) * contacts[k].gap;  // u there less that of the body
  row.last = far.last;
  row.stiffness = far.stiffness, row.viscosity = far.viscosity;
  row.side_stiffness = far.side_stiffness, row.side_drag = far.side_drag;
  row.inertia = {row.inertia[0] + far.inertia[0], far.inertia[1], far.inertia[2]};
  row.ground_stiffness += far.ground_stiffness, row.ground_viscosity += far.ground_viscosity;
  row.ground_force += far.ground_force - (far.stiffness + far.ground_stiffness + far.side_stiffness[0]) * apart;
  return row;
}

std::optional<JointRow> row_of_free_body(const Contacts& contacts, std::size_t i) {
  const BarSystem& bar = contacts.bar();
  const std::size_t b = contacts[i].unknown, right = b + bar.unknowns().first_node();
  std::optional<JointRow> lightest;
  if (!contacts[i].has_body) return lightest;
  for (const bool to_right : {true, false}) {
    const std::size_t node = to_right ? b : b - 1;
    const double mass = bar.inertia().matrix().diagonal[node];
    if (!is_free_body(contacts, i, node, to_right ? right : right - 2)) continue;
    if (lightest && lightest->inertia[0] <= mass) continue;
    lightest = JointRow{.node = node,
                        .next = node,
                        .beyond = node,
                        .sign = to_right ? 1.0 : -1.0,
                        .scale = joint_row(contacts, i).scale,
                        .inertia = {mass}};
    add_supports(bar, *lightest);
  }
  return lightest;
}

std::optional<std::size_t> contact_of_body(const Contacts& contacts, bool right) {
  const Where where = right ? Where::right : Where::left;
  // Those of ends come first.
  for (std::size_t i = 0; i < contacts.size() && contacts[i].at_end(); ++i)
    if (contacts[i].where == where && contacts[i].beyond) return i;
  return std::nullopt;
}

EndRows end_rows(const Contacts& contacts, std::size_t end, std::optional<std::size_t> struck) {
  EndRows rows{.last = end};
  const std::optional<std::size_t> contact = contact_of_body(contacts, contacts.bar().unknowns().is_right(end));
  if (!contact) return rows;
  rows.of_body = true, rows.strained = false;
  rows.by_law = contacts[*contact].by_law;
  if (rows.by_law) return rows;
  for (auto k = contacts[*contact].beyond; k && (contacts.closed(*k) || k == struck); k = contacts[*k].beyond) {
    rows.last = end == 0 ? rows.last + 1 : rows.last - 1;
    rows.strained = !contacts[*k].beyond;
  }
  return rows;
}

std::array<double, 2> inertia_beside(const BandedMatrix& inertia, std::size_t end) {
  if (inertia.off_diagonal.empty()) return {0.0, 0.0};
  const double beside = inertia.off_diagonal[std::min(end, neighbour(end))];
  if (inertia.one_sided.empty()) return {beside, 0.0};
  const std::array<double, 3> row = inertia.one_sided_entries(end, end > 0);
  return {beside + row[1], row[2]};
}

double held_inertia_times(const Contacts& contacts, std::size_t i, std::span<const double> v,
                          std::optional<std::size_t> struck) {
  if (const auto beyond = contacts[i].beyond; beyond && !contacts[i].by_law) {
    const bool pushes = contacts.closed(*beyond) || beyond == struck;
    return row_of_node(contacts, i).inertia[0] * v[row_of_node(contacts, i).node] +
           (pushes ? held_inertia_times(contacts, *beyond, v, struck) : 0.0);
  }
  if (contacts[i].joint > 0) return joint_row(contacts, i).inertia_times(v);
  const std::size_t end = contacts[i].unknown;
  const auto inertia = inertia_beside(contacts.bar().inertia().matrix(), end);
  double sum = inertia[0] * v[neighbour(end)];
  if (inertia[1] != 0.0) sum += inertia[1] * v[end == 0 ? 2 : end - 2];
  return sum;
}

}  // namespace viscobar
