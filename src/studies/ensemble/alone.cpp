#include "studies/ensemble/alone.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "case/method_table.hpp"

namespace viscobar::bars {

Told run_alone(Setup setup, const Layout& layout, std::optional<double> error, const std::function<bool()>& stop) {
  const Case& run = setup.run;
  const BarSystem system = setup.system();
  std::size_t steps = 0;
  const auto once = [&] {
    auto values = std::make_unique<BarValues>(layout);
    std::size_t look = 0;
    std::vector<double> changes;
    Observers observers;
    observers.off_the_clock = false;
    observers.reactions = layout.reactions;
    observers.interior = layout.fields;
    observers.account = layout.impulses || layout.extremes;
    observers.extremes = layout.extremes;
    observers.snapshot = [&](const Snapshot& at) {
      look = values->look(layout, run.scene.bar, look, {at.u, at.v, at.reaction_left, at.reaction_right});
    };
    observers.event = [&](const Event& event) {
      if (changes.size() < layout.most_changes) changes.push_back(event.time);
    };
    if (stop) observers.progress = [&](double) { return stop() ? RunControl::stop : RunControl::go_on; };
    const Statistics done = simulate(setup, system, layout.times, observers);
    if (!done.completed) throw Stopped();
    steps = done.steps;
    values->changes_at(layout, changes);
    if (done.account)
      values->accounts(layout, {done.account->left.impulse, done.account->right.impulse},
                       {done.account->left.peak_reaction, done.account->right.peak_reaction});
    return values;
  };
  // Finer by the tolerance, or by the step of a scheme that the scene left open.
  const bool adaptive = is_adaptive(run.method), halves = !adaptive && run.automatic && !run.step;
  if (!error || !(adaptive || halves)) return {once(), std::numeric_limits<double>::quiet_NaN(), steps};
  const int most = adaptive ? 5 : 10;
  std::unique_ptr<BarValues> coarse;
  double tolerance = *error;
  for (int k = 0;; ++k, tolerance /= 10.0) {
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
