#include "viscobar/sweep/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace viscobar {

namespace {

std::string toml(double value) {
  const std::string text = fmt::format("{}", value);
  return text.find_first_of(".e") == text.npos ? text + ".0" : text;
}

std::string toml(std::int64_t value) { return fmt::format("{}", value); }

std::string toml(const std::string& value) {
  std::string quoted = "\"";
  for (const char c : value) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      quoted += {'\\', c};
    else if (byte < 0x20 || byte == 0x7f)
      quoted += fmt::format("\\u{:04x}", byte);
    else
      quoted += c;
  }
  return quoted + '"';
}

constexpr QuantityColumn columns[] = {
    {"unknowns", "1", "scalars that the method advances"},
    {"steps", "1", "steps taken"},
    {"rhs_evaluations", "1", "evaluations of the right-hand side (of the residual for ida)"},
    {"linear_solves", "1", "linear systems solved"},
    {"events", "1", "contact changes"},
    {"reached_time", "time", "where the run ended"},
    {"max_penetration", "length", "largest penetration of an obstacle"},
    {"energy_initial", "energy", "energy at t = 0"},
    {"energy_final", "energy", "energy at the end"},
    {"energy_dissipated", "energy", "dissipated by viscosity, dashpots and impacts"},
    {"energy_work", "energy", "work of the load"},
    {"energy_balance_error", "energy", "final + dissipated + end_inertia - initial - work"},
    {"u_left_final", "length", "u(0,T)"},
    {"u_left_min", "length", "smallest u(0,t)"},
    {"u_left_max", "length", "largest u(0,t)"},
    {"u_right_final", "length", "u(L,T)"},
    {"u_right_min", "length", "smallest u(L,t)"},
    {"u_right_max", "length", "largest u(L,t)"},
    {"closings_left", "1", "contacts at the left obstacle"},
    {"time_in_contact_left", "time", "time in contact there"},
    {"impulse_left", "stress x time", "impulse of its reaction"},
    {"max_reaction_left", "stress", "largest reaction"},
    {"closings_right", "1", "contacts at the right obstacle"},
    {"time_in_contact_right", "time", "time in contact there"},
    {"impulse_right", "stress x time", "impulse of its reaction"},
    {"max_reaction_right", "stress", "largest reaction"},
    {"closings_span", "1", "contacts of nodes with the span obstacle"},
};

}  // namespace

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

std::vector<std::string> SweepPlan::derivatives() const {
  std::vector<std::string> names;
  for (const std::string& key : sensitivities)
    for (const std::string_view quantity : differentiated) names.push_back(fmt::format("{}/{}", quantity, key));
  return names;
}

std::vector<std::string> SweepPlan::overrides(std::size_t index) const {
  const std::vector<std::size_t> chosen = choice(index);
  std::vector<std::string> texts;
  for (std::size_t k = 0; k < keys.size(); ++k)
    texts.push_back(keys[k].key + "=" +
                    std::visit([&](const auto& list) { return toml(list[chosen[k]]); }, keys[k].values));
  return texts;
}

std::span<const QuantityColumn, quantities> quantity_columns() { return columns; }

std::vector<std::size_t> dispatch_order(std::span<const double> costs) {
  std::vector<std::size_t> order(costs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return costs[a] > costs[b]; });
  return order;
}

}  // namespace viscobar
