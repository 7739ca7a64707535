#include "report/compare/finished_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "dynamics/gauge.hpp"
#include "dynamics/pieces.hpp"
#include "input/described_scene.hpp"
#include "input/input_text.hpp"
#include "report/measured.hpp"
#include "results/csv.hpp"
#include "results/field/field_reader.hpp"
#include "results/json.hpp"
#include "results/result_directory.hpp"
#include "results/result_info.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

std::vector<double> column(const TraceFile& table, std::string_view name) { return table.column(name)->values; }

Statistics statistics_of(const Json& summary) {
  Statistics statistics;
  const auto number = [](const Json& json, const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_number() ? found->get<double>() : 0.0;
  };
  statistics.unknowns = static_cast<std::size_t>(number(summary, "unknowns"));
  statistics.steps = static_cast<std::size_t>(number(summary, "steps"));
  statistics.integration_seconds = number(summary, "integration_seconds");
  statistics.max_penetration = number(summary, "max_penetration");
  if (const auto energy = summary.find("energy"); energy != summary.end() && energy->is_object()) {
    EnergyAccount& account = statistics.energy.emplace();
    account.initial = number(*energy, "initial"), account.final = number(*energy, "final");
    account.dissipated = number(*energy, "dissipated"), account.work = number(*energy, "work");
  }
  return statistics;
}

MethodRun read_run(const std::string& name, SceneFile& scene, Json& contact) {
  const fs::path place = name;
  settle_result_directory(place);
  if (!fs::exists(place / "summary.json"))
    throw std::invalid_argument(name + " holds no result of `viscobar run`: there is no summary.json");
  try {
    check_sound(place, "compared");
  } catch (const IoError& damage) {
    throw std::invalid_argument(damage.what());
  }
  const std::string summary = input_text(place / "summary.json");
  const Json told = Json::parse(summary);
  contact = told.value("contact", Json::object());
  scene = parse_scene(summary, (place / "summary.json").string());
  Recording recording;
  recording.label = name, recording.mesh = scene.run.mesh(), recording.statistics = statistics_of(told);
  const std::string ends = (place / "ends.csv").string(), events = (place / "events.csv").string();
  const bool field = fs::exists(place / "field.h5");
  if (field) {
    const FieldReader reader(place / "field.h5");
    if (reader.nodes() != recording.mesh.nodes())
      throw std::invalid_argument(
          fmt::format("{}: field.h5 has {} nodes, and its scene {}", name, reader.nodes(), recording.mesh.nodes()));
    recording.times = reader.times();
    for (const auto& [quantity, values] : {std::pair{FieldReader::Quantity::displacement, &recording.u},
                                           {FieldReader::Quantity::velocity, &recording.v}}) {
      values->resize(reader.rows() * reader.nodes());
      if (!values->empty()) reader.read(quantity, 0, *values);
    }
  }
  if (fs::exists(ends)) {
    const TraceFile table =
        read_traces(ends, {"t", "u_left", "v_left", "reaction_left", "u_right", "v_right", "reaction_right"},
                    {"t", "u_left", "v_left", "reaction_left", "u_right", "v_right", "reaction_right"});
    if (!field) {
      recording.mesh = {scene.run.scene.bar.length, 1};
      recording.times = column(table, "t");
      for (std::size_t k = 0; k < table.rows; ++k)
        for (const char* side : {"_left", "_right"}) {
          recording.u.push_back(column(table, std::string("u") + side)[k]);
          recording.v.push_back(column(table, std::string("v") + side)[k]);
        }
    }
    recording.reaction_left = column(table, "reaction_left"),
    recording.reaction_right = column(table, "reaction_right");
    recording.reaction_left.resize(recording.times.size()), recording.reaction_right.resize(recording.times.size());
  } else if (!field) {
    throw std::invalid_argument(name + " has neither field.h5 nor ends.csv: there is nothing to compare");
  }
  if (fs::exists(events)) {
    const TraceFile table =
        read_traces(events, {"t", "where", "change"}, {"t", "where", "change"}, {"where", "change"});
    recording.events = changes_in(table, events);
  }
  if (recording.times.size() < 2) throw std::invalid_argument(name + " has not two output times to compare");
  MethodRun run{name, false, resolve(scene.run), std::nullopt, {}, {}, 0};
  run.recording = std::move(recording);
  return run;
}

