#include "viscobar/studies/ensemble/ensemble.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

#include "studies/ensemble/bar_values.hpp"
#include "studies/ensemble/members.hpp"
#include "studies/parallel.hpp"

namespace viscobar {

namespace {

using namespace bars;

constexpr double none = std::numeric_limits<double>::quiet_NaN();
/// True where the scene leaves the method open, and wants the motion that `rigid` and (2.8) have in the limit.
bool wants_limit(const Case& run) {
  return run.automatic && (run.method == MethodName::rigid || run.method == MethodName::characteristics);
}

constexpr std::size_t chunk = 512;  // bars that a thread takes at a time

struct Stopped {};

/// One call of ensemble().
class EnsembleRun {
 public:
  explicit EnsembleRun(const EnsembleStudy& study) : study_(study), bars_(count_of(study)), first_(case_of_first()) {
    std::vector<EnsembleOutput> outputs;
    for (const std::string& text : study.outputs) outputs.push_back(ensemble_output(text, first_));
    layout_.emplace(std::move(outputs), first_);
    if (study.error && !(*study.error > 0.0 && *study.error < 1.0))
      throw std::invalid_argument(fmt::format("error: is a share between 0 and 1, is {}", *study.error));
    const bool schemes = first_.method == MethodName::fully_discrete;
    lanes_asked_ = study.lanes && (schemes || (study.error && wants_limit(first_)));
    if (study.error && wants_limit(first_)) {
      first_.method = MethodName::rigid;
      first_.automatic = false;
      first_.reservation.clear();
    }
    mass_ = resolve(first_).mass;
    if (lanes_asked_) members_.emplace(first_, mass_, study.keys);
    if (members_ && (!members_->pattern() || holds_reactions())) members_.reset();
    result_.bars = bars_;
    result_.outputs = layout_->outputs;
    for (const EnsembleOutput& output : layout_->outputs) result_.values.emplace_back(bars_ * output.width(), none);
    result_.status.assign(bars_, BarStatus::not_run);
    result_.ways.assign(bars_, BarWay::none);
    result_.error.assign(bars_, none);
    result_.steps.assign(bars_, 0);
  }

  EnsembleResult operator()() {
    try {
      parallel_for((bars_ + chunk - 1) / chunk, [this](std::size_t k) { run_chunk(k); }, study_.threads);
      if (study_.progress) study_.progress(bars_, bars_);
    } catch (const Stopped&) {
    }
    return std::move(result_);
  }

 private:
  // Steps double from level to level; level 0 has that of the scene, without a request.
  static constexpr std::size_t base_steps = 16, most_level = 11;
  static constexpr double least_order = 0.7, most_order = 1.5;  // (2.8) has 2, and less where contacts decide

  /// A bar that is looked for.
  struct Bar {
    std::size_t index;
    OwnMember own;
    std::optional<BarValues> coarse{};
    std::size_t coarse_level = 0;
    // How far the last two runs differ, and the order that three of neighbouring levels show.
    std::optional<double> difference{};
    double order = least_order;
  };

  using Pack = std::vector<std::unique_ptr<Bar>>;
  using Waiting = std::array<Pack, most_level + 1>;  // of each level

  static std::size_t count_of(const EnsembleStudy& study) {
    if (study.keys.size() != study.values.size())
      throw std::invalid_argument("an ensemble has as many lists of values as keys");
    std::size_t bars = 1;
    for (std::size_t k = 0; k < study.keys.size(); ++k) {
      const std::size_t count = study.values[k].size();
      for (const char* fixed : {"time.end", "mesh.elements", "mesh.grading", "output.every"})
        if (study.keys[k] == fixed)
          throw std::invalid_argument(fmt::format("{}: is the same for all bars: their outputs share a shape", fixed));
      if (count == 0 || (count != 1 && bars != 1 && count != bars))
        throw std::invalid_argument(
            fmt::format("{}: has {} values where others have {}: as many, or one", study.keys[k], count, bars));
      bars = std::max(bars, count);
    }
    return bars;
  }

  std::vector<double> values_of(std::size_t bar) const {
    std::vector<double> values;
    for (const std::span<const double> list : study_.values) values.push_back(list.size() == 1 ? list[0] : list[bar]);
    return values;
  }

