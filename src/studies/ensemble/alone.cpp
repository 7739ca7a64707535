#include "studies/ensemble/alone.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "case/method_table.hpp"
#include "studies/column_reader.hpp"
#include "studies/run_limits.hpp"

namespace viscobar::bars {

namespace {

/// Takes what the outputs of a bar, or of bars in line, are from its states.
class Reader {
 public:
  Reader(const Layout& layout, const BarSystem& system, const Scene& scene)
      : layout_(layout), joints_(system.elements().joints()) {
    using Kind = EnsembleOutput::Kind;
    for (const EnsembleOutput& output : layout.outputs) {
      auto& column = columns_.emplace_back();
      auto& gauge = gauges_.emplace_back();
      if (output.kind == Kind::trace) column.emplace(output.column, output.place, system, scene);
      if (output.kind == Kind::gauge) gauge.emplace(system.mesh(), scene, output.place);
    }
  }

  /// At layout.times[t], the looks from the last one on.
  void operator()(const Snapshot& at, BarValues& values) {
    const double time = layout_.looks[look_].time;
    for (; look_ < layout_.looks.size() && layout_.looks[look_].time == time; ++look_) {
      const auto [when, i, k] = layout_.looks[look_];
      if (i == Layout::Look::probe) {
        probe(at, k, values);
        continue;
      }
      double* const to = &values.values[layout_.first[i]];
      if (columns_[i]) {
        to[k] = (*columns_[i])(at);
        continue;
      }
      if (!gauges_[i] && 2 * at.u.size() != layout_.outputs[i].width())
        throw std::runtime_error(fmt::format("it has {} nodes where others have {}: give each bar its elements",
                                             at.u.size(), layout_.outputs[i].width() / 2));
      write_fields(gauges_[i] ? &*gauges_[i] : nullptr, at.u, at.v, gauges_[i] ? to + 4 * k : to);
    }
  }

 private:
  void probe(const Snapshot& at, std::size_t k, BarValues& values) const {
    if (k < BarValues::probes) values.ends[0][k] = at.u.front(), values.ends[1][k] = at.u.back();
    values.largest = std::max({values.largest, std::abs(at.u.front()), std::abs(at.u.back())});
    for (const JointNodes& joint : joints_)
      for (const double u : {at.u[joint.node - 1], at.u[joint.node]}) {
        values.joints.push_back(u);
        values.largest = std::max(values.largest, std::abs(u));
      }
  }

  const Layout& layout_;
  const std::vector<JointNodes>& joints_;
  std::vector<std::optional<ColumnReader>> columns_;
  std::vector<std::optional<Gauge>> gauges_;
  std::size_t look_ = 0;
};

}  // namespace

Told run_alone(Setup& setup, const Layout& layout, std::optional<double> error, const std::function<bool()>& stop) {
  const Case& run = setup.run;
  const BarSystem system = setup.system();
  std::size_t steps = 0;
  const auto once = [&] {
    auto values = std::make_unique<BarValues>(layout);
    Reader read(layout, system, run.scene);
    std::vector<double> changes;
    changes.reserve(std::min<std::size_t>(layout.most_changes, 16));
    Observers observers;
    observers.off_the_clock = false;
    observers.reactions = layout.reactions;
    observers.interior = layout.fields;
    observers.account = layout.impulses || layout.peaks;
    observers.extremes = {.ranges = false, .peaks = layout.peaks};
    observers.snapshot = [&](const Snapshot& at) { read(at, *values); };
    observers.event = [&](const Event& event) {
      if (changes.size() < layout.most_changes) changes.push_back(event.time);
    };
    const Statistics done = simulate_within({.stop = stop}, setup, system, layout.times, observers);
    steps = done.steps;
    for (const std::size_t k : layout.inside) values->inside.push_back(values->values[k]);
    values->changes_at(layout, changes);
    if (done.account) {
      std::vector<double> impulses, peaks;
      const auto tell = [&](const auto& account) {
        impulses.push_back(account.impulse), peaks.push_back(account.peak_reaction);
      };
      tell(done.account->left), tell(done.account->right);
      for (std::size_t k = 0; k + 1 < run.scene.chain.size(); ++k) tell(done.account->joint(k + 1));
      values->accounts(layout, impulses, peaks);
    }
    return values;
  };
  // Finer by the tolerance, or by the step of a scheme that the scene left open.
  const bool adaptive = is_adaptive(run.method), halves = !adaptive && run.automatic && !run.step;
  if (!error || !(adaptive || halves)) return {once(), std::numeric_limits<double>::quiet_NaN(), steps};
  const int most = adaptive ? 5 : 10;
  // Bounces lower than the tolerance are left out, each by restitution^2 lower than the one before, so that tolerances
  // a decade apart may leave out the same ones. The changes behind them would be told as theirs.
  const bool bounces = layout.most_changes > 0 && run.restitution.value_or(0.0) > 0.0;
  const double refinement = bounces ? 1e4 : 10.0;
  std::unique_ptr<BarValues> coarse;
  double tolerance = *error;
  for (int k = 0;; ++k, tolerance = std::max(tolerance / refinement, 1e-13)) {
    if (adaptive)
      setup.run.tolerance = {tolerance, std::nullopt, run.tolerance.control};
    else if (k > 0)
      setup.step /= 2.0;
    setup.method = method_row(run.method).options(setup);
    std::unique_ptr<BarValues> fine = once();
    if (coarse) {
      const double apart = difference(layout, *coarse, *fine, run.end);
      // An impact within a step is of first order, and told to a step.
      const double found = adaptive ? std::max(0.4 * apart, 0.1 * tolerance)
                                    : std::max(1.5 * apart, fine->changes.empty() ? rounding : setup.step / run.end);
      if (found <= *error || k == most || (adaptive && tolerance < 1e-12)) return {std::move(fine), found, steps};
    }
    coarse = std::move(fine);
  }
}

}  // namespace viscobar::bars