// Weights of the cubic through u and v at both ends of an interval of length h, at the share s of it: of u and of v at
// the first and the last; with a derivative those of its rate.
std::array<double, 4> cubic(double s, double h, bool rate) {
  if (rate) return {6 * s * (s - 1) / h, (1 - s) * (1 - 3 * s), 6 * s * (1 - s) / h, s * (3 * s - 2)};
  return {(1 + 2 * s) * (1 - s) * (1 - s), h * s * (1 - s) * (1 - s), s * s * (3 - 2 * s), h * s * s * (s - 1)};
}

void take_times(Recording& recording, const std::vector<double>& times) {
  const std::vector<double>& own = recording.times;
  const std::size_t nodes = recording.mesh.nodes();
  Recording taken = recording;
  taken.u.clear(), taken.v.clear(), taken.reaction_left.clear(), taken.reaction_right.clear();
  for (const double t : times) {
    const auto next = std::ranges::upper_bound(own, t);
    const std::size_t k = std::min<std::size_t>(next == own.begin() ? 0 : next - own.begin() - 1, own.size() - 2);
    const double h = own[k + 1] - own[k], s = (t - own[k]) / h;
    const auto of_u = cubic(s, h, false), of_v = cubic(s, h, true);
    for (std::size_t j = 0; j < nodes; ++j) {
      const std::size_t a = k * nodes + j, b = a + nodes;
      const double u0 = recording.u[a], v0 = recording.v[a], u1 = recording.u[b], v1 = recording.v[b];
      taken.u.push_back(of_u[0] * u0 + of_u[1] * v0 + of_u[2] * u1 + of_u[3] * v1);
      taken.v.push_back(of_v[0] * u0 + of_v[1] * v0 + of_v[2] * u1 + of_v[3] * v1);
    }
    for (auto field : {&Recording::reaction_left, &Recording::reaction_right})
      if (const std::vector<double>& force = recording.*field; !force.empty())
        (taken.*field).push_back(force[k] + s * (force[k + 1] - force[k]));
  }
  taken.times = times;
  std::erase_if(taken.events, [&](const Event& event) { return event.time > times.back(); });
  recording = std::move(taken);
}

// The member of a chain whose motion another run has at a place, by the places of its own members; where two meet, the
// one that the place begins or ends, unless both runs have as many.
const Piece& member_at(const std::vector<Piece>& own, double x, std::size_t member, std::size_t members, bool begins) {
  const double close = 1e-9 * (own.back().begin + own.back().mesh.length);
  const auto has = [&](const Piece& piece) {
    return piece.begin - close <= x && x <= piece.begin + (piece.rigid() ? 0.0 : piece.mesh.length) + close;
  };
  if (own.size() == members && has(own[member])) return own[member];
  if (begins) return *std::ranges::find_if(own.rbegin(), own.rend(), has);
  return *std::ranges::find_if(own, has);
}

// A polynomial in x goes through nodes of one member of a chain.
void take_nodes(Recording& recording, const Scene& scene, const Mesh& mesh, const Scene& scene_of_mesh) {
  std::vector<double> u, v;
  const std::vector<Piece> from = pieces_of(scene, recording.mesh), to = pieces_of(scene_of_mesh, mesh);
  std::vector<Interpolant> at;
  for (std::size_t m = 0; m < to.size(); ++m)
    for (std::size_t j = std::max(to[m].first, at.size()); j <= to[m].last(); ++j) {
      const Piece& member = member_at(from, mesh.node(j), m, to.size(), j == to[m].first);
      at.push_back(interpolant_of(member, mesh.node(j) - member.begin));
    }
  for (std::size_t k = 0; k < recording.times.size(); ++k)
    for (const Interpolant& place : at) {
      u.push_back(place.value(recording.displacement(k)));
      v.push_back(place.value(recording.velocity(k)));
    }
  recording.mesh = mesh, recording.u = std::move(u), recording.v = std::move(v);
}

