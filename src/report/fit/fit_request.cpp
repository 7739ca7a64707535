#include "report/fit/fit_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "case/method_table.hpp"
#include "case/scene_numbers.hpp"
#include "input/described_scene.hpp"
#include "input/scene_entries.hpp"
#include "input/scene_keys.hpp"
#include "report/measured.hpp"
#include "studies/column_reader.hpp"
#include "text/number.hpp"

namespace viscobar {

namespace {

double number(std::string_view text, const std::string& option) {
  const auto value = number_in<double>(text);
  if (!value || !std::isfinite(*value))
    throw std::invalid_argument(fmt::format("{}: \"{}\" is no number", option, text));
  return *value;
}

/// "name=value", of one of the names.
std::pair<std::string, std::string> assignment(const std::string& text, const std::string& option,
                                               const std::vector<std::string>& names) {
  const std::size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  if (equals == text.npos)
    throw std::invalid_argument(fmt::format("{}: \"{}\" does not have the form NAME=VALUE", option, text));
  if (std::ranges::find(names, name) == names.end())
    throw std::invalid_argument(fmt::format("{}: \"{}\" is none of {}", option, name, fmt::join(names, ", ")));
  return {name, text.substr(equals + 1)};
}

/// Where the scene puts a parameter, and how far it may go.
FittedParameter parameter_of(const SceneFile& scene, const std::string& key) {
  const SceneValue* value = value_of(scene.chosen, key);
  if (!value) value = value_of(scene.values, key);
  std::vector<Member> chain = scene.run.scene.chain;
  SceneValue own;  // of one of several bars, which does not say what it has anyway
  if (const double* number = value ? nullptr : number_of(chain, key)) value = &(own = *number);
  if (!find_scene_key(key)) {
    const std::string_view table = table_of(key);
    throw std::invalid_argument(
        fmt::format("--parameters: {}: {}", key,
                    unknown_key(table, std::string_view(key).substr(table.empty() ? 0 : table.size() + 1))));
  }
  if (!value || !(std::holds_alternative<double>(*value) || std::holds_alternative<std::int64_t>(*value)))
    throw std::invalid_argument(fmt::format("--parameters: the scene gives no number for {}, to begin with", key));
  FittedParameter parameter;
  parameter.key = key;
  parameter.start = std::holds_alternative<double>(*value) ? std::get<double>(*value)
                                                           : static_cast<double>(std::get<std::int64_t>(*value));
  if (const SceneKey* known = find_scene_key(key); known && !is_parameter(key))
    parameter.low = known->range.low, parameter.high = known->range.high;
  return parameter;
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values)
    if (std::isfinite(value)) most = std::max(most, std::abs(value));
  return most;
}

void add_warnings(FitStudy& study, const TraceFile& table) {
  study.warnings.insert(study.warnings.end(), table.warnings.begin(), table.warnings.end());
}

// Numbers of a column, in those of the scene: by its name, "events" for contact times.
using Factors = std::map<std::string, double>;

void read_data(FitStudy& study, const SceneFile& scene, const std::string& file, Factors& factors) {
  const TraceFile table = read_measured(scene, file, names_of_traces(), {"t"});
  add_warnings(study, table);
  study.times = table.column("t")->values;
  for (const TraceFile::Column& found : table.columns) {
    if (found.name == "t") continue;
    const auto column = trace_column(found.name);
    if (const auto why = place_refusal(column, scene.run.scene))
      throw std::invalid_argument(fmt::format("{}: {} {}", file, found.name, *why));
    if (std::ranges::none_of(found.values, [](double value) { return std::isfinite(value); }))
      throw std::invalid_argument(fmt::format("{}: {} has no value: leave the column out", file, found.name));
    study.traces.push_back({column->first, found.values, 1.0, false, column->second});
    factors[name(column->first, column->second)] = found.factor;
  }
  std::ranges::stable_sort(study.traces, {}, &MeasuredTrace::column);
  study.understood.push_back(table.understood);
}

void read_changes(FitStudy& study, const SceneFile& scene, const std::string& file, Factors& factors) {
  const TraceFile table =
      read_measured(scene, file, {"t", "where", "change", "velocity"}, {"t", "where", "change"}, {"where", "change"});
  if (table.rows == 0) throw std::invalid_argument(file + ": holds no data");
  add_warnings(study, table);
  study.changes = changes_in(table, file);
  factors["events"] = table.column("t")->factor;
  study.understood.push_back(table.understood);
}

// The damping of a stop is a function of it.
bool gives_damping(const Scene& scene, const std::string& key) {
  const auto is_of = [&](const EndInput& input, const char* end) {
    return input.stop && (key == input.stop->key(end, "restitution") || key == input.stop->key(end, "speed"));
  };
  return is_of(scene.left_input, "left") || is_of(scene.right_input, "right");
}

}  // namespace