  // The first bar that can be run: it tells what they have in common.
  Case case_of_first() const {
    std::string why;
    for (std::size_t bar = 0; bar < std::min<std::size_t>(bars_, 100); ++bar) {
      try {
        Case run = study_.model(values_of(bar));
        if (sound(run)) return run;
      } catch (const std::exception& error) {
        if (why.empty()) why = error.what();
      }
    }
    throw std::invalid_argument(fmt::format("none of the first bars can be run: {}", why));
  }

  // A held end's force is of its own row.
  bool holds_reactions() const {
    return std::ranges::any_of(layout_->outputs, [&](const EnsembleOutput& output) {
      return (output.kind == EnsembleOutput::Kind::trace && output.column == TraceColumn::reaction_left &&
              is_fixed(first_.scene.left)) ||
             (output.kind == EnsembleOutput::Kind::trace && output.column == TraceColumn::reaction_right &&
              is_fixed(first_.scene.right));
    });
  }

  void run_chunk(std::size_t k) {
    const std::size_t begin = k * chunk, end = std::min(bars_, begin + chunk);
    Waiting waiting;
    bool any = false;
    std::vector<std::size_t> alone;
    for (std::size_t i = begin; i < end; ++i) {
      auto own = members_ ? member_of(i) : std::nullopt;
      if (own) {
        const std::size_t level = study_.error ? first_level(own->member.bar) : 0;
        if (level + 2 > crossing && study_.error && rigid_takes_over()) {
          alone.push_back(i);
          continue;
        }
        waiting[level].push_back(std::make_unique<Bar>(Bar{i, std::move(*own)}));
        any = true;
      } else if (result_.status[i] == BarStatus::not_run) {
        alone.push_back(i);
      }
    }
    if (any) run_lanes(std::move(waiting), alone);
    std::ranges::sort(alone);
    for (const std::size_t i : alone) {
      run_alone(i);
      tell_done(1);
    }
  }

  std::optional<OwnMember> member_of(std::size_t i) {
    const std::vector<double> values = values_of(i);
    if (auto own = members_->by_numbers(values)) return own;
    const auto run = case_of(i);
    return run ? members_->of(*run) : std::nullopt;
  }

  // Absent, and told, where the bar's scene cannot be run.
  std::optional<Case> case_of(std::size_t i) {
    try {
      Case run = study_.model(values_of(i));
      if (study_.error && wants_limit(run)) run.method = MethodName::rigid, run.automatic = false;
      const auto found = faults(resolve(run));
      if (found.empty()) return run;
      complain(i, BarStatus::faulty, found.front().key + " " + found.front().problem);
    } catch (const std::exception& error) {
      complain(i, BarStatus::faulty, error.what());
    }
    return std::nullopt;
  }

  void complain(std::size_t i, BarStatus status, const std::string& why) {
    result_.status[i] = status;
    const std::lock_guard lock(mutex_);
    result_.messages.emplace_back(i, why);
    std::ranges::sort(result_.messages);
    if (result_.messages.size() > 100) result_.messages.pop_back();
  }

  static std::size_t steps_at(std::size_t level) { return base_steps << level; }
  double step_at(std::size_t level) const {
    return study_.error ? first_.end / static_cast<double>(steps_at(level)) : resolve(first_).step;
  }
  // The first of three: the last is about what most bars take.
  std::size_t first_level(const viscobar::Bar& bar) const {
    const double h = bar.length / static_cast<double>(first_.elements);
    const double transit = h / std::sqrt(bar.modulus / bar.density);
    const double wanted = first_.end / transit * share_of_steps / std::sqrt(*study_.error);
    const double level = std::ceil(std::log2(std::max(wanted / base_steps, 1.0)));
    return static_cast<std::size_t>(std::clamp(level, 0.0, static_cast<double>(most_level - 2)));
  }
  static constexpr double share_of_steps = 0.03;

