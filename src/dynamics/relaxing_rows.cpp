#include "dynamics/relaxing_rows.hpp"

#include <algorithm>
#include <optional>

#include "dynamics/contact_rows.hpp"

namespace viscobar {

std::vector<RelaxingRow> relaxing_rows(const Contacts& contacts) {
  const BarSystem& bar = contacts.bar();
  std::vector<RelaxingRow> rows;
  if (!bar.bar().damped()) return rows;
  const double modulus = bar.bar().modulus, viscosity = bar.bar().viscosity;
  for (const std::size_t end : {std::size_t{0}, bar.size() - 1}) {
    if (!bar.inertia().massless(end) || contacts.held(end)) continue;
    const double h = bar.elements().stretch_beside(end);
    const std::size_t next = neighbour(end);
    const double share = modulus / viscosity;
    RelaxingRow row{end,
                    share,
                    h / viscosity,
                    share * (contacts.origin().at(next) - contacts.origin().at(end)),
                    0.0,
                    {{{next, share, 1.0, 0.0}, {}}},
                    1};
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      if (!contacts.closed_at(i, end)) continue;
      row.rate += contacts[i].law.linear().stiffness * h / viscosity;
      row.constant -= contacts[i].sign * contacts[i].law.linear().stiffness * h / viscosity * contacts.offset(i);
    }
    rows.push_back(row);
  }
  return rows;
}

RelaxingRow resting_row(const Contacts& contacts, std::size_t contact_index) {
  const BarSystem& bar = contacts.bar();
  const std::size_t i = contacts[contact_index].unknown, node = i + bar.unknowns().first_node();
  RelaxingRow row{i, 0.0, 1.0, 0.0, 0.0, {}, 0};
  double damping = 0.0;
  const auto beside = [&](std::size_t element, std::optional<std::size_t> next, std::optional<double> wall) {
    const double modulus = bar.bar().modulus / bar.elements().stretch(element),
                 viscosity = bar.bar().viscosity / bar.elements().rate_stretch(element);
    row.rate += modulus, damping += viscosity;
    if (!next) {
      row.constant += modulus * (*wall - contacts.origin().at(i));
      return;
    }
    row.constant += modulus * (contacts.origin().at(*next) - contacts.origin().at(i));
    const BandedMatrix& inertia = bar.inertia().matrix();
    const double coupling = inertia.is_diagonal() ? 0.0 : *next < i ? inertia.below(*next) : inertia.above(i);
    row.neighbours[row.count++] = {*next, modulus, viscosity, coupling};
  };
  const std::size_t last = bar.mesh().elements;
  const std::optional<std::size_t> none;
  if (node > 0) beside(node - 1, i > 0 ? std::optional(i - 1) : none, bar.unknowns().wall(false));
  if (node < last) beside(node, i + 1 < bar.size() ? std::optional(i + 1) : none, bar.unknowns().wall(true));
  if (!bar.inertia().matrix().one_sided.empty() && row.count == 1) {
    const std::array<double, 3> shares = bar.inertia().matrix().one_sided_entries(i, i > 0);
    row.neighbours[0].a_share += shares[1];
    row.neighbours[row.count++] = {i == 0 ? 2 : i - 2, 0.0, 0.0, shares[2]};
  }
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (!contacts.closed_at(c, i)) continue;
    row.rate += contacts[c].law.linear().stiffness, damping += contacts[c].law.linear().damping;
    row.constant -= contacts[c].sign * contacts[c].law.linear().stiffness * contacts.offset(c);
  }
  for (const Support& support : bar.supports()) {
    if (support.unknown != i) continue;
    row.rate += support.stiffness, damping += support.dashpot;
    row.constant -= support.stiffness * contacts.origin().at(i);
  }
  if (const SideRows* side = bar.side()) {
    const auto entry = [&](std::size_t column) {
      std::array<double, 1> out{};
      side->subtract([column](std::size_t j) { return j == column ? -1.0 : 0.0; }, node, 1, out);
      return out[0];
    };
    const auto pull = [&](std::size_t j, double u) { row.constant -= entry(j) * side->stiffness(j) * u; };
    row.rate += entry(node) * side->stiffness(node), damping += entry(node) * side->drag(node);
    pull(node, contacts.origin().at(i));
    if (i == 0 && node > 0) pull(0, *bar.unknowns().wall(false));
    if (i + 1 == bar.size() && node < last) pull(last, *bar.unknowns().wall(true));
    for (std::size_t n = 0; n < row.count; ++n) {
      RelaxingRow::Neighbour& neighbour = row.neighbours[n];
      const std::size_t j = neighbour.unknown + bar.unknowns().first_node();
      neighbour.u_share -= entry(j) * side->stiffness(j), neighbour.w_share -= entry(j) * side->drag(j);
      pull(j, contacts.origin().at(neighbour.unknown));
    }
  }
  row.inertia = bar.inertia().matrix().diagonal_entry(i) / row.rate;
  const double scale = 1.0 / std::max(damping, row.rate / (1e3 * contacts[contact_index].rate));
  for (RelaxingRow::Neighbour& n : row.neighbours) n.u_share *= scale, n.w_share *= scale, n.a_share *= scale;
  row.rate *= scale, row.load_share *= scale, row.constant *= scale;
  return row;
}

}  // namespace viscobar
