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
  if (!error || !is_adaptive(run.method)) return {once(), std::numeric_limits<double>::quiet_NaN(), steps};
  std::unique_ptr<BarValues> coarse;
  double tolerance = *error;
  for (int k = 0;; ++k, tolerance /= 10.0) {
    setup.run.tolerance = {tolerance, std::nullopt, run.tolerance.control};
    setup.method = method_row(run.method).options(setup);
    std::unique_ptr<BarValues> fine = once();
    if (coarse) {
      const double found = std::max(0.4 * difference(layout, *coarse, *fine, run.end), 0.1 * tolerance);
      if (found <= *error || k == 5 || tolerance < 1e-12) return {std::move(fine), found, steps};
    }
    coarse = std::move(fine);
  }
}

}  // namespace viscobar::bars