// The account of a place is that of its only contact, where that is over by then. Of several at an end an integral over
// the output times is all there is.
void take_impulses(Recording& recording, const std::vector<ContactPeriod>& periods, const Json& contact, double until) {
  for (const ContactPeriod& period : periods) {
    const auto alike = [&](const auto& other) { return other.where == period.where && other.node == period.node; };
    const auto of_place = contact.find(place(Event{period.begin, period.where, period.node}));
    if (of_place == contact.end() || std::ranges::count_if(periods, alike) != 1 || period.end > until) continue;
    const double impulse = of_place->value("impulse", 0.0);
    Event& first = *std::ranges::find_if(recording.events, alike);
    first.impulse = 0.0;
    Event* last = nullptr;
    for (Event& event : recording.events)
      if (alike(event)) last = &event;
    if (last->change == Change::opening) last->impulse = impulse;
    if (!recording.statistics.account) recording.statistics.account.emplace();
    recording.statistics.account->of(first).impulse = impulse;
  }
}

}  // namespace

FinishedRuns finished_runs(std::span<const std::string> directories) {
  FinishedRuns finished;
  std::vector<SceneFile> scenes(directories.size());
  std::vector<Json> contacts(directories.size());
  double end = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < directories.size(); ++k) {
    if (std::ranges::count(directories, directories[k]) > 1)
      throw std::invalid_argument(directories[k] + " is asked for twice");
    finished.runs.push_back(read_run(directories[k], scenes[k], contacts[k]));
    if (scenes[k].run.scene.bar.length != scenes[0].run.scene.bar.length)
      throw std::invalid_argument(fmt::format("{} is of a bar of length {}, and {} of one of {}", directories[k],
                                              scenes[k].run.scene.bar.length, directories[0],
                                              scenes[0].run.scene.bar.length));
    end = std::min(end, finished.runs.back().recording->times.back());
  }
  Recording& first = *finished.runs.front().recording;
  std::vector<double> times = first.times;
  std::erase_if(times, [&](double t) { return t > end; });
  if (times.size() < 2)
    throw std::invalid_argument(
        fmt::format("{} has not two output times up to t = {}, where another "
                    "run ends",
                    directories[0], end));
  for (std::size_t k = 0; k < finished.runs.size(); ++k) {
    Recording& recording = *finished.runs[k].recording;
    const bool ends_only = recording.mesh.elements == 1 || first.mesh.elements == 1;
    const bool whole = recording.times.back() == times.back();
    const double merge = 0.01 * (times.back() - times.front());
    take_impulses(recording, contact_periods(recording, merge), contacts[k], times.back());
    if (recording.times != times) {
      if (k > 0 || times.back() != recording.times.back())
        finished.remarks.push_back(
            k == 0 ? fmt::format("{} goes on beyond the end of another run", directories[k])
                   : fmt::format("{} has other output times than {}: it is taken at those, by cubics in time",
                                 directories[k], directories[0]));
      take_times(recording, times);
    }
    if (!ends_only && !same_nodes(recording.mesh, first.mesh)) {
      finished.remarks.push_back(fmt::format("{} has {} elements and {} has {}: it is taken at the nodes of the latter",
                                             directories[k], recording.mesh.elements_of_bars(), directories[0],
                                             first.mesh.elements_of_bars()));
      take_nodes(recording, scenes[k].run.scene, first.mesh, scenes[0].run.scene);
    }
    if (const std::string tables = k > 0 ? differing_tables(complete(scenes[0]), complete(scenes[k])) : "";
        !tables.empty())
      finished.remarks.push_back(
          fmt::format("The scenes of {} and {} differ in {}", directories[0], directories[k], tables));
    if (!whole) recording.statistics.energy.reset();  // that of its end
  }
  finished.scene = std::move(scenes.front());
  return finished;
}

}  // namespace viscobar
