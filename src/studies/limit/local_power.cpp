#include <algorithm>
#include <cmath>

#include "studies/limit/mesh_runs.hpp"

namespace viscobar::limit {

namespace {

/// D = u - U of a run and epsilon du/depsilon, trace by trace, and the weights of their means over time and traces.
struct Difference {
  std::size_t times;
  std::vector<double> d, change, weights;

  Difference(const Run& penalised, const EndTraces& limit, std::span<const double> at)
      : times(at.size()), weights(at.size(), 0.0) {
    const auto u = EndTraces::all(penalised.traces), to = EndTraces::all(limit);
    for (std::size_t trace = 0; trace < u.size(); ++trace)
      for (std::size_t k = 0; k < times; ++k) d.push_back((*u[trace])[k] - (*to[trace])[k]);
    if (!penalised.traces.sensitivities.empty())
      for (const auto* derivative : EndTraces::all(penalised.traces.sensitivities.front()))
        for (const double value : *derivative) change.push_back(*penalised.run.epsilon * value);
    for (std::size_t k = 0; k + 1 < times; ++k) {
      const double half = 0.5 * (at[k + 1] - at[k]) / (at.back() - at.front());
      weights[k] += half;
      weights[k + 1] += half;
    }
  }
  double mean_product(const std::vector<double>& a, const std::vector<double>& b) const {
    double sum = 0.0;
    for (std::size_t first = 0; first < a.size(); first += times)
      for (std::size_t k = 0; k < times; ++k) sum += weights[k] * (a[first + k] * b[first + k]);
    return sum / static_cast<double>(a.size() / times);
  }
  double largest_change() const {
    double largest = 0.0;
    for (const double value : change) largest = std::max(largest, std::abs(value));
    return largest;
  }
  /// True if the derivative is known to the end of the run.
  bool known() const {
    return !change.empty() && std::ranges::all_of(change, [](double value) { return std::isfinite(value); });
  }
};

LocalPower power_of_mean(const Difference& run, double floor, double derivative_error) {
  LocalPower found;
  found.difference = std::sqrt(run.mean_product(run.d, run.d));
  if (!run.known()) return found;
  const double square = found.difference * found.difference;
  found.power = run.mean_product(run.d, run.change) / square;
  const double part = std::sqrt(run.mean_product(run.change, run.change) / square);
  found.error = (derivative_error + 3.0 * part * floor) / found.difference;
  return found;
}

LocalPower power_of_largest(const Difference& run, double floor, double derivative_error) {
  LocalPower found;
  const auto smaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const auto at = static_cast<std::size_t>(std::ranges::max_element(run.d, smaller) - run.d.begin());
  found.difference = std::abs(run.d[at]);
  if (!run.known() || found.difference == 0.0) return found;
  const auto power = [&](std::size_t i) { return run.change[i] / run.d[at]; };
  found.power = power(at);
  const std::size_t first = at - at % run.times, last = first + run.times - 1;  // of its trace
  double between_times = 0.0;
  for (const std::size_t i : {std::max(at, first + 1) - 1, std::min(at + 1, last)})
    between_times = std::max(between_times, std::abs(power(i) - *found.power));
  found.error = between_times + (derivative_error + std::abs(*found.power) * floor) / found.difference;
  return found;
}

void compare(std::span<LimitRow> rows, std::optional<LocalPower> LimitRow::*local, double floor) {
  const auto at = [&](std::size_t i) { return i < rows.size() && rows[i].*local ? &*(rows[i].*local) : nullptr; };
  // How far p goes from row i to the next; 0 where that is not known.
  const auto change = [&](std::size_t i) {
    const LocalPower *here = at(i), *next = at(i + 1);
    return here && next && here->power && next->power ? std::abs(*here->power - *next->power) : 0.0;
  };
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    LocalPower* here = at(i);
    const LocalPower* next = at(i + 1);
    if (!here || !next) continue;
    const double ratio = std::log(rows[i].epsilon / rows[i + 1].epsilon);
    here->observed = std::log(here->difference / next->difference) / ratio;
    if (!here->power || !next->power) continue;
    here->mean = 0.5 * (*here->power + *next->power);
    here->bound = std::max({i > 0 ? change(i - 1) : 0.0, change(i), change(i + 1)}) +
                  0.5 * (here->error + next->error) + floor * (1.0 / here->difference + 1.0 / next->difference) / ratio;
  }
}

}  // namespace

void add_local_powers(const MeshRuns& mesh, const EndTraces& limit, double floor, std::span<LimitRow> rows) {
  auto row = rows.begin();
  for (const Run& run : mesh.penalised) {
    if (!run.complete) continue;
    const Difference difference(run, limit, mesh.times);
    // Derivatives are good to 100 tolerances of the largest: docs/sensitivity.md.
    const double derivative_error = 100.0 * run.run.tolerance.relative * difference.largest_change();
    row->local_mean = power_of_mean(difference, floor, derivative_error);
    row->local_largest = power_of_largest(difference, floor, derivative_error);
    for (std::optional<LocalPower>* local : {&row->local_mean, &row->local_largest})
      if (!((*local)->difference > floor)) local->reset();
    ++row;
  }
  compare(rows, &LimitRow::local_mean, floor);
  compare(rows, &LimitRow::local_largest, floor);
}

}  // namespace viscobar::limit

namespace viscobar {

std::optional<bool> LocalPower::agrees() const {
  if (!observed || !mean) return std::nullopt;
  return std::abs(*observed - *mean) <= bound;
}

}  // namespace viscobar
