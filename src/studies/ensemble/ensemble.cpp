#include "viscobar/studies/ensemble/ensemble.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <stdexcept>

#include "case/scene_numbers.hpp"
#include "studies/ensemble/lane_levels.hpp"
#include "studies/parallel.hpp"

namespace viscobar {

namespace {

using namespace bars;

constexpr double none = std::numeric_limits<double>::quiet_NaN();

// Bars that a thread takes at a time: many, since those of one number of steps fill a pack or not; enough for all.
std::size_t chunk_of(std::size_t bars, std::size_t threads) {
  return std::clamp<std::size_t>(bars / (8 * (threads == 0 ? cores() : threads)), 256, 2048);
}

/// True where the scene leaves the method open, and wants the motion that `rigid` and (2.8) have in the limit.
bool wants_limit(const Case& run) {
  return run.automatic && (run.method == MethodName::rigid || run.method == MethodName::characteristics);
}

/// One call of ensemble().
class EnsembleRun {
 public:
  explicit EnsembleRun(const EnsembleStudy& study)
      : study_(study), bars_(count_of(study)), chunk_(chunk_of(bars_, study.threads)), first_(first_setup()) {
    if (study.error && !(*study.error > 0.0 && *study.error < 1.0))
      throw std::invalid_argument(fmt::format("error: is a share between 0 and 1, is {}", *study.error));
    const Case& run = first_.run;
    std::vector<EnsembleOutput> outputs;
    for (const std::string& text : study.outputs) outputs.push_back(ensemble_output(text, run));
    layout_.emplace(std::move(outputs), run, study.error.has_value());
    const bool rigid = study.error && run.automatic && run.method == MethodName::rigid;
    // A step that the scene leaves open is each bar's own; bars side by side share one.
    const bool by_step = run.method == MethodName::fully_discrete && (study.error || run.step);
    if (study.lanes && run.scene.chain.empty() && (rigid || by_step)) members_.emplace(run, first_.mass, study.keys);
    if (members_ && (!members_->pattern() || holds_reactions())) members_.reset();
    shared_ = {run.end, first_.step, run.start, run.elements, study.error, rigid};
    result_.bars = bars_;
    result_.outputs = layout_->outputs;
    result_.values.resize(layout_->outputs.size());
    result_.status.assign(bars_, BarStatus::not_run);
    result_.ways.assign(bars_, BarWay::none);
    result_.error.assign(bars_, none);
    result_.steps.assign(bars_, 0);
  }

  EnsembleResult operator()() {
    try {
      allocate_values();
      parallel_for((bars_ + chunk_ - 1) / chunk_, [this](std::size_t k) { run_chunk(k); }, study_.threads);
      if (study_.progress) study_.progress(bars_, bars_);
    } catch (const StudyStopped&) {
    }
    return std::move(result_);
  }

