#include "schemes/lane_bar.hpp"

#include <algorithm>
#include <array>
#include <optional>

namespace viscobar {

namespace {

// Functions that rows of lanes pass through are inlined: else they go through memory, four registers at a time.

// Stress per E / h: u_j - u_i + (eta / E) (w_j - w_i) of the nodes, or rows, stored at i and j.
struct ViscousStress {
  double relaxation;
  const double *u, *w;
  double nodes(std::size_t i, std::size_t j, std::size_t = 0) const { return u[j] - u[i] + relaxation * (w[j] - w[i]); }
  [[gnu::always_inline]] Lanes rows(std::size_t i, std::size_t j, std::size_t = 0) const {
    return load_lanes(u + j) - load_lanes(u + i) + relaxation * (load_lanes(w + j) - load_lanes(w + i));
  }
};

struct ElasticStress {
  const double* u;
  double nodes(std::size_t i, std::size_t j, std::size_t = 0) const { return u[j] - u[i]; }
  [[gnu::always_inline]] Lanes rows(std::size_t i, std::size_t j, std::size_t = 0) const {
    return load_lanes(u + j) - load_lanes(u + i);
  }
};

// The same of elements that are not alike, weighted by the inverse of their int dx / A: of edge e, or of rows the
// weights from `at` on.
template <class Stress>
struct WeightedStress {
  Stress plain;
  const double *of_edges, *of_rows;
  double nodes(std::size_t i, std::size_t j, std::size_t e) const { return of_edges[e] * plain.nodes(i, j); }
  [[gnu::always_inline]] Lanes rows(std::size_t i, std::size_t j, std::size_t at) const {
    return load_lanes(of_rows + at) * plain.rows(i, j);
  }
};

// Where viscosity has another weight than elasticity.
struct UnlikeStress {
  WeightedStress<ElasticStress> elastic, viscous;
  double relaxation;
  double nodes(std::size_t i, std::size_t j, std::size_t e) const {
    return elastic.nodes(i, j, e) + relaxation * viscous.nodes(i, j, e);
  }
  [[gnu::always_inline]] Lanes rows(std::size_t i, std::size_t j, std::size_t at) const {
    return elastic.rows(i, j, at) + relaxation * viscous.rows(i, j, at);
  }
};

// Stresses of the elements in front of the lanes of an even order, and below of those behind the nodes between them,
// each being in front of the next lane.
template <class Stress>
[[gnu::always_inline]] inline Lanes in_front(const LaneOrder& order, const Stress& stress) {
  Lanes stresses = stress.rows(order.row(order.rows) - 1, order.first, 0);
  change_lanes(stresses, [&](auto& of) { of[0] = stress.nodes(order.first - 1, order.first, order.first); });
  return stresses;
}
template <class Stress>
[[gnu::always_inline]] inline Lanes behind(const LaneOrder& order, const Stress& stress) {
  const std::size_t between = order.row(order.rows), end = between + lane_count;
  Lanes stresses = stress.rows(between, order.first + 1, 1);
  change_lanes(stresses, [&](auto& of) { of.back() = stress.nodes(end - 1, end, order.first + 1); });
  return stresses;
}

// Forces on the nodes in their order; `walls` are the stresses beyond the first and the last one. Each stress is made
// twice, so that no node waits for another.
template <class Stress>
void forces_in_order(const Stress& stress, double scale, std::array<double, 2> walls, std::span<const double> load,
                     std::span<double> out) {
  const std::size_t last = out.size() - 1;
  const auto fill = [&, force = out.data()](auto&& load_at) {
    force[0] = scale * ((last > 0 ? stress.nodes(0, 1) : walls[1]) - walls[0]) + load_at(0);
#pragma GCC ivdep
    for (std::size_t i = 1; i < last; ++i)
      force[i] = scale * (stress.nodes(i, i + 1) - stress.nodes(i - 1, i)) + load_at(i);
    if (last > 0) force[last] = scale * (walls[1] - stress.nodes(last - 1, last)) + load_at(last);
  };
  if (load.empty())
    fill([](std::size_t) { return 0.0; });
  else
    fill([values = load.data()](std::size_t i) { return values[i]; });
}

// Forces of the end nodes beside the lanes of an even order.
template <class Stress>
void end_forces(const LaneOrder& order, const Stress& stress, double scale, std::array<double, 2> walls,
                std::span<double> interface) {
  const std::size_t n = order.size, skipped = n - interface.size();
  const auto forces = [&](std::size_t begin, std::size_t end, std::size_t edge, double before, double* out) {
    for (std::size_t i = begin; i < end; ++i) {
      const double next = i + 1 < n ? stress.nodes(i, i + 1, ++edge) : walls[1];
      *out++ = scale * (next - before);
      before = next;
    }
  };
  forces(0, order.first, 0, walls[0], interface.data());
  const std::size_t begin = order.row(order.rows) + lane_count, edge = order.first + 1;
  forces(begin, n, edge, stress.nodes(begin - 1, begin, edge), &interface[begin - skipped]);
}

// The forces on rows over their scale, one row after the other, with what a load adds.
template <class Stress, bool loaded>
struct ForceRows {
  Stress stress;
  std::size_t row;     // where the first is
  const double* load;  // on it
  double per_scale;
  Lanes before;  // stresses in front of the next one

