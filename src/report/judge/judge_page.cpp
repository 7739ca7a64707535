#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "input/described_scene.hpp"
#include "report/judge/judge_request.hpp"
#include "report/page.hpp"
#include "results/csv.hpp"
#include "results/json.hpp"
#include "text/number.hpp"
#include "text/table.hpp"
#include "viscobar/report/reports.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar {

namespace {

constexpr std::size_t most_contacts = 30;

// Files by their names, without the folders that all of them are in.
JudgeStudy with_short_labels(JudgeStudy study) {
  const std::string first = study.solutions.front().label;
  std::size_t shared = first.rfind('/') + 1;
  for (const TheirSolution& theirs : study.solutions)
    while (theirs.label.compare(0, shared, first, 0, shared) != 0)
      shared = shared < 2 ? 0 : first.rfind('/', shared - 2) + 1;
  for (TheirSolution& theirs : study.solutions) theirs.label.erase(0, shared);
  return study;
}

Table distances(const JudgeStudy& study, const JudgeResult& judgement, NumberText number) {
  Table table{{"solution", "quantity", "largest difference", "at t", "root mean square", "of the largest value",
               "our own error", "order"},
              2,
              {}};
  for (std::size_t s = 0; s < judgement.solutions.size(); ++s)
    for (const JudgedColumn& column : judgement.solutions[s].columns)
      table.rows.push_back(
          {study.solutions[s].label, column.name,
           column.told_apart() ? number(column.largest) : "at most " + number(column.largest + *column.own_error),
           number(column.at, 5), number(column.root_mean_square),
           column.size > 10.0 * column.own_error.value_or(0.0) ? number(column.largest / column.size) : "",
           column.own_error ? number(*column.own_error) : "not known",
           column.order ? fmt::format("{:.2f}", *column.order) : ""});
  return table;
}

std::string interval(const std::optional<double>& begin, const std::optional<double>& end, NumberText number) {
  return begin && end ? fmt::format("{} to {}", number(*begin, 6), number(*end, 6)) : "none";
}

Table contacts(const JudgeStudy& study, const JudgeResult& judgement, NumberText number) {
  Table table{{"solution", "where", "the bar's contact", "theirs, to a sample", ""}, 5, {}};
  for (std::size_t s = 0; s < judgement.solutions.size(); ++s)
    for (const JudgedContact& contact : judgement.solutions[s].contacts)
      table.rows.push_back({study.solutions[s].label, std::string(name(contact.where)),
                            interval(contact.begin, contact.end, number),
                            interval(contact.their_begin, contact.their_end, number),
                            !contact.begin         ? "made up"
                            : !contact.their_begin ? "missed"
                                                   : ""});
  if (table.rows.size() > most_contacts) {
    std::ranges::stable_partition(table.rows, [](const auto& row) { return !row.back().empty(); });
    const std::size_t left_out = table.rows.size() - most_contacts;
    table.rows.resize(most_contacts);
    table.rows.push_back({fmt::format("and {} more", left_out), "", "", "", ""});
  }
  return table;
}

std::vector<std::string> sentences(const JudgeStudy& study, const JudgeResult& judgement, NumberText number) {
  std::vector<std::string> all;
  for (std::size_t s = 0; s < judgement.solutions.size(); ++s) {
    const JudgedSolution& judged = judgement.solutions[s];
    const std::string& label = study.solutions[s].label;
    const auto of = [](std::size_t count) { return fmt::format("{} contact{}", count, count == 1 ? "" : "s"); };
    if (judged.missed > 0) all.push_back(fmt::format("{} misses {} of the bar", label, of(judged.missed)));
    if (judged.made_up > 0) all.push_back(fmt::format("{} has {} that the bar has not", label, of(judged.made_up)));
    if (judged.energy_drift)
      all.push_back(fmt::format(
          "{}: its energy at the places with u and v is off by {} at most{}", label, number(*judged.energy_drift),
          judged.energy_share ? fmt::format(", {} of the bar's largest", number(*judged.energy_share)) : ""));
    for (const JudgedColumn& column : judged.columns)
      if (!column.told_apart())
        all.push_back(fmt::format("{}: {} cannot be told from the bar's: our own error is {}", label, column.name,
                                  number(*column.own_error)));
  }
  const Case& run = judgement.run;
  all.push_back(
      fmt::format("Ours is by {} on {} elements; its displacements are right to {}; no better one was made, for {}",
                  name(run.method), run.elements, number(judgement.estimate.total), judgement.reason));
  return all;
}

// A quantity of all solutions that have it, together.
Picture curves(const JudgeStudy& study, const JudgeResult& judgement) {
  Picture picture{"Theirs and the bar's",
                  "Markers are theirs, the line is the bar. Below, the difference: theirs less the bar's."};
  std::vector<std::string> names;
  for (const JudgedSolution& judged : judgement.solutions)
    for (const JudgedColumn& column : judged.columns)
      if (std::ranges::find(names, column.name) == names.end()) names.push_back(column.name);
  for (const std::string& name : names) {
    struct Curve {
      std::string label;
      std::vector<plot::Point> theirs, ours, difference;
    };
    std::vector<Curve> all;
    plot::Range range{0.0, 0.0}, of_rest{0.0, 0.0}, times;
    for (std::size_t s = 0; s < judgement.solutions.size(); ++s) {
      const auto& columns = judgement.solutions[s].columns;
      const auto column = std::ranges::find(columns, name, &JudgedColumn::name);
      if (column == columns.end()) continue;
      std::vector<double> left(column->ours.size());
      for (std::size_t k = 0; k < left.size(); ++k) left[k] = column->theirs[k] - column->ours[k];
      const std::vector<double>& t = study.solutions[s].times;
      all.push_back({study.solutions[s].label, plot::points_of(t, column->theirs), plot::points_of(t, column->ours),
                     plot::points_of(t, left)});
      range.add(all.back().theirs);
      range.add(all.back().ours);
      of_rest.add(all.back().difference);
      times.add(t);
    }
    const plot::Axis t = plot::fitted("t", times.low, times.high);
    plot::Figure both(t, range.axis(name)), difference(t, of_rest.axis("difference"), 160.0);
    const auto& finest = std::ranges::max(all, {}, [](const Curve& curve) { return curve.ours.size(); });
    both.line(finest.ours, {plot::series_colour(0)}, "the bar");
    difference.level(0.0, {"var(--soft)", true, 1.0});
    for (std::size_t k = 0; k < all.size(); ++k) {
      both.markers(all[k].theirs, plot::series_colour(k + 1), all[k].label);
      difference.line(all[k].difference, {plot::series_colour(k + 1)}, all[k].label);
    }
    picture.panels.push_back({"judged-" + name, name + ": theirs and the bar's", both});
    picture.panels.push_back({"difference-" + name, name + ": theirs less the bar's", difference});
  }
  return picture;
}

Json number_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

}  // namespace

