#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>

#include "run/stopwatch.hpp"
#include "sweep/sweep_bars.hpp"
#include "text/printable_text.hpp"
#include "viscobar/studies/ensemble/ensemble.hpp"

namespace viscobar {

std::vector<SweepRow> run_bars(const SweepFile& sweep, std::span<const std::size_t> indices,
                               const std::function<bool()>& interrupted) {
  const WallClock clock;
  const Stopwatch watch;
  EnsembleStudy study;
  std::vector<std::vector<double>> values(sweep.plan.keys.size());
  for (const std::size_t index : indices) {
    const std::vector<double> own = values_of_bar(sweep.plan, index);
    for (std::size_t k = 0; k < own.size(); ++k) values[k].push_back(own[k]);
  }
  for (std::size_t k = 0; k < values.size(); ++k) {
    study.keys.push_back(sweep.plan.keys[k].key);
    study.values.emplace_back(values[k]);
  }
  study.model = [&](std::span<const double> at) { return case_of_bar(sweep, at); };
  study.outputs = sweep.ensemble.outputs;
  study.error = sweep.ensemble.error;
  study.common = sweep.ensemble.common;
  study.most_messages = indices.size();
  study.threads = 1;
  study.stop = interrupted;
  const EnsembleResult result = ensemble(study);
  const std::map<std::size_t, std::string> messages(result.messages.begin(), result.messages.end());
  const auto count = static_cast<double>(indices.size());
  std::vector<SweepRow> rows;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const BarStatus status = result.status[i];
    if (status == BarStatus::not_run) continue;
    SweepRow row;
    row.index = indices[i];
    row.completed = status == BarStatus::kept;
    row.values.clear();
    for (std::size_t o = 0; o < result.values.size(); ++o) {
      const std::size_t width = result.outputs[o].width();
      const auto own = std::span(result.values[o]).subspan(i * width, width);
      row.values.insert(row.values.end(), own.begin(), own.end());
    }
    const bool ran = status == BarStatus::kept || status == BarStatus::not_kept;
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    row.values.push_back(ran ? static_cast<double>(result.steps[i]) : none);
    row.values.push_back(ran ? static_cast<double>(result.ways[i] == BarWay::lanes) : none);
    if (study.error) row.values.push_back(result.error[i]);
    if (const auto message = messages.find(i); message != messages.end())
      row.error = fitting(one_line(message->second));
    else if (status == BarStatus::not_kept)
      row.error = std::isnan(result.error[i])
                      ? "no estimate of the error could be made"
                      : fmt::format("the error that was asked for is not kept: {:.3g}", result.error[i]);
    row.seconds = clock.seconds() / count;
    row.integration_seconds = watch.seconds() / count;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace viscobar
