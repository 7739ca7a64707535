#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "report/precision/precision_tables.hpp"
#include "results/json.hpp"
#include "text/number.hpp"
#include "text/printable_text.hpp"
#include "viscobar/report/reports.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar {

namespace {

std::string norm(const PrecisionResult& result, const NumberText& number) {
  return fmt::format(
      "largest |u - u_ref| over {} times, {} apart, and the nodes of the mesh, in the unit of u, the start left out",
      result.times, number(result.every, Dimension::time));
}

Json to_json(const PrecisionResult& result, const ErrorParts& parts, const NumberText& number) {
  return {{"method", name(parts.method)},
          {"elements", parts.elements},
          {"mass", name(parts.mass)},
          {"epsilon", parts.epsilon},
          {"space", parts.space},
          {"penalty", parts.penalty},
          {"penalty_order", parts.penalty_order},
          {"penalty_against", text_or_null(parts.penalty_against)},
          {"time_reference", text_or_null(parts.time_reference)},
          {"time_reference_error", parts.time_reference.empty() ? Json(nullptr) : Json(parts.time_reference_error)},
          {"problem", text_or_null(parts.problem)},
          {"advice", advice(result, parts, number)}};
}

Json to_json(const PrecisionResult& result, const NumberText& number) {
  if (!result.reference) return {{"description", reference_sentence(result, number)}, {"error", nullptr}};
  const PrecisionReference& reference = *result.reference;
  Json json = {{"description", reference_sentence(result, number)},
               {"kind", reference.closed_form ? "closed form" : "finer run"},
               {"what", reference.what},
               {"error", reference.error},
               {"order", reference.order},
               {"largest_displacement", reference.largest_displacement},
               {"meshes", Json::array()}};
  for (const auto& level : reference.levels)
    json["meshes"].push_back({{"elements", level.elements}, {"difference_to_next", level.difference}});
  return json;
}

std::string numbers(const PrecisionStudy& study, const PrecisionResult& result, const NumberText& number) {
  Numbers all;
  std::map<Mass, std::set<std::string_view>> masses;  // as the methods have it
  for (const ErrorParts& parts : result.parts) masses[parts.mass].insert(name(parts.method));
  for (const auto& [mass, methods] : masses)
    all.add("Mass", std::string(name(mass)), masses.size() > 1 ? fmt::format("{}", fmt::join(methods, ", ")) : "");
  if (study.scene.epsilon) all.add("Penalty ε", number.epsilon(*study.scene.epsilon, 4));
  if (result.reference) {
    all.add("Largest |u|", number(result.reference->largest_displacement, Dimension::length));
    all.add("Reference", result.reference->closed_form ? "closed form" : "finer run",
            result.reference->closed_form ? sentence_html(result.reference->what)
                                          : fmt::format("{}; good to {}", sentence_html(result.reference->what),
                                                        number(result.reference->error, Dimension::length, 2)));
  }
  all.add("Errors taken at", fmt::format("{} times", result.times),
          number(result.every, Dimension::time, 4) + " apart");
  return all.html("The study");
}

/// Calls `tell` with the methods, "on so many elements" where there are several meshes, and the advice.
void for_each_advice(const PrecisionResult& result, const NumberText& number, auto&& tell) {
  const auto meshes = meshes_in(result);
  for (const std::size_t elements : meshes)
    for (const auto& [methods, text] : advice_on_mesh(result, elements, number))
      tell(methods + (meshes.size() > 1 ? fmt::format(" on {} elements", elements) : ""), text);
}

std::string json_text_of(const SceneFile& scene, const PrecisionStudy& study, const PrecisionResult& result) {
  const NumberText number = NumberText::terminal(study.scene.scene);
  Json json = Json::object();
  json["title"] = study.scene.scene.title;
  json["completed"] = std::ranges::all_of(result.rows, [](const PrecisionRow& row) { return row.failure.empty(); });
  json["norm"] = norm(result, number);
  json["reference"] = to_json(result, number);
  json["epsilon"] = study.scene.epsilon;
  json["rows"] = json_of(precision_columns(result), result.rows);
  json["parts"] = Json::array();
  for (const ErrorParts& parts : result.parts) json["parts"].push_back(to_json(result, parts, number));
  json["left_out"] = Json::array();
  for (const auto& [method, elements, what, reason] : result.left_out)
    json["left_out"].push_back(
        {{"method", name(method)}, {"elements", elements}, {"from", text_or_null(what)}, {"reason", reason}});
  json["remarks"] = remarks(study, result, number);
  json["errors_every"] = result.every;
  json["core_share"] = result.core_share;
  tell(json, scene);
  json["version"] = versions().viscobar;
  json["platform"] = versions().platform;
  return json_text(json);
}

std::string terminal_text(const PrecisionStudy& study, const PrecisionResult& result) {
  const NumberText number = NumberText::terminal(study.scene.scene);
  std::string out = text(precision_table(result, number)) + "\n";
  for_each_advice(result, number, [&](const std::string& methods, const std::string& advised) {
    out += fmt::format("{}: {}.\n", methods, advised);
  });
  out += fmt::format("\n{}\nThe error is measured, where `run` and `check` estimate it: the {}.\n",
                     reference_sentence(result, number), norm(result, number));
  out += fmt::format("\n{}", text(time_reference_table(result, number)));
  if (const auto lines = remarks(study, result, number); !lines.empty()) {
    out += "\n";
    for (const std::string& line : lines) out += line + ".\n";
  }
  return out + "\n";
}

PicturedPage page_of(const PrecisionStudy& study, const PrecisionResult& result) {
  const NumberText number = NumberText::page(study.scene.scene);
  Page page = Page::of_study(study.scene.scene, ": speed against error");
  std::string advised;
  for_each_advice(result, number, [&](const std::string& methods, const std::string& text) {
    advised += fmt::format("<b>{}</b>: {}.<br>\n", methods, sentence_html(text));
  });
  page.add_head(fmt::format("<p class=\"verdict\">{}</p>\n", advised));
  page.add(numbers(study, result, number));
  page.add(error_picture(result, number));
  page.add(time_error_picture(result, number));
  page.add(parts_picture(result, number));
  page.add_section("Every run", html(precision_table(result, number)));
  std::string references = fmt::format("<p>{}</p>\n", sentence_html(reference_sentence(result, number))) +
                           html(time_reference_table(result, number));
  if (result.reference && !result.reference->levels.empty())
    references += fmt::format("<h2>Refinement of the reference</h2>\n{}", html(mesh_table(*result.reference, number)));
  page.add_section("What the errors are against", references + notes_html(remarks(study, result, number)));
  return page.with_figures();
}

}  // namespace

StudyReport precision_report(const SceneFile& scene, const PrecisionStudy& study, const PrecisionResult& result) {
  return {json_text_of(scene, study, result), page_of(study, result), terminal_text(study, result),
          csv_of(precision_columns(result), result.rows)};
}

}  // namespace viscobar
