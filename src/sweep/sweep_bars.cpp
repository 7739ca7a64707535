#include "sweep/sweep_bars.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <new>
#include <set>
#include <stdexcept>

#include "case/run_cost.hpp"
#include "input/described_scene.hpp"
#include "input/toml_text.hpp"
#include "run/stopwatch.hpp"
#include "text/printable_text.hpp"
#include "viscobar/studies/ensemble/ensemble.hpp"

namespace viscobar {

namespace {

Case case_with(const SweepFile& sweep, std::span<const double> values) {
  std::vector<Setting> settings = sweep.settings;
  for (std::size_t k = 0; k < values.size(); ++k)
    settings.emplace_back(std::pair(sweep.plan.keys[k].key, SceneValue(values[k])));
  return parse_scene_with(sweep.scene_text, "scene", settings, {}, Telling::nothing).run;
}

std::vector<double> values_of(const SweepPlan& plan, std::size_t index) {
  const std::vector<std::size_t> chosen = plan.choice(index);
  std::vector<double> values;
  for (std::size_t k = 0; k < chosen.size(); ++k)
    values.push_back(std::get<std::vector<double>>(plan.keys[k].values)[chosen[k]]);
  return values;
}

// u_left(0.1), event_2, v[7] of u_left@0.1, events:8, final: a column of each number.
void add_columns(std::vector<QuantityColumn>& all, const EnsembleOutput& output) {
  using Kind = EnsembleOutput::Kind;
  const auto unit_of = [](std::string_view quantity) {
    return quantity == "strain"        ? "1"
           : quantity == "stress"      ? "stress"
           : quantity.starts_with("u") ? "length"
           : quantity.starts_with("v") ? "length / time"
                                       : "force";
  };
  const std::string what = output.name.substr(0, output.name.rfind('@'));
  switch (output.kind) {
    case Kind::impulse: return all.push_back({output.name, "force x time", "impulse of its reaction or force"});
    case Kind::peak: return all.push_back({output.name, "force", "largest magnitude of its reaction or force"});
    case Kind::events:
      for (std::size_t k = 1; k <= output.most; ++k)
        all.push_back({fmt::format("event_{}", k), "time", "time of a contact change"});
      return;
    case Kind::trace:
      for (const double t : output.times)
        all.push_back({fmt::format("{}({:.12g})", what, t), unit_of(what), "its value at that time"});
      return;
    case Kind::gauge:
      for (const double t : output.times)
        for (const char* quantity : {"u", "v", "strain", "stress"})
          all.push_back({fmt::format("{}@{}({:.12g})", quantity, output.place, t), unit_of(quantity),
                         "its value there at that time"});
      return;
    case Kind::final:
      for (const char* quantity : {"u", "v"})
        for (std::size_t j = 0; j < output.shape.back(); ++j)
          all.push_back({fmt::format("{}[{}]", quantity, j), unit_of(quantity), "of a node at the end"});
  }
}

}  // namespace

std::vector<std::pair<std::string, std::string>> plan_bars(SweepFile& sweep) {
  std::vector<std::pair<std::string, std::string>> wrong;
  if (sweep.plan.accuracy)
    wrong.emplace_back(
        "ensemble",
        "bars side by side share a mesh, and an error of each case ([accuracy], --error) asks for one of its "
        "own; the error of the integration is ensemble.error");
  for (const VariedKey& key : sweep.plan.keys)
    if (is_shared_by_bars(key.key))
      wrong.emplace_back(key.key, "varies, and bars of [ensemble] share it: their outputs have the same shape");
    else if (!std::holds_alternative<std::vector<double>>(key.values))
      wrong.emplace_back(key.key, "varies by other than numbers, by which alone bars of [ensemble] may differ");
  if (!wrong.empty()) return wrong;

  std::string why;
  std::optional<Setup> common;
  for (std::size_t i = 0; i < std::min<std::size_t>(sweep.plan.size(), 100) && !common; ++i) {
    sweep.ensemble.common = values_of(sweep.plan, i);
    try {
      Setup setup = resolve(case_with(sweep, sweep.ensemble.common));
      const auto found = faults(setup);
      if (found.empty())
        common.emplace(std::move(setup));
      else if (why.empty())
        why = found.front().key + " " + found.front().problem;
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      if (why.empty()) why = error.what();
    }
  }
  if (!common) return {{"scene", "none of the first cases can be run: " + one_line(why)}};
  std::vector<QuantityColumn>& columns = sweep.plan.bars;
  for (const std::string& text : sweep.ensemble.outputs) {
    try {
      add_columns(columns, ensemble_output(text, common->run));
    } catch (const std::invalid_argument& error) {
      wrong.emplace_back("ensemble.outputs", error.what());
    }
  }
  columns.insert(columns.end(), {{"steps", "1", "steps of the run"},
                                 {"side_by_side", "1", "1 of a bar beside others, 0 of one alone"}});
  if (sweep.ensemble.error) columns.push_back({"estimate", "1", "error of the integration, as a share"});
  if (columns.size() > most_bar_columns)
    wrong.emplace_back("ensemble.outputs",
                       fmt::format("are {} numbers a case, more than {}", columns.size(), most_bar_columns));
  std::set<std::string> names;
  const auto twice =
      std::ranges::find_if(columns, [&](const auto& column) { return !names.insert(column.name).second; });
  if (twice != columns.end()) wrong.emplace_back("ensemble.outputs", fmt::format("have {} twice", twice->name));
  sweep.ensemble.batch =
      static_cast<std::size_t>(std::clamp(0.2 / estimated_seconds(*common), 1.0, double{most_bars_at_once}));
  return wrong;
}

std::vector<SweepRow> run_bars(const SweepFile& sweep, std::span<const SweepCase> cases,
                               const std::function<bool()>& interrupted) {
  const WallClock clock;
  const Stopwatch watch;
  EnsembleStudy study;
  std::vector<std::vector<double>> values(sweep.plan.keys.size());
  for (const SweepCase& one : cases) {
    const std::vector<double> own = values_of(sweep.plan, one.index);
    for (std::size_t k = 0; k < own.size(); ++k) values[k].push_back(own[k]);
  }
  for (std::size_t k = 0; k < values.size(); ++k) {
    study.keys.push_back(sweep.plan.keys[k].key);
    study.values.emplace_back(values[k]);
  }
  study.model = [&](std::span<const double> at) { return case_with(sweep, at); };
  study.outputs = sweep.ensemble.outputs;
  study.error = sweep.ensemble.error;
  study.common = sweep.ensemble.common;
  study.most_messages = cases.size();
  study.threads = 1;
  study.stop = interrupted;
  const EnsembleResult result = ensemble(study);
  const std::map<std::size_t, std::string> messages(result.messages.begin(), result.messages.end());
  const auto count = static_cast<double>(cases.size());
  std::vector<SweepRow> rows;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const BarStatus status = result.status[i];
    if (status == BarStatus::not_run) continue;
    SweepRow row;
    row.index = cases[i].index;
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
      row.error = fmt::format("the error that was asked for is not kept: {:.3g}", result.error[i]);
    row.seconds = clock.seconds() / count;
    row.integration_seconds = watch.seconds() / count;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace viscobar
