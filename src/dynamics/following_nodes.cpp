// Nodes of a PenalisedSystem that follow their neighbours: those without mass, and those that rest on a stiff spring.
#include <algorithm>
#include <array>
#include <cmath>

#include "dynamics/penalised_system.hpp"

namespace viscobar {

void PenalisedSystem::complete_velocity_of(std::size_t end, double t, std::span<const double> u, std::span<double> w) {
  if (held(end)) {
    w[end] = 0.0;
    return;
  }
  const double h = bar_.stretch_at(end);
  const double modulus = bar_.bar().modulus / h, damping = bar_.bar().viscosity / h;
  const std::size_t next = neighbour(end);
  if (bar_.damped()) {
    double force = modulus * (u[next] - u[end] + (origin_at(next) - origin_at(end))) + damping * w[next] + load(end, t);
    for (std::size_t i = 0; i < laws_.size(); ++i)
      if (closed_at(i, end)) force -= contact(i).sign * laws_[i].stiffness * clearance(i, u);
    w[end] = force / damping;
    return;
  }
  double rate = modulus * w[next];
  if (load_varies()) {
    const auto [before, after] = beside(t);
    const double early = load(end, before), late = load(end, after);
    if (before < after) rate += (late - early) / (after - before);
  }
  rate += added_rates_[end == 0 ? 0 : 1];
  double springs = 0.0;
  for (std::size_t i = 0; i < laws_.size(); ++i)
    if (closed_at(i, end)) springs += laws_[i].stiffness;
  w[end] = rate / (modulus + springs);
}

std::pair<double, double> PenalisedSystem::beside(double t) const {
  const double step = 1e-4 * bar_.mesh().spacing() * std::sqrt(bar_.bar().density / bar_.bar().modulus);
  // No load is asked for before the start, where it need not exist.
  return {load_->inside(std::max(0.0, t - step)), load_->inside(t + step)};
}

void PenalisedSystem::add_load_rate(double t, std::span<double> rate) {
  if (!load_varies()) return;
  const auto [before, after] = beside(t);
  if (before >= after) return;
  for (const auto& [at, sign] : {std::pair{before, -1.0}, {after, 1.0}}) {
    const std::span<const double> load = load_->at(at);
    for (std::size_t i = 0; i < rate.size(); ++i) rate[i] += sign / (after - before) * load[i];
  }
}

bool PenalisedSystem::load_jump(double t, double end, std::span<double> force, std::span<double> rate) {
  const double apart = 1e-4 * bar_.mesh().spacing() * std::sqrt(bar_.bar().density / bar_.bar().modulus);
  return load_varies() && load_->jump(t, end, apart, force, rate);
}

void PenalisedSystem::complete_velocity(double t, std::span<const double> u, std::span<double> w) {
  if (bar_.massive_begin() == 1) complete_velocity_of(0, t, u, w);
  if (bar_.massive_end() + 1 == size()) complete_velocity_of(size() - 1, t, u, w);
}

void PenalisedSystem::complete_displacement_of(std::size_t end, double t, std::span<double> u) {
  if (held(end)) {
    for (std::size_t i = 0; i < laws_.size(); ++i)
      if (contact(i).unknown == end) place_on_obstacle(i, u);
    return;
  }
  if (bar_.damped()) return;
  const double modulus = bar_.bar().modulus / bar_.stretch_at(end);
  const std::size_t next = neighbour(end);
  double force = modulus * (u[next] + (origin_at(next) - origin_at(end))) + load(end, t), stiffness = modulus;
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    if (!closed_at(i, end)) continue;
    force -= contact(i).sign * laws_[i].stiffness * offsets_[i];
    stiffness += laws_[i].stiffness;
  }
  u[end] = force / stiffness;
}

void PenalisedSystem::complete_displacement(double t, std::span<double> u) {
  if (bar_.massive_begin() == 1) complete_displacement_of(0, t, u);
  if (bar_.massive_end() + 1 == size()) complete_displacement_of(size() - 1, t, u);
}