std::string judge_json(const PreparedJudgement& asked, const JudgeResult& judgement) {
  Json json = Json::object();
  json["title"] = asked.scene.run.scene.title;
  json["judged"] = Json::array();
  for (std::size_t s = 0; s < judgement.solutions.size(); ++s) {
    const JudgedSolution& judged = judgement.solutions[s];
    Json one = {{"label", asked.study.solutions[s].label},
                {"step", number_or_null(asked.study.solutions[s].step)},
                {"columns", Json::object()}};
    for (const JudgedColumn& column : judged.columns)
      one["columns"][column.name] = {{"largest", column.largest},
                                     {"at", column.at},
                                     {"root_mean_square", column.root_mean_square},
                                     {"size", column.size},
                                     {"own_error", number_or_null(column.own_error)},
                                     {"told_apart", column.told_apart()},
                                     {"order", number_or_null(column.order)}};
    one["contacts"] = Json::array();
    for (const JudgedContact& contact : judged.contacts)
      one["contacts"].push_back({{"where", name(contact.where)},
                                 {"begin", number_or_null(contact.begin)},
                                 {"end", number_or_null(contact.end)},
                                 {"their_begin", number_or_null(contact.their_begin)},
                                 {"their_end", number_or_null(contact.their_end)}});
    one["missed"] = judged.missed;
    one["made_up"] = judged.made_up;
    one["energy_drift"] = number_or_null(judged.energy_drift);
    one["energy_share"] = number_or_null(judged.energy_share);
    json["judged"].push_back(std::move(one));
  }
  const Case& run = judgement.run;
  json["ours"] = {{"method", name(run.method)},
                  {"elements", run.elements},
                  {"mass", name(resolve(run).mass)},
                  {"relative_tolerance", run.tolerance.relative},
                  {"displacement_error", judgement.estimate.total},
                  {"runs", judgement.runs},
                  {"reason", judgement.reason}};
  json["data"] = asked.understood;
  json["warnings"] = asked.doubts;
  json["scene"] = complete(asked.scene);
  json["version"] = versions().viscobar;
  json["platform"] = versions().platform;
  return json_text(json);
}

std::string judge_text(const PreparedJudgement& asked, const JudgeResult& judgement) {
  const JudgeStudy study = with_short_labels(asked.study);
  std::string out;
  for (const std::string& line : asked.understood) out += line + ".\n";
  out += "\n" + text(distances(study, judgement, plain_number));
  const Table table = contacts(study, judgement, plain_number);
  if (!table.rows.empty()) out += "\n" + text(table);
  out += "\n";
  for (const std::string& line : sentences(study, judgement, plain_number)) out += line + ".\n";
  for (const std::string& line : asked.doubts) out += line + ".\n";
  return out;
}

PicturedPage judge_page(const PreparedJudgement& asked, const JudgeResult& judgement) {
  const JudgeStudy study = with_short_labels(asked.study);
  Page page = Page::of_study(asked.scene.run.scene, ": solutions of others");
  page.add_head(notes_html(sentences(study, judgement, readable_number)));
  page.add_head(html(distances(study, judgement, readable_number)));
  const Table table = contacts(study, judgement, readable_number);
  if (!table.rows.empty()) page.add_section("Contacts", html(table));
  page.add(curves(study, judgement));
  std::vector<std::string> notes = asked.understood;
  notes.insert(notes.end(), asked.doubts.begin(), asked.doubts.end());
  page.add_section("The files", notes_html(notes));
  return page.with_figures();
}

}  // namespace viscobar