  void run_lanes(Waiting waiting, std::vector<std::size_t>& alone) {
    LaneScheme scheme(*members_->pattern());
    for (std::size_t level = 0; level <= most_level; ++level) {
      // Bars of one level side by side. Whoever waits again does so on a finer one.
      Pack& all = waiting[level];
      for (std::size_t begin = 0; begin < all.size(); begin += lane_count) {
        const std::span<std::unique_ptr<Bar>> pack =
            std::span(all).subspan(begin, std::min(lane_count, all.size() - begin));
        if (stopped()) throw Stopped();
        std::vector<BarValues> values;
        std::vector<bool> sound_bar;
        run_pack(scheme, pack, level, values, sound_bar);
        for (std::size_t l = 0; l < pack.size(); ++l) {
          std::unique_ptr<Bar>& bar = pack[l];
          if (!sound_bar[l]) {
            alone.push_back(bar->index);
          } else if (!study_.error) {
            finish(bar->index, values[l], none, BarWay::lanes, steps_of(level));
          } else if (!bar->coarse || bar->coarse_level + 1 != level) {
            bar->coarse = std::move(values[l]), bar->coarse_level = level;
            waiting[level + 1].push_back(std::move(bar));
          } else {
            judge(std::move(bar), std::move(values[l]), level, waiting, alone);
          }
        }
      }
      all.clear();
    }
  }

  std::size_t steps_of(std::size_t level) const {
    return study_.error ? steps_at(level)
                        : static_cast<std::size_t>(std::ceil(first_.end / step_at(level) * (1.0 - 1e-12)));
  }

  // Two runs differ by (2^p - 1) of the error of the finer one, p the order that three runs show.
  void judge(std::unique_ptr<Bar> bar, BarValues fine, std::size_t level, Waiting& waiting,
             std::vector<std::size_t>& alone) {
    const double now = difference(*layout_, *bar->coarse, fine, first_.end);
    if (bar->difference && now > 0.0)
      bar->order = std::clamp(std::log2(*bar->difference / now), least_order, most_order);
    const double found = std::max(safety * now / (std::exp2(bar->order) - 1.0), rounding);
    const bool kept = found <= *study_.error;
    if (kept || level == most_level) {
      if (!kept && rigid_takes_over()) return alone.push_back(bar->index);
      return finish(bar->index, fine, found, BarWay::lanes, steps_at(level));
    }
    const bool known = bar->difference.has_value();
    bar->difference = now;
    const double more = known ? std::ceil(std::log2(found / *study_.error) / bar->order) : 1.0;
    const std::size_t next = level + static_cast<std::size_t>(std::clamp(more, 1.0, 30.0));
    if (next > crossing && rigid_takes_over()) return alone.push_back(bar->index);
    const std::size_t target = std::min(next, most_level), onward = target <= level + 1 ? target : target - 1;
    if (onward == target)
      bar->coarse = std::move(fine), bar->coarse_level = level;
    else
      bar->difference.reset();
    waiting[onward].push_back(std::move(bar));
  }
  static constexpr double safety = 1.4, rounding = 1e-12;
  static constexpr std::size_t crossing = 8;  // two runs by rigid cost less than those up to the next level
  bool rigid_takes_over() const { return first_.method == MethodName::rigid; }

  void run_pack(LaneScheme& scheme, std::span<const std::unique_ptr<Bar>> pack, std::size_t level,
                std::vector<BarValues>& values, std::vector<bool>& sound_bar) {
    std::vector<Member> members;
    for (const std::unique_ptr<Bar>& bar : pack) members.push_back(bar->own.member);
    values.assign(pack.size(), BarValues(*layout_));
    const Pattern& pattern = *members_->pattern();
    const std::size_t n = pattern.size();
    const bool fields = layout_->fields;
    const std::size_t before = fields && pattern.fixed(false) ? 1 : 0, after = fields && pattern.fixed(true) ? 1 : 0;
    const std::size_t width = fields ? n + before + after : 2;
    std::vector<double> u(width), v(width);
    std::size_t look = 0;
    LaneOutputs outputs;
    outputs.times = layout_->times;
    outputs.fields = fields;
    outputs.most_changes = std::max<std::size_t>(layout_->most_changes, 1);
    outputs.sample = [&](std::size_t, const LaneSample& at) {
      std::size_t next = look;
      for (std::size_t l = 0; l < pack.size(); ++l) {
        for (std::size_t i = 0; i < at.u.size(); ++i) u[i + before] = at.u[i][l], v[i + before] = at.v[i][l];
        if (pattern.fixed(false)) u.front() = members[l].wall[0], v.front() = 0.0;
        if (pattern.fixed(true)) u.back() = members[l].wall[1], v.back() = 0.0;
        next = values[l].look(*layout_, members[l].bar, look, {u, v, at.reaction[0][l], at.reaction[1][l]});
      }
      look = next;
    };
    LaneAccounts accounts;
    const bool definite = scheme.run(
        members, {step_at(level), first_.end, first_.start == Start::second_order || study_.error}, outputs, accounts);
    for (std::size_t l = 0; l < pack.size(); ++l) {
      sound_bar.push_back(definite && accounts.finite[l]);
      std::array<double, 2> impulse{}, peak{};
      for (const bool right : {false, true})
        impulse[right] = accounts.impulse[right][l], peak[right] = accounts.peak[right][l];
      values[l].changes_at(*layout_, accounts.changes[l]);
      values[l].accounts(*layout_, impulse, peak);
    }
  }

