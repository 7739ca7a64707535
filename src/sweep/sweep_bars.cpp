#include "sweep/sweep_bars.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <set>
#include <stdexcept>

#include "case/run_cost.hpp"
#include "input/described_scene.hpp"
#include "input/toml_text.hpp"
#include "text/printable_text.hpp"
#include "viscobar/studies/ensemble/ensemble.hpp"

namespace viscobar {

namespace {

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

Case case_of_bar(const SweepFile& sweep, std::span<const double> values) {
  std::vector<Setting> settings = sweep.settings;
  for (std::size_t k = 0; k < values.size(); ++k)
    settings.emplace_back(std::pair(sweep.plan.keys[k].key, SceneValue(values[k])));
  return parse_scene_with(sweep.scene_text, "scene", settings, {}, Telling::nothing).run;
}

std::vector<double> values_of_bar(const SweepPlan& plan, std::size_t index) {
  const std::vector<std::size_t> chosen = plan.choice(index);
  std::vector<double> values;
  for (std::size_t k = 0; k < chosen.size(); ++k)
    values.push_back(std::get<std::vector<double>>(plan.keys[k].values)[chosen[k]]);
  return values;
}

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
    sweep.ensemble.common = values_of_bar(sweep.plan, i);
    try {
      Setup setup = resolve(case_of_bar(sweep, sweep.ensemble.common));
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
      const std::string_view what = error.what(), key = "outputs: ";
      wrong.emplace_back("ensemble.outputs", what.substr(what.starts_with(key) ? key.size() : 0));
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

}  // namespace viscobar