 private:
  static std::size_t count_of(const EnsembleStudy& study) {
    if (study.keys.size() != study.values.size())
      throw std::invalid_argument("an ensemble has as many lists of values as keys");
    std::size_t bars = 1;
    for (std::size_t k = 0; k < study.keys.size(); ++k) {
      const std::size_t count = study.values[k].size();
      if (is_shared_by_bars(study.keys[k]))
        throw std::invalid_argument(
            fmt::format("{}: is the same for all bars: their outputs share a shape", study.keys[k]));
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

  // Piece by piece: new pages of gigabytes take seconds, in which a stop is heard.
  void allocate_values() {
    constexpr std::size_t piece = std::size_t{1} << 22;
    for (std::size_t o = 0; o < result_.values.size(); ++o) {
      const std::size_t all = bars_ * layout_->outputs[o].width();
      std::vector<double>& values = result_.values[o];
      values.reserve(all);
      while (values.size() < all) {
        if (study_.stop && study_.stop()) throw StudyStopped();
        values.resize(std::min(all, values.size() + piece), none);
      }
    }
  }

  // The setup of a bar, by `rigid` where an error is asked for, the scene leaves the method open and rigid takes it.
  Setup setup_of(const std::vector<double>& values) const {
    const Case run = study_.model(values);
    if (study_.error && wants_limit(run)) {
      Case by_rigid = run;
      by_rigid.method = MethodName::rigid;
      if (Setup setup = resolve(std::move(by_rigid)); faults(setup).empty()) return setup;
    }
    return resolve(run);
  }

  // The first bar that can be run: it tells what they have in common.
  Setup first_setup() const {
    if (!study_.common.empty()) return setup_of(study_.common);
    std::string why;
    for (std::size_t bar = 0; bar < std::min<std::size_t>(bars_, 100); ++bar) {
      try {
        Setup setup = setup_of(values_of(bar));
        if (faults(setup).empty()) return setup;
      } catch (const std::exception& error) {
        if (why.empty()) why = error.what();
      }
    }
    throw std::invalid_argument(fmt::format("none of the first bars can be run: {}", why));
  }

  // A held end's force is of its own row.
  bool holds_reactions() const {
    const auto held = [&](TraceColumn column, const EndCondition& end) {
      return is_fixed(end) && std::ranges::any_of(layout_->outputs, [&](const EnsembleOutput& output) {
               return output.kind == EnsembleOutput::Kind::trace && output.column == column;
             });
    };
    const Scene& scene = first_.run.scene;
    return held(TraceColumn::reaction_left, scene.left) || held(TraceColumn::reaction_right, scene.right);
  }

  void run_chunk(std::size_t k) {
    const std::size_t begin = k * chunk_, end = std::min(bars_, begin + chunk_);
    if (!members_) {
      for (std::size_t i = begin; i < end; ++i) run_alone(i);
      return;
    }
    std::vector<std::size_t> later;
    LaneLevels lanes(
        *members_, *layout_, shared_, study_.stop,
        [this](std::size_t i, const Told& told) { finish(i, told, BarWay::lanes); },
        [&](std::size_t i) { later.push_back(i); });
    Case numbers = first_.run;
    for (std::size_t i = begin; i < end; ++i) {
      if (auto own = members_->by_numbers(numbers, values_of(i))) {
        lanes.add(i, *std::move(own));
      } else if (auto setup = sound_setup(i)) {
        if ((own = members_->of(setup->run)))
          lanes.add(i, *std::move(own));
        else
          run_alone(i, *setup);
      }
    }
    lanes.run();
    for (const std::size_t i : later) run_alone(i);
  }

  // The same where the keys are numbers of the case, without the model: to read a scene takes a fifth of a run.
  // Absent where the model has to say what is wrong, or what method the case takes.
  std::optional<Setup> setup_by_numbers(std::size_t bar) const {
    Case run = first_.run;
    for (std::size_t k = 0; k < study_.keys.size(); ++k) {
      const std::span<const double> list = study_.values[k];
      const double value = list.size() == 1 ? list[0] : list[bar], size = std::abs(value);
      double* number = study_.keys[k] == "bar.length" ? nullptr : number_of(run, study_.keys[k]);
      if (!number || !(value == 0.0 || (size >= 1e-100 && size <= 1e100))) return std::nullopt;
      *number = value;
    }
    if (run.automatic && !(run.scene.bar.viscosity > 0.0 && first_.run.scene.bar.viscosity > 0.0)) return std::nullopt;
    std::optional<Setup> setup(resolve(std::move(run)));
    if (!faults(*setup).empty()) setup.reset();
    return setup;
  }

  // Absent, and told, where the bar's scene cannot be run.
  std::optional<Setup> sound_setup(std::size_t i) {
    if (auto setup = setup_by_numbers(i)) return setup;
    try {
      Setup setup = setup_of(values_of(i));
      const auto found = faults(setup);
      if (found.empty()) return setup;
      complain(i, BarStatus::faulty, found.front().key + " " + found.front().problem);
    } catch (const std::exception& error) {
      complain(i, BarStatus::faulty, error.what());
    }
    return std::nullopt;
  }

  void complain(std::size_t i, BarStatus status, const std::string& why) {
    {
      const std::lock_guard lock(mutex_);
      result_.messages.emplace_back(i, why);
      std::ranges::sort(result_.messages);
      if (result_.messages.size() > study_.most_messages) result_.messages.pop_back();
    }
    end_bar(i, status);
  }

  void run_alone(std::size_t i) {
    if (auto setup = sound_setup(i)) run_alone(i, *setup);
  }

  void run_alone(std::size_t i, Setup& setup) {
    result_.ways[i] = BarWay::alone;
    try {
      finish(i, bars::run_alone(setup, *layout_, study_.error, study_.stop), BarWay::alone);
    } catch (const StudyStopped&) {
      throw;
    } catch (const std::exception& error) {
      complain(i, BarStatus::failed, error.what());
    }
  }

  void finish(std::size_t i, const Told& told, BarWay way) {
    for (std::size_t o = 0; o < layout_->outputs.size(); ++o) {
      const std::size_t width = layout_->outputs[o].width();
      std::copy_n(told.values->values.begin() + static_cast<std::ptrdiff_t>(layout_->first[o]), width,
                  result_.values[o].begin() + static_cast<std::ptrdiff_t>(i * width));
    }
    result_.error[i] = told.error, result_.ways[i] = way, result_.steps[i] = told.steps;
    end_bar(i, !study_.error || told.error <= *study_.error ? BarStatus::kept : BarStatus::not_kept);
  }

  void end_bar(std::size_t i, BarStatus status) {
    result_.status[i] = status;
    const std::size_t done = ++done_;
    if (!study_.progress || done % 512 != 0) return;
    const std::lock_guard lock(mutex_);
    study_.progress(done, bars_);
  }

  const EnsembleStudy& study_;
  std::size_t bars_, chunk_;
  Setup first_;
  std::optional<Layout> layout_;
  std::optional<Members> members_;
  Shared shared_{};
  EnsembleResult result_;
  std::mutex mutex_;
  std::atomic<std::size_t> done_{0};
};

}  // namespace

EnsembleResult ensemble(const EnsembleStudy& study) { return EnsembleRun(study)(); }

}  // namespace viscobar
