#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "report/limit/limit_tables.hpp"
#include "results/json.hpp"
#include "studies/limit/mesh_runs.hpp"
#include "text/number.hpp"
#include "viscobar/report/reports.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar {

namespace {

constexpr std::size_t asked_steps = 3;  // of the scheme, down to the one asked for

Json order_or_null(const std::optional<SequenceOrder>& order) { return order ? Json(order->order) : Json(nullptr); }

Json to_json(const LimitEvidence& evidence) {
  return {{"difference", evidence.difference},
          {"penalty_error", evidence.penalty_error},
          {"scheme_error", evidence.scheme_error},
          {"extrapolated", evidence.extrapolated},
          {"apart", evidence.apart},
          {"apart_at_least", evidence.lower()},
          {"apart_at_most", evidence.upper()},
          {"stake", evidence.stake},
          {"until", evidence.until}};
}

Json to_json(const std::vector<SchemeRun>& runs) {
  Json json = Json::array();
  for (const SchemeRun& run : runs)
    json.push_back({{"step", run.step},
                    {"change", run.change},
                    {"distance", run.distance},
                    {"events", run.events},
                    {"seconds", run.seconds}});
  return json;
}

Json detailed(const std::optional<ObservedOrder>& order) {
  if (!order) return nullptr;
  return {{"order", order->order}, {"standard_error", order->standard_error}};
}

Json detailed(const std::optional<SequenceOrder>& order, const auto& at) {
  if (!order) return nullptr;
  return {{"order", order->order},
          {"standard_error", order->standard_error},
          {"bound", order->bound},
          {"from", at(order->first)},
          {"to", at(order->last)}};
}

Json to_json(const LimitStudy& study, const LimitResult& result, std::size_t mesh) {
  const LimitOrders& orders = result.orders[mesh];
  const auto rows = rows_of(result, mesh);
  const LimitTheory powers = theory(study);
  const NumberText number = NumberText::terminal(study.scene.scene);
  const auto epsilon = [&](std::size_t i) { return rows[i].epsilon; };
  Json json = {{"elements", orders.elements},
               {"verdict", name(orders.verdict)},
               {"reason", verdict_reason(study, result, mesh, number)},
               {"sentence", limit_sentence(orders, number)},
               {"boundary", orders.boundary},
               {"small_epsilon",
                {{"penetration", detailed(orders.penetration, epsilon)},
                 {"to_scheme", detailed(orders.to_scheme, epsilon)},
                 {"to_rigid", detailed(orders.to_scheme_limit, epsilon)},
                 {"to_own_limit", detailed(orders.to_own_limit, epsilon)},
                 {"to_scheme_limit", detailed(orders.to_scheme_limit, epsilon)},
                 {"theory_penetration", powers.penetration},
                 {"theory_difference", powers.difference}}},
               {"layer_resolved",
                {{"penetration", detailed(orders.penetration_layer, epsilon)},
                 {"to_rigid", detailed(orders.to_scheme_limit_layer, epsilon)},
                 {"theory", powers.layer}}},
               {"scheme_order", detailed(orders.of_step, [&](std::size_t i) { return orders.scheme[i].step; })},
               {"tolerance", orders.tolerance},
               {"interrupted", orders.interrupted},
               {"scheme_step", orders.scheme_step},
               {"scheme_error", orders.scheme_error},
               {"scheme_events", orders.scheme_events},
               {"tolerance_error", orders.tolerance_error},
               {"evidence", to_json(orders.evidence)},
               {"scheme_runs", to_json(orders.scheme)}};
  return json;
}

Json to_json(const CouplingResult& result) {
  if (!result.coupling) return nullptr;
  const Coupling& c = *result.coupling;
  return {{"limit", c.limit},
          {"mesh_order", c.mesh_order},
          {"order_in_h", detailed(c.law)},
          {"meshes", json_of(coupling_columns(), c.meshes)}};
}

Json to_json(const std::optional<OwnMotion>& of) {
  if (!of) return nullptr;
  const auto spacing = [&](std::size_t i) { return of->meshes[i].spacing; };
  return {{"reference", of->reference},
          {"reference_error", of->error},
          {"penalty", detailed(of->penalty, spacing)},
          {"scheme", detailed(of->scheme, spacing)},
          {"apart", detailed(of->apart, spacing)},
          {"meshes", json_of(own_motion_columns(), of->meshes)}};
}

std::string head(const LimitStudy& study, const LimitResult& result, const NumberText& number) {
  std::string out;
  for (std::size_t m = 0; m < result.orders.size(); ++m) {
    const LimitOrders& orders = result.orders[m];
    const std::string mesh = result.orders.size() > 1 ? fmt::format(" on {} elements", orders.elements) : "";
    out += fmt::format("<p class=\"verdict {0}\"><b>{0}{1}</b>: {2}.</p>\n", name(orders.verdict), mesh,
                       sentence_html(verdict_reason(study, result, m, number)));
  }
  return out;
}

/// Two numbers with the digits that tell them apart, or one where six do not.
std::string between_limits(double low, double high, const NumberText& number) {
  int digits = 2;
  while (digits < 6 && number(low, digits) == number(high, digits)) ++digits;
  const std::string most = number(high, Dimension::length, digits);
  return number(low, digits) == number(high, digits) ? most : number(low, digits) + " to " + most;
}

std::string numbers(const LimitStudy& study, const LimitResult& result, const NumberText& number) {
  const auto length = [&](double value) { return number(value, Dimension::length, 2); };
  const auto penalty = [&](double epsilon, int digits) { return number.epsilon(epsilon, digits); };
  Numbers all;
  const LimitOrders& orders = result.orders[finest(result)];
  all.add("Mass", std::string(name(resolve(study.scene).mass)));
  all.add("Restitution", study.scene.restitution ? readable(*study.scene.restitution) : "not given",
          study.scene.restitution ? "in penalty and scheme" : "undamped penalty, implicit constraint in the scheme");
  all.add("Penalty ε", number(study.epsilons.front(), 4) + " to " + penalty(study.epsilons.back(), 4),
          counted(study.epsilons.size(), "value"));
  if (!orders.scheme.empty())
    all.add("Scheme's time step", number(orders.scheme_step, Dimension::time, 4),
            fmt::format("error {}, by {} steps from {} down", length(orders.scheme_error), orders.scheme.size(),
                        number(orders.scheme.front().step, Dimension::time, 2)));
  all.add("Relative tolerance", readable(orders.tolerance), "of the penalised runs");
  if (const auto lower = orders.evidence.lower(), upper = orders.evidence.upper(); lower && upper)
    all.add("Distance of the limits", between_limits(*lower, *upper, number),
            "of the penalised bar and of the scheme, by their differences and errors");
  if (study.estimate)
    all.add("Error of the mesh", length(study.estimate->total),
            fmt::format("at ε = 0; the one asked for is {}kept", study.estimate->kept ? "" : "not "));
  all.add("Error of the tolerance", length(orders.tolerance_error), "at most, in a difference");
  if (orders.boundary)
    all.add("Regimes meet at", penalty(*orders.boundary, 3), "ε = " + std::string(theory(study).boundary));
  return all.html("The study");
}

std::string json_text_of(const SceneFile& scene, const LimitStudy& study, const LimitResult& result,
                         const CouplingResult& coupling) {
  const std::size_t best = finest(result);
  const LimitOrders& orders = result.orders[best];
  const NumberText number = NumberText::terminal(study.scene.scene);
  Json json = Json::object();
  json["title"] = study.scene.scene.title;
  json["completed"] = result.failed.empty() && std::ranges::none_of(result.orders, &LimitOrders::interrupted);
  json["verdict"] = name(orders.verdict);
  json["reason"] = verdict_reason(study, result, best, number);
  json["order_penetration"] = order_or_null(orders.penetration);
  json["order_to_rigid"] = order_or_null(orders.to_scheme_limit);
  json["order_to_scheme"] = order_or_null(orders.to_scheme);
  json["sentence"] = limit_sentence(orders, number);
  json["budget"] = study.budget;
  json["mass"] = name(resolve(study.scene).mass);
  json["restitution"] = study.scene.restitution;
  json["rows"] = json_of(limit_columns(), result.rows);
  json["failed"] = Json::array();
  for (const FailedRun& run : result.failed)
    json["failed"].push_back({{"epsilon", run.epsilon}, {"elements", run.elements}, {"error", run.what}});
  json["left_out"] = result.left_out;
  json["own_motion"] = to_json(result.own_motion);
  json["meshes"] = Json::array();
  for (std::size_t m = 0; m < result.orders.size(); ++m) json["meshes"].push_back(to_json(study, result, m));
  json["coupling"] = to_json(coupling);
  json["coupling_reason"] = coupling.coupling ? Json(nullptr) : Json(coupling.reason);
  if (study.estimate)
    json["error_estimate"] = {{"total", study.estimate->total},
                              {"space", study.estimate->space},
                              {"time", study.estimate->time},
                              {"requested", study.estimate->requested},
                              {"kept", study.estimate->kept}};
  // With this the same study can be run again.
  Json& asked =
      json["asked"] = {{"epsilon", study.epsilons}, {"elements", study.elements}, {"scheme_steps", Json::array()}};
  for (const LimitOrders& of_mesh : result.orders)
    if (of_mesh.scheme.size() >= asked_steps) asked["scheme_steps"].push_back(of_mesh.scheme[asked_steps - 1].step);
  if (asked["scheme_steps"].size() != result.orders.size()) asked["scheme_steps"] = Json::array();
  asked["relative_tolerance"] = study.scene.tolerance.relative;
  if (study.scene.tolerance.absolute) asked["absolute_tolerance"] = *study.scene.tolerance.absolute;
  asked["budget"] = study.budget;
  tell(json, scene);
  // Settings that ran, not those asked for: the scene of limit.json, as it stands, is that of the finest mesh.
  Json& ran = json["scene"];
  ran["mesh"]["elements"] = orders.elements;
  Case fine = limit::by_one_factor(study).scene;
  fine.elements = orders.elements;
  const Mesh mesh = fine.mesh();
  for (std::size_t m = 0; mesh.members && m < mesh.members->size(); ++m)
    if (const std::size_t own = (*mesh.members)[m].elements; own > 0) ran["bar"][m]["elements"] = own;
  ran["mesh"]["mass"] = name(resolve(study.scene).mass);
  ran["method"]["relative_tolerance"] = orders.tolerance;
  if (const auto absolute = study.scene.tolerance.with_relative(orders.tolerance).absolute)
    ran["method"]["absolute_tolerance"] = *absolute;
  if (orders.scheme_step > 0.0) ran["method"]["step"] = orders.scheme_step;
  if (json["chosen"].contains("mesh") && json["chosen"]["mesh"].contains("elements"))
    json["chosen"]["mesh"]["elements"] = orders.elements;
  json["version"] = versions().viscobar;
  return json_text(json);
}

std::string terminal_text(const LimitStudy& study, const LimitResult& result, const CouplingResult& coupling) {
  const NumberText number = NumberText::terminal(study.scene.scene);
  std::string out = text(limit_table(result, number));
  out += "\nObserved powers of epsilon\n" + text(order_table(study, result, number)) + "\n";
  for (std::size_t m = 0; m < result.orders.size(); ++m) {
    const LimitOrders& orders = result.orders[m];
    if (result.orders.size() > 1) out += fmt::format("{} elements, ", orders.elements);
    out += fmt::format("{}: {}.\n", name(orders.verdict), verdict_reason(study, result, m, number));
  }
  if (study.estimate)
    out += fmt::format("{} elements, at epsilon = 0: error of the mesh {}, the one asked for is {}kept.\n",
                       result.orders[finest(result)].elements, number(study.estimate->total, Dimension::length, 2),
                       study.estimate->kept ? "" : "not ");
  if (result.own_motion)
    out += fmt::format("\n{}\n{}", own_motion_sentence(*result.own_motion, number),
                       text(own_motion_table(*result.own_motion, number)));
  if (result.orders.size() > 1) {
    out += fmt::format("\n{}\n", coupling_sentence(coupling, number));
    if (coupling.coupling) out += text(coupling_table(*coupling.coupling, number));
  }
  return out;
}

PicturedPage page_of(const LimitStudy& study, const LimitResult& result, const CouplingResult& coupling) {
  Page page = Page::of_study(study.scene.scene, ": the penalty limit");
  const NumberText number = NumberText::page(study.scene.scene);
  page.add_head(head(study, result, number));
  page.add(numbers(study, result, number));
  if (!result.rows.empty()) {
    page.add(penetration_picture(study, result));
    page.add(difference_picture(study, result));
    page.add(events_picture(study, result));
    page.add(cost_picture(study, result));
  }
  page.add_section(
      "Observed powers of ε",
      html(order_table(study, result, number)) +
          "<p class=\"note\">Slopes over the settled range of the smallest ε, and how far they may be from "
          "the power for ε → 0.</p>\n");
  if (result.own_motion)
    page.add_section("The bar's own motion",
                     fmt::format("<p>{}</p>\n{}", sentence_html(own_motion_sentence(*result.own_motion, number)),
                                 html(own_motion_table(*result.own_motion, number))));
  if (result.orders.size() > 1)
    page.add_section("Penalty and mesh in balance",
                     fmt::format("<p>{}</p>\n{}", sentence_html(coupling_sentence(coupling, number)),
                                 coupling.coupling ? html(coupling_table(*coupling.coupling, number)) : ""));
  page.add_section("Every run", html(limit_table(result, number)));
  return page.with_figures();
}

}  // namespace

