#include "studies/limit/local_power.hpp"

#include <algorithm>
#include <cmath>

namespace viscobar::limit {

namespace {

/// Products of traces on common times, as means over time and traces.
class Mean {
 public:
  explicit Mean(std::span<const double> times) : weights_(times.size(), 0.0) {
    for (std::size_t k = 0; k + 1 < times.size(); ++k) {
      const double half = 0.5 * (times[k + 1] - times[k]) / (times.back() - times.front());
      weights_[k] += half;
      weights_[k + 1] += half;
    }
  }

  /// Of value(trace, k).
  template <class Value>
  double operator()(std::size_t traces, Value value) const {
    double sum = 0.0;
    for (std::size_t trace = 0; trace < traces; ++trace)
      for (std::size_t k = 0; k < weights_.size(); ++k) sum += weights_[k] * value(trace, k);
    return sum / static_cast<double>(traces);
  }

 private:
  std::vector<double> weights_;
};

/// D = u - U of a run, and epsilon du/depsilon, by trace and time.
struct Difference {
  std::vector<const std::vector<double>*> u, limit, derivative;
  double epsilon = 0.0;

  Difference(const Run& penalised, const EndTraces& to)
      : u(EndTraces::all(penalised.traces)), limit(EndTraces::all(to)), epsilon(*penalised.run.epsilon) {
    if (!penalised.traces.sensitivities.empty()) derivative = EndTraces::all(penalised.traces.sensitivities.front());
  }
  double operator()(std::size_t trace, std::size_t k) const { return (*u[trace])[k] - (*limit[trace])[k]; }
  double change(std::size_t trace, std::size_t k) const { return epsilon * (*derivative[trace])[k]; }
  double largest_change() const {
    double largest = 0.0;
    for (const auto* trace : derivative)
      for (const double value : *trace) largest = std::max(largest, std::abs(epsilon * value));
    return largest;
  }
  /// Whether it is known to the end of the run.
  bool known() const {
    return !derivative.empty() && std::all_of(derivative.begin(), derivative.end(), [](const auto* trace) {
      return std::all_of(trace->begin(), trace->end(), [](double value) { return std::isfinite(value); });
    });
  }
};

LocalPower power_of_mean(const Difference& d, const Mean& mean, double floor, double derivative_error) {
  const std::size_t traces = d.u.size();
  LocalPower found;
  found.difference = std::sqrt(mean(traces, [&](std::size_t i, std::size_t k) { return d(i, k) * d(i, k); }));
  if (!d.known()) return found;
  const double square = found.difference * found.difference;
  found.power = mean(traces, [&](std::size_t i, std::size_t k) { return d(i, k) * d.change(i, k); }) / square;
  const double part =
      std::sqrt(mean(traces, [&](std::size_t i, std::size_t k) { return d.change(i, k) * d.change(i, k); }) / square);
  found.error = (derivative_error + 3.0 * part * floor) / found.difference;
  return found;
}

LocalPower power_of_largest(const Difference& d, double floor, double derivative_error) {
  LocalPower found;
  std::size_t trace = 0, at = 0;
  const std::size_t times = d.u.front()->size();
  for (std::size_t i = 0; i < d.u.size(); ++i)
    for (std::size_t k = 0; k < times; ++k)
      if (std::abs(d(i, k)) > found.difference) found.difference = std::abs(d(i, k)), trace = i, at = k;
  if (!d.known() || found.difference == 0.0) return found;
  const auto power = [&](std::size_t k) { return d.change(trace, k) / d(trace, at); };
  found.power = power(at);
  double between_times = 0.0;
  for (const std::size_t k : {std::max<std::size_t>(at, 1) - 1, std::min(at + 1, times - 1)})
    between_times = std::max(between_times, std::abs(power(k) - *found.power));
  found.error = between_times + (derivative_error + std::abs(*found.power) * floor) / found.difference;
  return found;
}

void compare(std::span<LimitRow> rows, std::optional<LocalPower> LimitRow::*local, double floor) {
  // How far p goes from row i to the next; 0 where that is not known.
  const auto change = [&](std::size_t i) {
    if (i + 1 >= rows.size() || !(rows[i].*local) || !(rows[i + 1].*local)) return 0.0;
    const LocalPower &here = *(rows[i].*local), &next = *(rows[i + 1].*local);
    return here.power && next.power ? std::abs(*here.power - *next.power) : 0.0;
  };
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    if (!(rows[i].*local) || !(rows[i + 1].*local)) continue;
    LocalPower& here = *(rows[i].*local);
    const LocalPower& next = *(rows[i + 1].*local);
    const double ratio = std::log(rows[i].epsilon / rows[i + 1].epsilon);
    here.observed = std::log(here.difference / next.difference) / ratio;
    if (!here.power || !next.power) continue;
    here.mean = 0.5 * (*here.power + *next.power);
    here.bound = std::max({i > 0 ? change(i - 1) : 0.0, change(i), change(i + 1)}) + 0.5 * (here.error + next.error) +
                 floor * (1.0 / here.difference + 1.0 / next.difference) / ratio;
  }
}

}  // namespace

void add_local_powers(const MeshRuns& mesh, const EndTraces& limit, double floor, std::span<LimitRow> rows) {
  const Mean mean(mesh.times);
  auto row = rows.begin();
  for (const Run& run : mesh.penalised) {
    if (run.error) continue;
    const Difference difference(run, limit);
    // Derivatives are good to 100 tolerances of the largest: docs/sensitivity.md.
    const double derivative_error = 100.0 * run.run.tolerance.relative * difference.largest_change();
    row->local_mean = power_of_mean(difference, mean, floor, derivative_error);
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