  [[gnu::always_inline]] Lanes operator()(std::size_t k) {
    const std::size_t here = row + k * lane_count;
    const Lanes next = stress.rows(here, here + lane_count, (k + 1) * lane_count), force = next - before;
    before = next;
    if constexpr (loaded)
      return force + per_scale * load_lanes(load + k * lane_count);
    else
      return force;
  }
};

// Calls use(rows) with those of a stress.
template <class Stress, class Use>
void with_rows(const LaneOrder& order, const Stress& stress, double scale, std::span<const double> load,
               const Lanes& before, Use&& use) {
  const std::size_t row = order.row(0);
  if (load.empty())
    use(ForceRows<Stress, false>{stress, row, nullptr, 0.0, before});
  else
    use(ForceRows<Stress, true>{stress, row, &load[row], 1.0 / scale, before});
}

template <class Stress>
void eliminate_evenly(const LaneFactor& factor, const Stress& stress, double scale, std::span<const double> load,
                      std::span<double> y, std::span<double> interface) {
  const LaneOrder& order = factor.order();
  const std::size_t between = order.row(order.rows), last = order.size - between - lane_count;
  Lanes at_nodes_between =
      scale * (behind(order, stress) - stress.rows(between - lane_count, between, order.rows * lane_count));
  const Lanes before = in_front(order, stress);
  if (!load.empty()) {
    for (std::size_t i = 0; i < order.first; ++i) interface[i] += load[i];
    at_nodes_between += load_lanes(&load[between]);
    for (std::size_t i = 1; i <= last; ++i) interface[interface.size() - i] += load[load.size() - i];
  }
  store_lanes(at_nodes_between, &interface[order.first]);
  with_rows(order, stress, scale, load, before, [&](const auto& rows) { factor.eliminate(rows, y, interface); });
}

double scale_of(const BarSystem& system) {
  return system.elements().rows_alike() ? system.bar().modulus / system.mesh().spacing() : system.bar().modulus;
}

}  // namespace

LaneFactor LaneBar::factor(const BarSystem& system, const BandedMatrix& matrix) {
  if (system.side()) return LaneFactor::without_rows(matrix);
  if (system.elements().rows_alike()) return LaneFactor(matrix, scale_of(system));
  std::vector<std::size_t> kept;
  for (const Contact& contact : system.contacts()) {
    kept.push_back(contact.unknown);
    if (contact.joint > 0) kept.push_back(contact.unknown - 1);
  }
  return LaneFactor(matrix, scale_of(system), kept);
}

LaneBar::LaneBar(const BarSystem& system, const LaneOrder& order)
    : system_(system),
      order_(order),
      scale_(scale_of(system)),
      relaxation_(system.bar().viscosity / system.bar().modulus) {
  if (order.rows == 0) return;
  take_edges();
  const std::size_t elements = system.mesh().elements;
  if (const std::vector<double>& skew = system.inertia().matrix().skew; !skew.empty()) {
    std::vector<double> all(elements, 0.0);  // the elements at walls have none
    std::ranges::copy(skew, all.begin() + static_cast<std::ptrdiff_t>(system.unknowns().first_node()));
    skew_ = weights(all);
  }
  if (system.elements().rows_alike()) return;
  bool alike = true;
  std::vector<double> elastic(elements);
  for (std::size_t e = 0; e < elements; ++e) {
    elastic[e] = 1.0 / system.elements().stretch(e);
    alike &= !system.bar().damped() || system.elements().rate_stretch(e) == system.elements().stretch(e);
  }
  elastic_ = weights(elastic);
  if (!alike) viscous_ = weights(system.elements().rate_weights());
}

// The edge before the first node and the one behind the last are walls, which have no nodes here. In an even order the
// elements beside lanes are rows as well, but for those in front of the first lane and behind the nodes between them.
void LaneBar::take_edges() {
  const auto& runs = order_.runs;
  const std::size_t first = system_.unknowns().first_node();
  const auto add_between = [&](std::size_t i, std::size_t j, std::size_t element) {
    edges_.i.push_back(i), edges_.j.push_back(j), edges_.element.push_back(element);
  };
  const auto add = [&](std::size_t node) { add_between(order_.place(node - 1), order_.place(node), first + node - 1); };
  add_between(0, 0, 0);
  if (order_.even()) {
    for (std::size_t node = 1; node <= order_.first; ++node) add(node);
    for (std::size_t node = runs.back().node_behind() + 1; node < order_.size; ++node) add(node);
  }
  for (std::size_t r = 0, node = 0; !order_.even() && r <= runs.size(); ++r) {
    for (const std::size_t end = r < runs.size() ? runs[r].node : order_.size; node < end; ++node) {
      fronts_.push_back(edges_.element.size() - 1);
      if (node + 1 < order_.size) add(node + 1);
    }
    if (r == runs.size()) break;
    const LaneOrder::Run& run = runs[r];
    node = run.node_behind();
    const std::size_t before = edges_.element.size() - 1;
    if (run.begin == 0)
      breaks_.push_back({0, run.lane, 0, before});
    else
      breaks_.back().before = before;
    add(node);
    breaks_.push_back({run.end(), run.lane, edges_.element.size() - 1});
  }
  add_between(0, 0, system_.mesh().elements - 1);
  stresses_.resize(edges_.element.size());
  std::ranges::stable_sort(breaks_, {}, &Break::row);
}

LaneBar::Weights LaneBar::weights(const std::vector<double>& of_elements) const {
  Weights all{{}, std::vector<Lanes>(order_.rows + 1, Lanes(0.0))};
  for (const std::size_t element : edges_.element) all.of_edges.push_back(of_elements[element]);
  const std::size_t beside = order_.even() ? 1 : 0;
  for (const LaneOrder::Run& run : order_.runs)
    for (std::size_t k = 1 - beside; k < run.count + beside; ++k)
      all.of_rows[run.begin + k][run.lane] = of_elements[system_.unknowns().first_node() + run.node + k - 1];
  return all;
}

template <class Stress>
void LaneBar::interface_forces(const Stress& stress, std::array<double, 2> walls, std::span<const double> load,
                               std::span<double> interface) const {
  const double scale = scale_;
  double* const stresses = stresses_.data();
  const std::size_t last = stresses_.size() - 1, count = interface.size();
  const std::size_t *const at_i = edges_.i.data(), *const at_j = edges_.j.data(), *const fronts = fronts_.data();
#pragma GCC ivdep
  for (std::size_t e = 1; e < last; ++e) stresses[e] = stress.nodes(at_i[e], at_j[e], e);
  stresses[0] = walls[0], stresses[last] = walls[1];
  double* const forces = interface.data();
#pragma GCC ivdep
  for (std::size_t i = 0; i < count; ++i) forces[i] = scale * (stresses[fronts[i] + 1] - stresses[fronts[i]]);
  if (load.empty()) return;
  for (std::size_t i = 0; i < order_.first; ++i) interface[i] += load[i];
  double* const others = interface.data();
  const double* const loads = &load[order_.rows * lane_count];
  for (std::size_t i = order_.first; i < interface.size(); ++i) others[i] += loads[i];
}

// Those of runs, between which a lane has no element.
template <class Rows>
struct LaneBar::BrokenRows : Rows {
  const Break* at;  // the next one
  const double* stresses;