  // By the scene's own method; with a request at two tolerances ten times apart, until their difference allows it.
  void run_alone(std::size_t i) {
    auto run = case_of(i);
    if (!run) return;
    result_.ways[i] = BarWay::alone;
    try {
      if (!study_.error || !is_adaptive(run->method)) {
        std::size_t steps = 0;
        const BarValues values = run_case(*run, steps);
        return finish(i, values, none, BarWay::alone, steps);
      }
      std::optional<BarValues> coarse;
      double tolerance = *study_.error, found = 1.0;
      for (int k = 0;; ++k, tolerance /= 10.0) {
        run->tolerance = {tolerance, std::nullopt, run->tolerance.control};
        std::size_t steps = 0;
        BarValues fine = run_case(*run, steps);
        if (coarse) found = std::max(0.4 * difference(*layout_, *coarse, fine, first_.end), 0.1 * tolerance);
        if (coarse && (found <= *study_.error || k == 5 || tolerance < 1e-12))
          return finish(i, fine, found, BarWay::alone, steps);
        coarse = std::move(fine);
      }
    } catch (const Stopped&) {
      throw;
    } catch (const std::exception& error) {
      complain(i, BarStatus::failed, error.what());
    }
  }

  BarValues run_case(const Case& run, std::size_t& steps) {
    const Setup setup = resolve(run);
    BarValues values(*layout_);
    std::size_t look = 0;
    std::vector<double> changes;
    Observers observers;
    observers.off_the_clock = false;
    observers.reactions = layout_->reactions;
    observers.account = layout_->impulses || layout_->extremes;
    observers.extremes = layout_->extremes;
    observers.snapshot = [&](const Snapshot& at) {
      look = values.look(*layout_, run.scene.bar, look, {at.u, at.v, at.reaction_left, at.reaction_right});
    };
    observers.event = [&](const Event& event) {
      if (changes.size() < std::max<std::size_t>(layout_->most_changes, 1)) changes.push_back(event.time);
    };
    if (study_.stop) observers.progress = [this](double) { return stopped() ? RunControl::stop : RunControl::go_on; };
    const Statistics done = simulate(setup, layout_->times, observers);
    if (!done.completed) throw Stopped();
    steps = done.steps;
    values.changes_at(*layout_, changes);
    if (done.account)
      values.accounts(*layout_, {done.account->left.impulse, done.account->right.impulse},
                      {done.account->left.peak_reaction, done.account->right.peak_reaction});
    return values;
  }

  void finish(std::size_t i, const BarValues& values, double error, BarWay way, std::size_t steps) {
    for (std::size_t o = 0; o < layout_->outputs.size(); ++o) {
      const std::size_t width = layout_->outputs[o].width();
      std::copy_n(values.values.begin() + static_cast<std::ptrdiff_t>(layout_->first[o]), width,
                  result_.values[o].begin() + static_cast<std::ptrdiff_t>(i * width));
    }
    result_.status[i] = study_.error && error > *study_.error ? BarStatus::not_kept : BarStatus::kept;
    result_.error[i] = error, result_.ways[i] = way, result_.steps[i] = steps;
    if (way == BarWay::lanes) tell_done(1);
  }

  void tell_done(std::size_t more) {
    const std::size_t done = done_ += more;
    if (!study_.progress || done / chunk == (done - more) / chunk) return;
    const std::lock_guard lock(mutex_);
    study_.progress(done, bars_);
  }
  bool stopped() const { return study_.stop && study_.stop(); }

  const EnsembleStudy& study_;
  std::size_t bars_;
  Case first_;
  std::optional<Layout> layout_;
  bool lanes_asked_ = false;
  Mass mass_{};
  std::optional<Members> members_;
  EnsembleResult result_;
  std::mutex mutex_;
  std::atomic<std::size_t> done_{0};
};

}  // namespace

EnsembleResult ensemble(const EnsembleStudy& study) { return EnsembleRun(study)(); }

}  // namespace viscobar
