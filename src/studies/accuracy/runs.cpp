#include "studies/accuracy/runs.hpp"

#include <algorithm>
#include <utility>

#include "case/run_cost.hpp"
#include "run/stopwatch.hpp"
#include "studies/parallel.hpp"

namespace viscobar::accuracy {

Runs::Runs(std::function<Case(const Setting&)> make, std::vector<double> times, bool peaks, std::size_t threads,
           std::function<bool()> stop)
    : make_(std::move(make)),
      times_(std::move(times)),
      peaks_(peaks),
      threads_(threads > 0 ? threads : cores()),
      stop_(std::move(stop)) {}

Runs::~Runs() {
  abandoned_ = true;
  if (begun_.valid()) begun_.wait();
}

std::vector<Setting> Runs::unknown(std::vector<Setting> settings) const {
  std::sort(settings.begin(), settings.end(), [](const Setting& a, const Setting& b) { return b < a; });
  settings.erase(std::unique(settings.begin(), settings.end()), settings.end());
  std::erase_if(settings, [&](const Setting& one) { return knows(one); });
  return settings;
}

// How many of them take so long that a thread, which costs some 30 microseconds, is worth its start: by the time of
// those that were made, which grows no faster than the elements. Before them by the estimate of any run, which may be
// several times too large where meshes are small.
std::size_t Runs::long_ones(const std::vector<Setting>& settings) const {
  constexpr double seconds = 1e-3, too_large = 5.0;
  const auto expected = [&](const Setting& one) {
    if (made_.empty()) return estimated_seconds(resolve(make_(one))) / too_large;
    const auto& [known, statistics] = made_.back();
    const double finer = static_cast<double>(one.elements) / static_cast<double>(known.elements);
    return statistics.integration_seconds * std::max(1.0, finer);
  };
  return static_cast<std::size_t>(
      std::count_if(settings.begin(), settings.end(), [&](const Setting& one) { return expected(one) >= seconds; }));
}

Runs::Batch Runs::work(std::vector<Setting> settings, std::size_t threads, double most) const {
  Batch batch{std::move(settings), {}, 0.0};
  batch.found.resize(batch.settings.size());
  const double workers = static_cast<double>(std::clamp<std::size_t>(batch.settings.size(), 1, threads));
  std::atomic<double> used = 0.0;
  const auto stop = [&] { return abandoned_ || (stop_ && stop_()); };
  const auto run = [&](std::size_t i) {
    const Stopwatch clock;
    try {
      batch.found[i] = sample_of(make_(batch.settings[i]), times_, {stop, most - used / workers}, peaks_);
    } catch (const TooLong&) {  // those that came to their end are kept
    }
    used += clock.seconds();
  };
  parallel_for(batch.settings.size(), run, threads);
  batch.seconds = used / workers;
  return batch;
}

void Runs::keep(Batch batch) {
  seconds_ += batch.seconds;
  for (std::size_t i = 0; i < batch.settings.size(); ++i) {
    if (!batch.found[i]) throw TooLong();
    made_.emplace_back(batch.settings[i], batch.found[i]->statistics);
    samples_.emplace(batch.settings[i], std::move(*batch.found[i]));
  }
}

void Runs::make(std::vector<Setting> settings) {
  finish();
  settings = unknown(std::move(settings));
  if (settings.empty()) return;
  const std::size_t threads = threads_ > 1 && long_ones(settings) > 1 ? threads_ : 1;
  keep(work(std::move(settings), threads, most_seconds - seconds_));
}

void Runs::begin(std::vector<Setting> settings) {
  finish();
  settings = unknown(std::move(settings));
  if (threads_ < 2 || long_ones(settings) == 0) return;
  begun_ = std::async(std::launch::async, [this, settings = std::move(settings)]() mutable {
    return work(std::move(settings), threads_ - 1, RunLimits().seconds);
  });
}

void Runs::finish() {
  if (begun_.valid()) keep(begun_.get());
}

std::vector<Setting> Runs::known() const {
  std::vector<Setting> all;
  for (const auto& [setting, sample] : samples_)
    if (!setting.nudged && !setting.stopped) all.push_back(setting);
  return all;
}

}  // namespace viscobar::accuracy
