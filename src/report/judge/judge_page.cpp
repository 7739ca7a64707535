#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "report/compare/compare_tables.hpp"
#include "report/judge/judge_request.hpp"
#include "report/measured.hpp"
#include "report/number_text.hpp"
#include "report/page.hpp"
#include "results/csv.hpp"
#include "text/table.hpp"
#include "viscobar/report/reports.hpp"

namespace viscobar {

namespace {

constexpr double more_than = 1.0 + 1e-6;  // of samples whose times are rounded

// Files by their names, without the folders that all of them are in.
JudgeStudy with_short_labels(JudgeStudy study) {
  std::string shared = study.solutions.front().label;
  for (const TheirSolution& theirs : study.solutions)
    shared.erase(std::ranges::mismatch(shared, theirs.label).in1, shared.end());
  for (TheirSolution& theirs : study.solutions) theirs.label.erase(0, shared.rfind('/') + 1);
  return study;
}

// A difference, or the most it can be where our own error explains it.
std::string told(double difference, const std::optional<double>& own, const UnitPowers& unit,
                 const NumberText& number) {
  return !own || difference > 2.0 * *own || *own == 0.0 ? number(difference, unit)
                                                        : "at most " + number(difference + *own, unit);
}

Table distances(const JudgeStudy& study, const JudgeResult& judgement, const NumberText& number) {
  Table table{{"solution", "quantity", "largest difference", number.heading("at t", Dimension::time),
               "of the largest value", "our own error", "mean", "our own", "order"},
              2,
              {}};
  for (std::size_t s = 0; s < judgement.solutions.size(); ++s)
    for (const JudgedColumn& column : judgement.solutions[s].columns) {
      const UnitPowers unit = unit_of_trace(column.name);
      const auto own = [&](const std::optional<double>& error) { return error ? number(*error, unit) : "not known"; };
      table.rows.push_back(
          {study.solutions[s].label, column.name, told(column.largest, column.own_error, unit, number),
           number(column.at, 5),
           column.size > 10.0 * column.own_error.value_or(0.0) ? number(column.largest / column.size) : "",
           own(column.own_error), told(column.mean, column.own_mean, unit, number), own(column.own_mean),
           column.order ? fmt::format("{:.2f}", *column.order) : ""});
    }
  return table;
}

std::string interval(const std::optional<double>& begin, const std::optional<double>& end, const NumberText& number) {
  return begin && end ? fmt::format("{} to {}", number(*begin, 6), number(*end, 6)) : "none";
}

std::string place_of(const JudgedContact& contact) {
  return std::string(name(contact.where)) +
         (contact.place ? fmt::format("{}{}", contact.where == Where::joint ? ':' : '@', *contact.place) : "");
}

// Words for a contact: its verdict, or by how much theirs is late or longer, if samples can tell.
std::string said(const JudgedContact& contact, double sample, const NumberText& number) {
  if (contact.verdict != ContactVerdict::found) return std::string(name(contact.verdict));
  std::string words;
  const auto add = [&](double by, double told, const char* more, const char* less) {
    if (std::abs(by) > std::max(told, 2.0 * contact.own_error.value_or(0.0)))
      words += fmt::format("{}{} by {}", words.empty() ? "" : ", ", by > 0.0 ? more : less,
                           number(std::abs(by), Dimension::time));
  };
  add(*contact.delay(), more_than * sample, "late", "early");
  add(*contact.longer(), 2.0 * more_than * sample, "longer", "shorter");
  if (contact.parts != contact.their_parts)
    words +=
        fmt::format("{}in {} parts, the bar's in {}", words.empty() ? "" : ", ", contact.their_parts, contact.parts);
  return words;
}

Table contacts(const JudgeStudy& study, const JudgeResult& judgement, const NumberText& number) {
  const auto of_time = [&](const char* words) { return number.heading(words, Dimension::time); };
  Table table{
      {"solution", "where", of_time("the bar's contact"), of_time("our own error"), of_time("theirs"), ""}, 6, {}};
  for (std::size_t s = 0; s < judgement.solutions.size(); ++s)
    for (const JudgedContact& contact : judgement.solutions[s].contacts)
      table.rows.push_back({study.solutions[s].label, place_of(contact), interval(contact.begin, contact.end, number),
                            contact.own_error ? number(*contact.own_error) : "",
                            interval(contact.their_begin, contact.their_end, number),
                            said(contact, judgement.solutions[s].sample, number)});
  if (table.rows.size() > most_contacts) {
    std::ranges::stable_partition(table.rows, [](const auto& row) { return !row.back().empty(); });
    const std::size_t left_out = table.rows.size() - most_contacts;
    table.rows.resize(most_contacts);
    table.rows.push_back({fmt::format("and {} more", left_out), "", "", "", "", ""});
  }
  return table;
}

std::vector<std::string> sentences(const JudgeStudy& study, const JudgeResult& judgement, const NumberText& number) {
  std::vector<std::string> all;
  bool ordered = false;
  for (std::size_t s = 0; s < judgement.solutions.size(); ++s) {
    const JudgedSolution& judged = judgement.solutions[s];
    const std::string& label = study.solutions[s].label;
    const auto tell = [&](ContactVerdict verdict, const char* words) {
      if (const std::size_t count = judged.count(verdict))
        all.push_back(fmt::format(fmt::runtime(words), label, count, count == 1 ? "" : "s"));
    };
    tell(ContactVerdict::missed, "{} misses {} contact{} of the bar");
    tell(ContactVerdict::made_up, "{} has {} contact{} that the bar has not");
    tell(ContactVerdict::untold,
         "{}: {} contact{} cannot be told: they fit between two samples, behind the last one, or into our own error");
    double most = 0.0;
    for (const JudgedContact& contact : judged.contacts)
      if (const double delay = contact.delay().value_or(0.0); std::abs(delay) > std::abs(most)) most = delay;
    if (std::abs(most) > more_than * judged.sample)
      all.push_back(fmt::format("{}: its contacts come up to {} {}", label, number(std::abs(most), Dimension::time),
                                most > 0.0 ? "late" : "early"));
    if (judged.energy_drift)
      all.push_back(fmt::format(
          "{}: its energy at the places with u and v is off by {} at most{}", label,
          number(*judged.energy_drift, Dimension::energy),
          judged.energy_share ? fmt::format(", {} of the bar's largest", number(*judged.energy_share)) : ""));
    for (const JudgedColumn& column : judged.columns) {
      ordered = ordered || column.order;
      if (!column.told_apart())
        all.push_back(fmt::format("{}: {} cannot be told from the bar's: our own error is {}", label, column.name,
                                  number(*column.own_distance(), unit_of_trace(column.name))));
    }
  }
  if (ordered)
    all.emplace_back(
        "The order is that of the largest difference of displacements, and of the mean of all else, which jumps");
  const Case& run = judgement.run;
  all.push_back(fmt::format(
      "Our solution is by {} on {} elements, and the error of its displacements is {}. No finer one was computed: {}",
      name(run.method), run.elements, number(judgement.estimate.total, Dimension::length), judgement.reason));
  return all;
}

// A quantity of all solutions that have it, together.
Picture curves(const JudgeStudy& study, const JudgeResult& judgement, const NumberText& number) {
  Picture picture{"Theirs and the bar's",
                  "Markers are theirs, the line is the bar. Below, the difference: theirs less the bar's."};
  std::size_t longest = 0;
  for (const TheirSolution& one : study.solutions) longest = std::max(longest, one.times.size());
  picture.caption += plot::thinned_remark(longest);
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
    const plot::Axis t = plot::fitted(number.heading("t", Dimension::time), times.low, times.high);
    const UnitPowers unit = unit_of_trace(name);
    plot::Figure both(t, range.axis(number.heading(name, unit)));
    plot::Figure difference(t, of_rest.axis(number.heading("difference", unit)), 160.0);
    for (std::size_t k = 0; k < all.size(); ++k) {
      both.markers(all[k].theirs, plot::series_colour(k + 1), all[k].label);
      difference.line(all[k].difference, {plot::series_colour(k + 1)}, all[k].label);
    }
    // Above their markers, which may be many.
    const auto& finest = std::ranges::max(all, {}, [](const Curve& curve) { return curve.ours.size(); });
    both.line(finest.ours, {"var(--ink)"}, "the bar");
    difference.level(0.0, {"var(--soft)", true, 1.0});
    picture.panels.push_back({"judged-" + name, name + ": theirs and the bar's", both});
    picture.panels.push_back({"difference-" + name, name + ": theirs less the bar's", difference});
  }
  return picture;
}

std::string json_text_of(const PreparedJudgement& asked, const JudgeResult& judgement) {
  Json json = Json::object();
  json["title"] = asked.scene.run.scene.title;
  json["judged"] = Json::array();
  for (std::size_t s = 0; s < judgement.solutions.size(); ++s) {
    const JudgedSolution& judged = judgement.solutions[s];
    Json one = {{"label", asked.study.solutions[s].label},
                {"step", asked.study.solutions[s].step},
                {"columns", Json::object()}};
    for (const JudgedColumn& column : judged.columns)
      one["columns"][column.name] = {{"largest", column.largest},
                                     {"at", column.at},
                                     {"root_mean_square", column.root_mean_square},
                                     {"mean", column.mean},
                                     {"size", column.size},
                                     {"own_error", column.own_error},
                                     {"own_mean", column.own_mean},
                                     {"told_apart", column.told_apart()},
                                     {"order", column.order},
                                     {"order_of", column.jumps() ? "mean" : "largest"}};
    one["contacts"] = Json::array();
    for (const JudgedContact& contact : judged.contacts)
      one["contacts"].push_back({{"where", place_of(contact)},
                                 {"verdict", name(contact.verdict)},
                                 {"begin", contact.begin},
                                 {"end", contact.end},
                                 {"their_begin", contact.their_begin},
                                 {"their_end", contact.their_end},
                                 {"delay", contact.delay()},
                                 {"longer", contact.longer()},
                                 {"parts", contact.parts},
                                 {"their_parts", contact.their_parts},
                                 {"own_error", contact.own_error}});
    one["sample"] = judged.sample;
    one["missed"] = judged.count(ContactVerdict::missed);
    one["made_up"] = judged.count(ContactVerdict::made_up);
    one["untold"] = judged.count(ContactVerdict::untold);
    one["energy_drift"] = judged.energy_drift;
    one["energy_share"] = judged.energy_share;
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
  return study_json(std::move(json), asked.warnings, asked.scene);
}

std::string terminal_text(const PreparedJudgement& asked, const JudgeResult& judgement) {
  const JudgeStudy study = with_short_labels(asked.study);
  const NumberText number = NumberText::terminal(asked.scene.run.scene);
  std::string out;
  for (const std::string& line : asked.understood) out += line + ".\n";
  out += "\n" + text(distances(study, judgement, number));
  const Table table = contacts(study, judgement, number);
  if (!table.rows.empty()) out += "\n" + text(table);
  out += "\n";
  for (const std::string& line : sentences(study, judgement, number)) out += line + ".\n";
  for (const std::string& line : asked.warnings) out += line + ".\n";
  return out + "\n";
}

PicturedPage page_of(const PreparedJudgement& asked, const JudgeResult& judgement) {
  const JudgeStudy study = with_short_labels(asked.study);
  const NumberText number = NumberText::page(asked.scene.run.scene);
  Page page = Page::of_study(asked.scene.run.scene, ": solutions of others");
  page.add_head(notes_html(sentences(study, judgement, number)));
  page.add_section("Distances", html(distances(study, judgement, number)));
  const Table table = contacts(study, judgement, number);
  if (!table.rows.empty()) page.add_section("Contacts", html(table));
  page.add(curves(study, judgement, number));
  std::vector<std::string> notes = asked.understood;
  notes.insert(notes.end(), asked.warnings.begin(), asked.warnings.end());
  page.add_section("The files", notes_html(notes));
  return page.with_figures();
}

}  // namespace

StudyReport judge_report(const PreparedJudgement& asked, const JudgeResult& judgement) {
  return {json_text_of(asked, judgement), page_of(asked, judgement), terminal_text(asked, judgement)};
}

}  // namespace viscobar