PreparedFit prepared_fit(const FitRequest& request,
                         const std::function<SceneFile(const std::vector<Setting>& settings)>& read) {
  if (request.data.empty() && request.events.empty())
    throw std::invalid_argument("fit: there are no data; give --data FILE, --events FILE, or both");
  PreparedFit prepared{read({}), {}};
  const SceneFile& scene = prepared.scene;
  FitStudy& study = prepared.study;
  Factors factors;
  if (!request.data.empty()) read_data(study, scene, request.data, factors);
  if (!request.events.empty()) read_changes(study, scene, request.events, factors);
  // Derivatives by the length are those of what moves with the nodes, and a gauge stays at its x.
  const auto is_length = [](const std::string& key) { return key.starts_with("bar.") && key.ends_with(".length"); };
  study.differences = !method_row(scene.run.method).differentiates ||
                      (std::ranges::any_of(request.parameters, is_length) &&
                       std::ranges::any_of(study.traces, is_of_gauge, &MeasuredTrace::column));
  study.starts = request.starts;
  study.most_runs = request.most_runs;
  for (const std::string& key : request.parameters)
    if (std::ranges::count(request.parameters, key) > 1)
      throw std::invalid_argument(fmt::format("--parameters: {} is named twice", key));
  for (const std::string& key : request.parameters) {
    study.parameters.push_back(parameter_of(scene, key));
    const bool by_differences = member_key("bar", key) && key.ends_with(".length");  // beside a load
    const bool of_section = key.ends_with(".section");  // its entry alone says that it is a number
    if (!is_parameter(key) && !gives_damping(scene.run.scene, key) && !by_differences && !of_section)
      direction(scene.run, key);  // refuses keys that are none to vary
  }
  // A method or a scene that has no derivatives, as by a parameter of its section, is kept, and its runs are
  // differenced.
  std::vector<Setting> kept;
  if (!study.differences) {
    const Setting derivatives = std::pair("sensitivity.of", request.parameters);
    try {
      read({derivatives});
      kept.push_back(derivatives);
    } catch (const SceneError&) {
      study.differences = true;
    }
  }
  for (const std::string& text : request.bounds) {
    const auto [key, range] = assignment(text, "--bounds", request.parameters);
    const std::size_t colon = range.find(':');
    if (colon == range.npos) throw std::invalid_argument(fmt::format("--bounds: {} is no LOW:HIGH", range));
    auto& parameter = *std::ranges::find(study.parameters, key, &FittedParameter::key);
    parameter.low = number(std::string_view(range).substr(0, colon), "--bounds");
    parameter.high = number(std::string_view(range).substr(colon + 1), "--bounds");
    if (!(parameter.low < parameter.high)) throw std::invalid_argument(fmt::format("--bounds: {} is empty", text));
    parameter.start = std::clamp(parameter.start, parameter.low, parameter.high);
  }
  for (MeasuredTrace& trace : study.traces) {
    const double most = largest(trace.values);
    trace.deviation = most > 0.0 ? 0.01 * most : 1.0;
    trace.assumed = true;
  }
  if (!study.changes.empty()) study.change_deviation = 0.01 * study.changes.back().time;
  std::vector<std::string> columns;
  for (const auto& [column, factor] : factors) columns.push_back(column);
  for (const std::string& text : request.deviations) {
    const auto [column, value] = assignment(text, "--deviation", columns);
    const double deviation = number(value, "--deviation") * factors.at(column);
    if (!(deviation > 0.0)) throw std::invalid_argument(fmt::format("--deviation: {} is not positive", text));
    if (column == "events") study.change_deviation = deviation;
    for (MeasuredTrace& trace : study.traces)
      if (column == name(trace.column, trace.place)) trace.deviation = deviation, trace.assumed = false;
  }
  // Choices made for the scene stay while its values move.
  if (const SceneValue* epsilon = value_of(scene.chosen, "contact.epsilon"))
    kept.emplace_back(std::pair("contact.epsilon", *epsilon));
  kept.emplace_back(std::pair("method.name", std::string(name(scene.run.method))));
  study.model = [read, kept, keys = request.parameters, elements = scene.run.elements,
                 of_bars = scene.run.bar_meshes](std::span<const double> values) {
    std::vector<Setting> settings = kept;
    for (std::size_t k = 0; k < values.size(); ++k) settings.emplace_back(std::pair(keys[k], values[k]));
    Case run = read(settings).run;
    run.elements = elements, run.bar_meshes = of_bars;
    return run;
  };
  return prepared;
}

}  // namespace viscobar
