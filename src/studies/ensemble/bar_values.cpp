#include "studies/ensemble/bar_values.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace viscobar::bars {

Layout::Layout(std::vector<EnsembleOutput> told, const Case& run, bool judged)
    : outputs(std::move(told)), mesh(run.mesh()) {
  using Kind = EnsembleOutput::Kind;
  mesh.length = 1.0;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const EnsembleOutput& output = outputs[i];
    first.push_back(width);
    width += output.width();
    fields |= output.kind == Kind::gauge || output.kind == Kind::final;
    reactions |= output.kind == Kind::trace &&
                 (output.column == TraceColumn::reaction_left || output.column == TraceColumn::reaction_right);
    extremes |= output.kind == Kind::peak;
    impulses |= output.kind == Kind::impulse;
    most_changes = std::max(most_changes, output.most);
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

void read(const Layout& layout, const EnsembleOutput& output, const Bar& bar, const Fields& at, std::size_t k,
          double* to) {
  using Kind = EnsembleOutput::Kind;
  if (output.kind == Kind::trace) {
    to[k] = ColumnReader(output.column)(at);
  } else if (output.kind == Kind::gauge) {
    Mesh mesh = layout.mesh;
    mesh.length = bar.length;
    const Gauge::Reading reading = Gauge(mesh, bar, output.place)(at.u, at.v);
    to[4 * k] = reading.u, to[4 * k + 1] = reading.v, to[4 * k + 2] = reading.strain, to[4 * k + 3] = reading.stress;
  } else {
    std::ranges::copy(at.u, to);
    std::ranges::copy(at.v, to + at.u.size());
  }
}

std::size_t BarValues::look(const Layout& layout, const Bar& bar, std::size_t look, const Fields& at) {
  const double time = layout.looks[look].time;
  for (; look < layout.looks.size() && layout.looks[look].time == time; ++look) {
    const auto [when, i, k] = layout.looks[look];
    if (i != Layout::Look::probe) {
      read(layout, layout.outputs[i], bar, at, k, &values[layout.first[i]]);
      continue;
    }
    if (k < probes) ends[0][k] = at.u.front(), ends[1][k] = at.u.back();
    largest = std::max({largest, std::abs(at.u.front()), std::abs(at.u.back())});
  }
  return look;
}

void BarValues::changes_at(const Layout& layout, std::span<const double> times) {
  changes.assign(times.begin(), times.end());
  for (std::size_t i = 0; i < layout.outputs.size(); ++i)
    if (const EnsembleOutput& output = layout.outputs[i]; output.kind == EnsembleOutput::Kind::events)
      std::copy_n(times.begin(), std::min(times.size(), output.most),
                  values.begin() + static_cast<std::ptrdiff_t>(layout.first[i]));
}

void BarValues::accounts(const Layout& layout, const std::array<double, 2>& of_impulse,
                         const std::array<double, 2>& peak) {
  impulse = of_impulse;
  for (std::size_t i = 0; i < layout.outputs.size(); ++i) {
    const EnsembleOutput& output = layout.outputs[i];
    if (output.kind == EnsembleOutput::Kind::impulse) values[layout.first[i]] = of_impulse[output.right];
    if (output.kind == EnsembleOutput::Kind::peak) values[layout.first[i]] = peak[output.right];
  }
}

double difference(const Layout& layout, const BarValues& a, const BarValues& b, double end) {
  double largest = 0.0;
  for (const bool right : {false, true})
    for (std::size_t k = 0; k < BarValues::probes; ++k)
      largest = std::max(largest, std::abs(a.ends[right][k] - b.ends[right][k]));
  const double size = std::max(a.largest, b.largest);
  double worst = size > 0.0 ? largest / size : 0.0;
  if (layout.impulses) {
    const double most = std::max(std::abs(b.impulse[0]), std::abs(b.impulse[1]));
    for (const bool right : {false, true})
      if (most > 0.0) worst = std::max(worst, std::abs(a.impulse[right] - b.impulse[right]) / most);
  }
  if (layout.most_changes > 0) {
    // A change that only one of them has is an error of its whole time.
    const std::size_t count = std::max(a.changes.size(), b.changes.size());
    for (std::size_t k = 0; k < count; ++k)
      worst = std::max(
          worst, k < a.changes.size() && k < b.changes.size() ? std::abs(a.changes[k] - b.changes[k]) / end : 1.0);
  }
  return worst;
}

}  // namespace viscobar::bars
