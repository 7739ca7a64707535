#include "studies/ensemble/bar_values.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace viscobar::bars {

Layout::Layout(std::vector<EnsembleOutput> told, const Case& run, bool judged)
    : outputs(std::move(told)), gauges(outputs.size()), mesh(run.mesh()) {
  using Kind = EnsembleOutput::Kind;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const EnsembleOutput& output = outputs[i];
    first.push_back(width);
    width += output.width();
    fields |= output.kind == Kind::gauge || output.kind == Kind::final || !run.scene.chain.empty();
    reactions |= output.kind == Kind::trace &&
                 (output.column == TraceColumn::reaction_left || output.column == TraceColumn::reaction_right ||
                  output.column == TraceColumn::force_of);
    peaks |= output.kind == Kind::peak;
    impulses |= output.kind == Kind::impulse;
    most_changes = std::max(most_changes, output.most);
    if (output.kind == Kind::gauge) {
      gauges[i].emplace(mesh, run.scene, output.place);
      for (std::size_t k = 0; k < output.times.size(); ++k) inside.push_back(first[i] + 4 * k);
    }
    if (output.kind == Kind::final)
      for (std::size_t k = 0; k < output.width() / 2; ++k) inside.push_back(first[i] + k);
    for (std::size_t k = 0; k < output.times.size(); ++k) looks.push_back({output.times[k], i, k});
    if (output.kind == Kind::final) looks.push_back({run.end, i, 0});
  }
  // Probes lie at times of the finest output, or between them.
  constexpr double probes = BarValues::probes;
  double every = run.end;
  for (const EnsembleOutput& output : outputs)
    if (output.times.size() > 2) every = std::min(every, output.times[1]);
  if (run.end > probes * every) intervals = static_cast<std::size_t>(std::ceil(run.end / (probes * every)));
  period = intervals > 1 ? static_cast<double>(intervals) * every
                         : every / std::floor(probes * every / run.end * (1.0 + 1e-12));
  const auto count = static_cast<std::size_t>(run.end / period * (1.0 + 1e-12));
  const std::size_t asked = looks.size();
  for (std::size_t j = 0; judged && j < std::min(count, BarValues::probes); ++j) {
    double time = std::min(period * static_cast<double>(j + 1), run.end);
    for (std::size_t k = 0; k < asked; ++k)  // the same to the bit
      if (std::abs(looks[k].time - time) < 1e-12 * run.end) time = looks[k].time;
    looks.push_back({time, Look::probe, j});
  }
  looks.push_back({run.end, Look::probe, BarValues::probes});
  looks.push_back({0.0, Look::probe, BarValues::probes});  // a run has two times at least
  std::ranges::stable_sort(looks, {}, &Look::time);
  for (const Look& one : looks)
    if (times.empty() || times.back() != one.time) times.push_back(one.time);
}

BarValues::BarValues(const Layout& layout) : values(layout.width, std::numeric_limits<double>::quiet_NaN()) {}

void write_fields(const Gauge* gauge, std::span<const double> u, std::span<const double> v, double* to) {
  if (gauge) {
    const Gauge::Reading reading = (*gauge)(u, v);
    to[0] = reading.u, to[1] = reading.v, to[2] = reading.strain, to[3] = reading.stress;
  } else {
    std::ranges::copy(u, to);
    std::ranges::copy(v, to + u.size());
  }
}

void BarValues::changes_at(const Layout& layout, std::span<const double> times) {
  changes.assign(times.begin(), times.end());
  for (std::size_t i = 0; i < layout.outputs.size(); ++i)
    if (const EnsembleOutput& output = layout.outputs[i]; output.kind == EnsembleOutput::Kind::events)
      std::copy_n(times.begin(), std::min(times.size(), output.most),
                  values.begin() + static_cast<std::ptrdiff_t>(layout.first[i]));
}

void BarValues::accounts(const Layout& layout, std::span<const double> of_impulse, std::span<const double> peak) {
  std::ranges::copy(of_impulse.first(2), impulse.begin());
  impulses.assign(of_impulse.begin() + 2, of_impulse.end());
  for (std::size_t i = 0; i < layout.outputs.size(); ++i) {
    const EnsembleOutput& output = layout.outputs[i];
    if (output.kind == EnsembleOutput::Kind::impulse) values[layout.first[i]] = of_impulse[output.account];
    if (output.kind == EnsembleOutput::Kind::peak) values[layout.first[i]] = peak[output.account];
  }
}

// Where an end rests at all probes, means alone tell of its way there. By trapezia they are wrong by more than the
// motion where it stops within a step.
constexpr double share_of_means = 0.1;

double difference(const Layout& layout, const BarValues& a, const BarValues& b, double end) {
  double largest = 0.0;
  for (const bool right : {false, true})
    for (std::size_t k = 0; k < BarValues::probes; ++k)
      largest = std::max({largest, std::abs(a.ends[right][k] - b.ends[right][k]),
                          share_of_means * std::abs(a.means[right][k] - b.means[right][k])});
  for (std::size_t k = 0; k < a.joints.size(); ++k) largest = std::max(largest, std::abs(a.joints[k] - b.joints[k]));
  double size = std::max(a.largest, b.largest);
  for (std::size_t k = 0; k < b.inside.size(); ++k) {
    largest = std::max(largest, std::abs(a.inside[k] - b.inside[k]));
    size = std::max({size, std::abs(a.inside[k]), std::abs(b.inside[k])});
  }
  double worst = size > 0.0 ? largest / size : 0.0;
  if (layout.impulses) {
    double most = std::max(std::abs(b.impulse[0]), std::abs(b.impulse[1])), apart = 0.0;
    for (const bool right : {false, true}) apart = std::max(apart, std::abs(a.impulse[right] - b.impulse[right]));
    for (std::size_t k = 0; k < b.impulses.size(); ++k) {
      most = std::max(most, std::abs(b.impulses[k]));
      apart = std::max(apart, std::abs(a.impulses[k] - b.impulses[k]));
    }
    if (most > 0.0) worst = std::max(worst, apart / most);
  }
  if (layout.most_changes > 0) {
    // A change that only one of them has comes to the other at the end or later.
    const auto change = [end](const BarValues& of, std::size_t k) {
      return k < of.changes.size() ? of.changes[k] : end;
    };
    const std::size_t count = std::max(a.changes.size(), b.changes.size());
    for (std::size_t k = 0; k < count; ++k) worst = std::max(worst, std::abs(change(a, k) - change(b, k)) / end);
  }
  return worst;
}

}  // namespace viscobar::bars