  BrokenRows(const Rows& rows, const Break* first, const double* of_edges)
      : Rows(rows), at(first), stresses(of_edges) {}
  // The stresses behind the run that ends, and in front of the next one.
  [[gnu::always_inline]] std::array<double, 2> next_break() {
    const Break& now = *at++;
    return {stresses[now.behind], stresses[now.before]};
  }
};

template <class Stress>
void LaneBar::eliminate_unlike(const LaneFactor& factor, const Stress& stress, std::span<const double> load,
                               std::span<double> y, std::span<double> interface) const {
  const double* const stresses = stresses_.data();
  const Break* at = breaks_.data();
  std::array<double, lane_count> fronts;
  for (; at->row == 0; ++at) fronts[at->lane] = stresses[at->before];
  with_rows(order_, stress, scale_, load, load_lanes(fronts.data()),
            [&](const auto& rows) { factor.eliminate(BrokenRows(rows, at, stresses), y, interface); });
}

void LaneBar::eliminate_force(const LaneFactor& factor, std::span<const double> u, std::span<const double> w,
                              std::span<const double> load, std::span<double> y, std::span<double> interface) const {
  const bool alike = system_.elements().rows_alike(), even = order_.even();
  if (system_.side() || (!alike && order_.rows == 0)) {
    system_.internal_force(u, w, interface);
    double* const force = interface.data();
#pragma GCC ivdep
    for (std::size_t i = 0; i < load.size(); ++i) force[i] += load[i];
    return;
  }
  const double relaxation = relaxation_, scale = scale_;
  const std::size_t n = order_.size;
  const std::optional<double>&left_end = system_.unknowns().wall(false), &right_end = system_.unknowns().wall(true);
  const auto pull_of_supports = [&] {
    for (const Support& support : system_.supports())
      (support.unknown == 0 ? interface.front() : interface.back()) -=
          support.stiffness * u[support.unknown] + support.dashpot * w[support.unknown];
  };
  const Weights& viscous = viscous_.of_rows.empty() ? elastic_ : viscous_;
  std::array<double, 2> walls{};
  const auto of_wall = [&](std::size_t end, double moved, double speed) {
    if (alike) return moved + relaxation * speed;
    return elastic_.of_edges[end] * moved + relaxation * viscous.of_edges[end] * speed;
  };
  if (left_end) walls[0] = of_wall(0, u[0] - *left_end, w[0]);
  if (right_end) walls[1] = of_wall(elastic_.of_edges.size() - 1, *right_end - u[n - 1], -w[n - 1]);
  const auto run_evenly = [&](const auto& stress) __attribute__((always_inline)) {
    end_forces(order_, stress, scale, walls, interface);
    pull_of_supports();
    eliminate_evenly(factor, stress, scale, load, y, interface);
  };
  if (alike) {
    const auto run = [&](const auto& stress) __attribute__((always_inline)) {
      if (order_.rows > 0) return run_evenly(stress);
      forces_in_order(stress, scale, walls, load, interface);
      pull_of_supports();
    };
    if (system_.bar().damped())
      run(ViscousStress{relaxation, u.data(), w.data()});
    else
      run(ElasticStress{u.data()});
    return;
  }
  const auto run = [&](const auto& stress) {
    if (even) return run_evenly(stress);
    interface_forces(stress, walls, load, interface);
    pull_of_supports();
    eliminate_unlike(factor, stress, load, y, interface);
  };
  const auto weighted = [](const auto& plain, const Weights& by) {
    return WeightedStress<std::decay_t<decltype(plain)>>{plain, by.of_edges.data(),
                                                         reinterpret_cast<const double*>(by.of_rows.data())};
  };
  if (!system_.bar().damped())
    run(weighted(ElasticStress{u.data()}, elastic_));
  else if (viscous_.of_rows.empty())
    run(weighted(ViscousStress{relaxation, u.data(), w.data()}, elastic_));
  else
    run(UnlikeStress{weighted(ElasticStress{u.data()}, elastic_), weighted(ElasticStress{w.data()}, viscous_),
                     relaxation});
}

}  // namespace viscobar
