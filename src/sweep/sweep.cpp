#include "viscobar/sweep/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace viscobar {

std::size_t VariedKey::size() const {
  return std::visit([](const auto& list) { return list.size(); }, values);
}

std::size_t SweepPlan::size() const {
  if (combine == Combine::zip) return keys.empty() ? 0 : keys.front().size();
  std::size_t product = 1;
  for (const VariedKey& key : keys) product *= key.size();
  return product;
}

std::vector<std::size_t> SweepPlan::choice(std::size_t index) const {
  std::vector<std::size_t> chosen(keys.size(), index);
  if (combine == Combine::zip) return chosen;
  for (std::size_t k = keys.size(); k-- > 0;) {
    chosen[k] = index % keys[k].size();
    index /= keys[k].size();
  }
  return chosen;
}

std::vector<QuantityColumn> SweepPlan::columns() const {
  if (!bars.empty()) return bars;
  const auto own = quantity_columns();
  std::vector<QuantityColumn> all(own.begin(), own.end());
  const QuantityColumn of_joint[joint_values] = {{"closings", "1", "contacts at the joint"},
                                                 {"time_in_contact", "time", "time in contact there"},
                                                 {"impulse", "force x time", "impulse of the force between its sides"},
                                                 {"max_reaction", "force", "largest force"}};
  for (std::size_t k = 1; k <= joints; ++k)
    for (const auto& [name, unit, meaning] : of_joint)
      all.push_back({fmt::format("{}_joint:{}", name, k), unit, meaning});
  if (accuracy)
    all.insert(all.end(), {{"chosen_elements", "1", "elements of the solution"},
                           {"chosen_tolerance", "1", "its relative tolerance"},
                           {"chosen_step", "time", "its step, of a scheme"},
                           {"chosen_epsilon", "length / force", "its penalty"}});
  for (const std::string& key : sensitivities)
    for (const std::string_view quantity : differentiated)
      all.push_back({fmt::format("{}/{}", quantity, key), "", "derivative of the one by the other"});
  return all;
}

std::vector<Setting> SweepPlan::settings(std::size_t index) const {
  const std::vector<std::size_t> chosen = choice(index);
  std::vector<Setting> all;
  for (std::size_t k = 0; k < keys.size(); ++k)
    all.emplace_back(std::pair(
        keys[k].key, std::visit([&](const auto& list) { return SceneValue(list[chosen[k]]); }, keys[k].values)));
  return all;
}

std::span<const QuantityColumn, quantities> quantity_columns() {
  static const QuantityColumn of_quantities[] = {
      {"unknowns", "1", "scalars that the method advances"},
      {"steps", "1", "steps taken"},
      {"rhs_evaluations", "1", "evaluations of the right-hand side (of the residual for ida)"},
      {"linear_solves", "1", "linear systems solved"},
      {"events", "1", "contact changes"},
      {"reached_time", "time", "where the run ended"},
      {"max_penetration", "length", "largest penetration of an obstacle"},
      {"energy_initial", "energy", "energy at t = 0"},
      {"energy_final", "energy", "energy at the end"},
      {"energy_dissipated", "energy", "dissipated by viscosity, dashpots, impacts and end rows of the mass"},
      {"energy_work", "energy", "work of the load"},
      {"energy_balance_error", "energy", "final + dissipated - initial - work"},
      {"u_left_final", "length", "u(0,T)"},
      {"u_left_min", "length", "smallest u(0,t)"},
      {"u_left_max", "length", "largest u(0,t)"},
      {"u_right_final", "length", "u(L,T)"},
      {"u_right_min", "length", "smallest u(L,t)"},
      {"u_right_max", "length", "largest u(L,t)"},
      {"closings_left", "1", "contacts at the left obstacle"},
      {"time_in_contact_left", "time", "time in contact there"},
      {"impulse_left", "force x time", "impulse of its reaction"},
      {"max_reaction_left", "force", "largest reaction"},
      {"closings_right", "1", "contacts at the right obstacle"},
      {"time_in_contact_right", "time", "time in contact there"},
      {"impulse_right", "force x time", "impulse of its reaction"},
      {"max_reaction_right", "force", "largest reaction"},
      {"closings_span", "1", "contacts of nodes with the span obstacle"},
  };
  return of_quantities;
}

std::string SweepPart::name() const { return fmt::format("part-{}-of-{}", number, of); }

std::vector<bool> SweepPart::own(std::size_t cases) const {
  // Vigna's splitmix64 takes no two numbers to one.
  const auto shuffled = [](std::uint64_t i) {
    i += 0x9e3779b97f4a7c15;
    i = (i ^ (i >> 30)) * 0xbf58476d1ce4e5b9;
    i = (i ^ (i >> 27)) * 0x94d049bb133111eb;
    return i ^ (i >> 31);
  };
  std::vector<bool> all(cases, of == 1);
  if (of == 1) return all;
  std::vector<std::size_t> pack(cases);
  std::iota(pack.begin(), pack.end(), std::size_t{0});
  std::ranges::sort(pack, {}, shuffled);
  for (std::size_t k = number - 1; k < cases; k += of) all[pack[k]] = true;
  return all;
}

std::vector<std::size_t> dispatch_order(std::span<const double> costs) {
  std::vector<std::size_t> order(costs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return costs[a] > costs[b]; });
  return order;
}

}  // namespace viscobar
