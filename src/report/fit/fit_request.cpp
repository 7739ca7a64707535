#include "report/fit/fit_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "input/scene_keys.hpp"
#include "input/trace_file.hpp"

namespace viscobar {

namespace {

double number(std::string_view text, const std::string& option) {
  double value = 0.0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || rest != text.data() + text.size() || !std::isfinite(value))
    throw std::invalid_argument(fmt::format("{}: \"{}\" is no number", option, text));
  return value;
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

std::string list_of(const std::vector<std::string>& keys) {
  std::string list;
  for (const std::string& key : keys) list += fmt::format("{}'{}'", list.empty() ? "" : ", ", key);
  return fmt::format("sensitivity.of=[{}]", list);
}

/// Where the scene puts a parameter, and how far it may go.
FittedParameter parameter_of(const SceneFile& scene, const std::string& key) {
  const auto all = nlohmann::ordered_json::parse(scene.complete());
  const std::size_t dot = key.find('.');
  const std::string table = key.substr(0, dot), leaf = key.substr(dot + 1);
  if (!all.contains(table) || !all[table].contains(leaf) || !all[table][leaf].is_number())
    throw std::invalid_argument(fmt::format("--parameters: the scene gives no number for {}, to begin with", key));
  FittedParameter parameter;
  parameter.key = key;
  parameter.start = all[table][leaf].get<double>();
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

void read_data(FitStudy& study, const std::string& file) {
  std::vector<std::string> known = {"t"};
  for (const TraceColumn column : all_trace_columns) known.emplace_back(name(column));
  const TraceFile table = read_traces(file, known, {"t"});
  study.times = table.column("t")->values;
  for (std::size_t k = 1; k < study.times.size(); ++k)
    if (!(study.times[k] > study.times[k - 1]))
      throw std::invalid_argument(fmt::format("{}: t = {} is there twice", file, study.times[k]));
  for (const TraceColumn column : all_trace_columns)
    if (const auto* found = table.column(name(column))) study.traces.push_back({column, found->values, 1.0});
  if (study.traces.empty())
    throw std::invalid_argument(fmt::format("{}: has no column of values beside t; known are {}", file,
                                            fmt::join(known.begin() + 1, known.end(), ", ")));
}

Event change_of(const std::string& file, std::size_t row, double t, const std::string& where,
                const std::string& change) {
  Event event;
  event.time = t;
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(fmt::format("{}:{}: {}", file, row + 2, what));
  };
  if (where == "left" || where == "right") {
    event.where = where == "left" ? Where::left : Where::right;
  } else if (where.starts_with("span:")) {
    event.where = Where::span;
    event.node = static_cast<std::size_t>(number(std::string_view(where).substr(5), file));
  } else {
    refuse(fmt::format("where is \"{}\", not left, right or span:NODE", where));
  }
  if (change != "closing" && change != "opening")
    refuse(fmt::format("change is \"{}\", not closing or opening", change));
  event.change = change == "closing" ? Change::closing : Change::opening;
  return event;
}

void read_changes(FitStudy& study, const std::string& file) {
  const TraceFile table =
      read_traces(file, {"t", "where", "change", "velocity"}, {"t", "where", "change"}, {"where", "change"});
  for (std::size_t k = 0; k < table.rows; ++k)
    study.changes.push_back(change_of(file, k, table.column("t")->values[k], table.column("where")->cells[k],
                                      table.column("change")->cells[k]));
}

}  // namespace

PreparedFit prepared_fit(const FitRequest& request,
                         const std::function<SceneFile(const std::vector<std::string>& settings)>& read) {
  if (request.data.empty() && request.events.empty())
    throw std::invalid_argument("fit: there are no data; give --data FILE, --events FILE, or both");
  const std::string of = list_of(request.parameters);
  PreparedFit prepared{read({of}), {}};
  const SceneFile& scene = prepared.scene;
  FitStudy& study = prepared.study;
  study.starts = request.starts;
  study.most_runs = request.most_runs;
  if (!request.data.empty()) read_data(study, request.data);
  if (!request.events.empty()) read_changes(study, request.events);
  for (const std::string& key : request.parameters) study.parameters.push_back(parameter_of(scene, key));
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
  std::vector<std::string> columns;
  for (MeasuredTrace& trace : study.traces) {
    columns.emplace_back(name(trace.column));
    const double most = largest(trace.values);
    trace.deviation = most > 0.0 ? 0.01 * most : 1.0;
  }
  if (!study.changes.empty()) {
    columns.emplace_back("events");
    study.change_deviation = 0.01 * study.changes.back().time;
  }
  for (const std::string& text : request.deviations) {
    const auto [column, value] = assignment(text, "--deviation", columns);
    const double deviation = number(value, "--deviation");
    if (!(deviation > 0.0)) throw std::invalid_argument(fmt::format("--deviation: {} is not positive", text));
    if (column == "events") study.change_deviation = deviation;
    for (MeasuredTrace& trace : study.traces)
      if (column == name(trace.column)) trace.deviation = deviation;
  }
  // What is chosen for the scene stays while its values move.
  std::vector<std::string> kept;
  const auto chosen = nlohmann::ordered_json::parse(scene.chosen);
  if (chosen.contains("contact"))
    kept.push_back(fmt::format("contact.epsilon={}", chosen["contact"]["epsilon"].dump()));
  kept.push_back(fmt::format("method.name={}", name(scene.run.method)));
  study.model = [read, kept, of, keys = request.parameters](std::span<const double> values) {
    std::vector<std::string> settings = kept;
    for (std::size_t k = 0; k < values.size(); ++k) settings.push_back(fmt::format("{}={}", keys[k], values[k]));
    settings.push_back(of);
    return read(settings).run;
  };
  return prepared;
}

}  // namespace viscobar
