#include "io/summary.hpp"

#include <nlohmann/json.hpp>

#include "viscobar/io/versions.hpp"

namespace viscobar {

using Json = nlohmann::ordered_json;

ContactSummary::ContactSummary(const Scene& scene) {
  if (is_obstacle(scene.left)) left.emplace();
  if (is_obstacle(scene.right)) right.emplace();
  if (scene.span) span.emplace();
}

void ContactSummary::add(const Snapshot& snapshot) {
  if (left) left->add(snapshot.time, snapshot.reaction_left);
  if (right) right->add(snapshot.time, snapshot.reaction_right);
}

void ContactSummary::add(const Event& event) {
  switch (event.where) {
    case Where::left: left->add(event); break;
    case Where::right: right->add(event); break;
    case Where::span: ++(event.change == Change::closing ? span->closings : span->openings); break;
  }
}

void ContactSummary::know(const Statistics& done) {
  if (left && done.left) left->know(*done.left);
  if (right && done.right) right->know(*done.right);
}

namespace {

Json to_json(const ContactAccount& account, double reached) {
  return {{"closings", account.closings()},
          {"time_in_contact", account.duration(reached)},
          {"impulse", account.impulse()},
          {"max_reaction", account.max_reaction()}};
}

Json to_json(const EnergyAccount& energy) {
  return {{"initial", energy.initial},
          {"final", energy.final},
          {"dissipated", energy.dissipated},
          {"work", energy.work},
          {"balance_error", energy.balance_error()}};
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

std::string summary_json(const SceneFile& scene, const BarSystem& system, const Outcome& outcome,
                         const ContactSummary& contact, const FileChecksums& files) {
  const auto known = [&](auto member) {
    return outcome.statistics ? Json((*outcome.statistics).*member) : Json(nullptr);
  };
  Json json = Json::object();
  json["title"] = scene.run.scene.title;
  json["method"] = name(scene.run.method);
  json["completed"] = outcome.ending == Ending::completed;
  json["ending"] = name(outcome.ending);
  json["error"] = outcome.error.empty() ? Json(nullptr) : Json(outcome.error);
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
  Json& contacts = json["contact"] = Json::object();
  if (contact.left) contacts["left"] = to_json(*contact.left, outcome.reached_time);
  if (contact.right) contacts["right"] = to_json(*contact.right, outcome.reached_time);
  if (contact.span) contacts["span"] = {{"closings", contact.span->closings}, {"openings", contact.span->openings}};
  json["scene"] = Json::parse(scene.description);
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

}  // namespace viscobar
