#include "results/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "input/described_scene.hpp"
#include "results/csv.hpp"
#include "results/json.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar {

namespace {

Json contact_json(const Scene& scene, const Outcome& outcome) {
  const auto account = outcome.statistics ? outcome.statistics->account : std::nullopt;
  Json contacts = Json::object();
  for (const ContactPlace& place : contact_places(scene)) {
    Json& json = contacts[name(place)];
    if (!account) continue;
    // An object from here on: [] would make null one before it has the memory for it, and the library fall over that.
    json = Json::object();
    const ContactAccount of = place.account(*account);
    json["closings"] = of.closings;
    if (place.where == Where::span) json["openings"] = account->span.openings;
    json["time_in_contact"] = of.contact.total(outcome.reached_time);
    json["impulse"] = of.impulse;
    json["max_reaction"] = of.peak_reaction;
  }
  return contacts;
}

// NaN becomes null.
Json sensitivity_json(const Case& run, const Outcome& outcome) {
  const SensitivityAccount* account =
      outcome.statistics && outcome.statistics->sensitivity ? &*outcome.statistics->sensitivity : nullptr;
  Json json = Json::object();
  for (std::size_t k = 0; k < run.directions.size(); ++k) {
    Json times = Json::array(), velocities = Json::array();
    for (const auto& change : outcome.changes)
      times.push_back(change[k].time), velocities.push_back(change[k].velocity);
    const auto known = [&](const std::vector<double> SensitivityAccount::*member) {
      return account && k < (account->*member).size() ? Json((account->*member)[k]) : Json(nullptr);
    };
    json[run.directions[k].key] = {{"contact_times", times},
                                   {"contact_velocities", velocities},
                                   {"impulse_left", known(&SensitivityAccount::impulse_left)},
                                   {"impulse_right", known(&SensitivityAccount::impulse_right)},
                                   {"energy_final", known(&SensitivityAccount::energy)},
                                   {"until", account ? Json(account->lost) : Json(nullptr)}};
  }
  return json;
}

std::string_view name(Ending ending) {
  switch (ending) {
    case Ending::completed: return "completed";
    case Ending::failed: return "failed";
    case Ending::refused: return "refused";
    case Ending::interrupted: return "interrupted";
  }
  return {};
}

}  // namespace

Json to_json(const ErrorEstimate& estimate) {
  Json json = {{"of", name(estimate.of)},
               {"total", estimate.total},
               {"space", estimate.space},
               {"penalty", estimate.penalty},
               {"time", estimate.time},
               {"requested", estimate.requested},
               {"kept", estimate.requested ? Json(estimate.kept) : Json(nullptr)},
               {"largest", estimate.largest},
               {"order", estimate.order},
               {"effectivity", estimate.effectivity},
               {"doubt", text_or_null(estimate.doubt)},
               {"reasons", estimate.reasons},
               {"seconds", estimate.seconds},
               {"runs", Json::array()}};
  for (const ErrorEstimate::Run& run : estimate.runs)
    json["runs"].push_back({{"elements", run.elements},
                            {"setting", run.setting},
                            {"epsilon", run.epsilon},
                            {"changes", run.changes},
                            {"seconds", run.seconds},
                            {"search", run.search}});
  return json;
}

Json to_json(const EnergyAccount& energy) {
  Json json = {{"initial", energy.initial},
               {"final", energy.final},
               {"dissipated", energy.dissipated},
               {"work", energy.work},
               {"balance_error", energy.balance_error()}};
  if (energy.end_inertia != 0.0) json["end_inertia"] = energy.end_inertia;
  return json;
}

Json to_json(const Allowance& absolute) {
  return {{"displacement", absolute.displacement}, {"velocity", absolute.velocity}};
}

void tell(Json& json, const SceneFile& scene) {
  json["scene"] = complete(scene);
  put(json["chosen"] = Json::object(), scene.chosen);
}

std::string summary_json(const SceneFile& scene, const BarSystem& system, const Outcome& outcome,
                         const FileChecksums& files) {
  const auto known = [&](auto member) {
    return outcome.statistics ? Json((*outcome.statistics).*member) : Json(nullptr);
  };
  Json json = Json::object();
  json["title"] = scene.run.scene.title;
  json["method"] = name(scene.run.method);
  json["method_requested"] = scene.run.automatic ? automatic : name(scene.run.method);
  json["completed"] = outcome.ending == Ending::completed;
  json["ending"] = name(outcome.ending);
  json["error"] = text_or_null(outcome.error);
  json["warnings"] = outcome.warnings;
  json["reached_time"] = outcome.reached_time;
  json["wall_seconds"] = outcome.wall_seconds;
  json["integration_seconds"] = known(&Statistics::integration_seconds);
  json["unknowns"] = known(&Statistics::unknowns);
  json["steps"] = outcome.steps;
  json["rhs_evaluations"] = known(&Statistics::rhs_evaluations);
  json["linear_solves"] = known(&Statistics::linear_solves);
  json["matrix_factorisations"] = known(&Statistics::matrix_factorisations);
  json["event_evaluations"] = known(&Statistics::event_evaluations);
  json["load_evaluations"] = known(&Statistics::load_evaluations);
  json["events"] = outcome.events;
  json["checkpoints"] = outcome.checkpoints;
  json["max_penetration"] = known(&Statistics::max_penetration);
  json["energy"] =
      outcome.statistics && outcome.statistics->energy ? to_json(*outcome.statistics->energy) : Json(nullptr);
  if (outcome.statistics && outcome.statistics->representation)
    json["representation"] = {{"error", outcome.statistics->representation->error},
                              {"rounding", outcome.statistics->representation->rounding}};
  json["error_estimate"] = outcome.error_estimate ? to_json(*outcome.error_estimate) : Json(nullptr);
  if (!outcome.no_estimate.empty()) json["no_estimate"] = outcome.no_estimate;
  if (!scene.run.directions.empty()) json["sensitivity"] = sensitivity_json(scene.run, outcome);
  json["contact"] = contact_json(scene.run.scene, outcome);
  tell(json, scene);
  if (is_adaptive(scene.run.method))
    json["absolute_tolerance"] = to_json(allowance(scene.run.tolerance, system, scene.run.end));
  json["mass"] = name(system.mass());
  const Versions used = versions();
  json["versions"] = {{"viscobar", used.viscobar},
                      {"build", used.build},
                      {"sundials", used.sundials},
                      {"hdf5", used.hdf5},
                      {"eigen", used.eigen}};
  json["platform"] = used.platform;
  return sealed_summary(std::move(json), files);
}

std::string sealed_summary(Json summary, const FileChecksums& files) {
  Json& list = summary["files"] = Json::object();
  for (const auto& [name, sum] : files) list[name] = {{"bytes", sum.bytes}, {"crc64", sum.digits()}};
  summary["crc64"] = Checksum{}.digits();
  return with_seal(json_text(summary));
}

std::string sealed_summary(const std::string& summary, const FileChecksums& files) {
  return sealed_summary(Json::parse(summary), files);
}

}  // namespace viscobar