std::optional<LimitStudy> limit_asked(const std::string& json) try {
  const Json summary = Json::parse(json, nullptr, false);
  if (!summary.is_object() || !summary.contains("asked")) return std::nullopt;
  LimitStudy study;
  const Json& asked = summary["asked"];
  asked.at("epsilon").get_to(study.epsilons);
  asked.at("elements").get_to(study.elements);
  asked.at("scheme_steps").get_to(study.steps);
  asked.at("relative_tolerance").get_to(study.scene.tolerance.relative);
  if (asked.contains("absolute_tolerance")) study.scene.tolerance.absolute = asked["absolute_tolerance"].get<double>();
  asked.at("budget").get_to(study.budget);
  return study;
} catch (const Json::exception&) {
  throw std::invalid_argument("what it says under `asked` is not what `viscobar limit` writes there");
}

std::string limit_csv(const LimitResult& result) {
  return csv_of(
      pick(limit_columns(), {"elements", "epsilon", "mass", "events", "max_penetration", "difference_to_scheme",
                             "difference_to_own_limit", "difference_to_scheme_limit", "tolerance", "steps", "seconds"}),
      result.rows);
}

std::string limit_row_text(const LimitRow& row) {
  std::string text = fmt::format("epsilon = {:.3g} on {} elements: {} contact changes, penetration {:.3g}", row.epsilon,
                                 row.elements, row.events, row.max_penetration);
  if (row.difference_to_own_limit) text += fmt::format(", {:.3g} from its own limit", *row.difference_to_own_limit);
  return text;
}

StudyReport limit_report(const SceneFile& scene, const LimitStudy& study, const LimitResult& result,
                         const CouplingResult& coupling) {
  return {json_text_of(scene, study, result, coupling), page_of(study, result, coupling),
          terminal_text(study, result, coupling), limit_csv(result)};
}

}  // namespace viscobar