std::vector<PenalisedSystem::RelaxingRow> PenalisedSystem::relaxing_rows() const {
  std::vector<RelaxingRow> rows;
  if (!bar_.damped()) return rows;
  const double modulus = bar_.bar().modulus, viscosity = bar_.bar().viscosity;
  for (const std::size_t end : {std::size_t{0}, size() - 1}) {
    if (!massless(end) || held(end)) continue;
    const double h = bar_.stretch_at(end);
    const std::size_t next = neighbour(end);
    const double share = modulus / viscosity;
    RelaxingRow row{
        end, share, h / viscosity, share * (origin_at(next) - origin_at(end)), 0.0, {{{next, share, 1.0, 0.0}, {}}}, 1};
    for (std::size_t i = 0; i < laws_.size(); ++i) {
      if (!closed_at(i, end)) continue;
      row.rate += laws_[i].stiffness * h / viscosity;
      row.constant -= contact(i).sign * laws_[i].stiffness * h / viscosity * offsets_[i];
    }
    rows.push_back(row);
  }
  return rows;
}

PenalisedSystem::RelaxingRow PenalisedSystem::resting_row(std::size_t contact_index) const {
  const std::size_t i = contact(contact_index).unknown, node = i + bar_.first_node();
  RelaxingRow row{i, 0.0, 1.0, 0.0, 0.0, {}, 0};
  double damping = 0.0;
  const auto beside = [&](std::size_t element, std::optional<std::size_t> next, std::optional<double> wall) {
    const double modulus = bar_.bar().modulus / bar_.stretch(element),
                 viscosity = bar_.bar().viscosity / bar_.rate_stretch(element);
    row.rate += modulus, damping += viscosity;
    if (!next) {
      row.constant += modulus * (*wall - origin_at(i));
      return;
    }
    row.constant += modulus * (origin_at(*next) - origin_at(i));
    const BandedMatrix& inertia = bar_.inertia();
    const double coupling = inertia.is_diagonal() ? 0.0 : *next < i ? inertia.below(*next) : inertia.above(i);
    row.neighbours[row.count++] = {*next, modulus, viscosity, coupling};
  };
  const std::size_t last = bar_.mesh().elements;
  const std::optional<std::size_t> none;
  if (node > 0) beside(node - 1, i > 0 ? std::optional(i - 1) : none, bar_.left_displacement());
  if (node < last) beside(node, i + 1 < size() ? std::optional(i + 1) : none, bar_.right_displacement());
  if (!bar_.inertia().one_sided.empty() && row.count == 1) {
    const std::array<double, 3> shares = bar_.inertia().one_sided_entries(i, i > 0);
    row.neighbours[0].a_share += shares[1];
    row.neighbours[row.count++] = {i == 0 ? 2 : i - 2, 0.0, 0.0, shares[2]};
  }
  for (std::size_t c = 0; c < laws_.size(); ++c) {
    if (!closed_at(c, i)) continue;
    row.rate += laws_[c].stiffness, damping += laws_[c].damping;
    row.constant -= contact(c).sign * laws_[c].stiffness * offsets_[c];
  }
  for (const Support& support : bar_.supports()) {
    if (support.unknown != i) continue;
    row.rate += support.stiffness, damping += support.dashpot;
    row.constant -= support.stiffness * origin_at(i);
  }
  if (const SideRows* side = bar_.side()) {
    const auto entry = [&](std::size_t column) {
      std::array<double, 1> out{};
      side->subtract([column](std::size_t j) { return j == column ? -1.0 : 0.0; }, node, 1, out);
      return out[0];
    };
    const auto pull = [&](std::size_t j, double u) { row.constant -= entry(j) * side->stiffness(j) * u; };
    row.rate += entry(node) * side->stiffness(node), damping += entry(node) * side->drag(node);
    pull(node, origin_at(i));
    if (i == 0 && node > 0) pull(0, *bar_.left_displacement());
    if (i + 1 == size() && node < last) pull(last, *bar_.right_displacement());
    for (std::size_t n = 0; n < row.count; ++n) {
      RelaxingRow::Neighbour& neighbour = row.neighbours[n];
      const std::size_t j = neighbour.unknown + bar_.first_node();
      neighbour.u_share -= entry(j) * side->stiffness(j), neighbour.w_share -= entry(j) * side->drag(j);
      pull(j, origin_at(neighbour.unknown));
    }
  }
  row.inertia = bar_.inertia().diagonal_entry(i) / row.rate;
  const double scale = 1.0 / std::max(damping, row.rate / (1e3 * rates_[contact_index]));
  for (RelaxingRow::Neighbour& n : row.neighbours) n.u_share *= scale, n.w_share *= scale, n.a_share *= scale;
  row.rate *= scale, row.load_share *= scale, row.constant *= scale;
  return row;
}

}  // namespace viscobar
