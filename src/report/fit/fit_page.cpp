#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "report/measured.hpp"
#include "report/number_text.hpp"
#include "report/page.hpp"
#include "studies/fit/noise.hpp"
#include "text/printable_text.hpp"
#include "text/table.hpp"
#include "viscobar/report/reports.hpp"

namespace viscobar {

namespace {

// NaN and infinities become null.
Json matrix(const std::vector<double>& entries, std::size_t n) {
  Json rows = Json::array();
  for (std::size_t i = 0; i < n; ++i)
    rows.push_back(std::vector<double>(entries.begin() + static_cast<std::ptrdiff_t>(i * n),
                                       entries.begin() + static_cast<std::ptrdiff_t>((i + 1) * n)));
  return rows;
}

double root_mean_square(const MeasuredTrace& data, const std::vector<double>& model) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t k = 0; k < model.size(); ++k)
    if (std::isfinite(data.values[k])) sum += std::pow(model[k] - data.values[k], 2), ++count;
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

std::vector<std::string> remarks(const FitStudy& study, const FitResult& result) {
  std::vector<std::string> found = study.warnings;
  found.insert(found.end(), result.warnings.begin(), result.warnings.end());
  for (const Undetermined& lack : result.undetermined) {
    std::string shares;
    for (std::size_t k = 0; k < lack.shares.size(); ++k)
      if (std::abs(lack.shares[k]) > 1e-3)
        shares += fmt::format("{}{:+.3g} of {}", shares.empty() ? "" : ", ", lack.shares[k], study.parameters[k].key);
    found.push_back(fmt::format(
        "the data do not determine a change of the parameters by ({}), each counted in its estimate", shares));
  }
  const std::vector<Estimate>& parameters = result.parameters;
  for (std::size_t a = 0; a < parameters.size(); ++a) {
    if (parameters[a].at_bound)
      found.push_back(fmt::format("{} is at its bound, and would go further", parameters[a].key));
    for (std::size_t b = a + 1; b < parameters.size(); ++b)
      if (const double correlation = result.correlation[a * parameters.size() + b]; std::abs(correlation) > 0.99)
        found.push_back(fmt::format("{} and {} are hard to tell apart: correlation {:.4f}", parameters[a].key,
                                    parameters[b].key, correlation));
  }
  if (result.lost)
    found.push_back(
        fmt::format("from t = {:.6g} on the run has no derivatives, and the data there count for nothing in "
                    "the deviations",
                    *result.lost));
  return found;
}

double deviations_of_95(const FitResult& result) { return fitting::students_bound(0.95, result.freedom); }

std::string verdict(const FitResult& result) {
  const std::string freedom =
      result.freedom == 0
          ? "as many parameters as numbers: the deviations are those of the data as they are given or assumed"
          : fmt::format("{} degrees of freedom: 95 % of values lie within {:.3g} standard deviations", result.freedom,
                        deviations_of_95(result));
  return fmt::format("{}: {}. Model and data differ by {:.3g} standard deviations of the data; {}",
                     result.converged ? "Converged" : "Not converged", result.reason, result.residual, freedom);
}

// The digits of a value down to the second one of its error, some that are right where there is none.
int digits_beside(double value, double error) {
  constexpr int few = 6, most = 12;
  if (!std::isfinite(error) || !(error > 0.0) || value == 0.0) return few;
  const double digits = std::floor(std::log10(std::abs(value))) - std::floor(std::log10(error)) + 2.0;
  return static_cast<int>(std::clamp(digits, 1.0, double{most}));
}

Table estimates(const FitResult& result, const NumberText& number) {
  Table table{{"parameter", "estimate", "half width, 95 %", "standard deviation"}, 1, {}};
  for (const Estimate& one : result.parameters) {
    const UnitPowers unit = number.unit_of(one.key);
    const double half_width = deviations_of_95(result) * one.standard_deviation;
    const auto of_error = [&](double error) {
      return std::isfinite(error) ? number(error, unit, 2) : one.at_bound ? "at its bound" : "not determined";
    };
    table.rows.push_back({one.key, number(one.estimate, unit, digits_beside(one.estimate, half_width)),
                          of_error(half_width), of_error(one.standard_deviation)});
  }
  return table;
}

Picture traces_picture(const FitStudy& study, const FitResult& result, const NumberText& number) {
  Picture picture{
      "Data and model",
      "Markers are measured, the line is the model with the estimates. Below each, what is left: model less data."};
  picture.caption += plot::thinned_remark(study.times.size());
  for (std::size_t i = 0; i < study.traces.size(); ++i) {
    const MeasuredTrace& data = study.traces[i];
    const std::string column = name(data.column, data.place);
    std::vector<double> left(result.traces[i].size());
    for (std::size_t k = 0; k < left.size(); ++k) left[k] = result.traces[i][k] - data.values[k];
    const auto measured = plot::points_of(study.times, data.values);
    const auto model = plot::points_of(study.times, result.traces[i]), residual = plot::points_of(study.times, left);
    const UnitPowers unit = unit_of_trace(column);
    const plot::Axis t = plot::fitted(number.heading("t", Dimension::time), 0.0, study.times.back());
    plot::Range all{0.0, 0.0}, of_rest{0.0, 0.0};
    all.add(measured);
    all.add(model);
    of_rest.add(residual);
    plot::Figure both(t, all.axis(number.heading(column, unit)));
    both.markers(measured, plot::series_colour(1), "measured");
    both.line(model, {"var(--ink)", false, 2.0}, "model");  // to be seen on the marks
    plot::Figure rest(t, of_rest.axis(number.heading("model − data", unit)), 160.0);
    rest.level(0.0, {"var(--soft)", true, 1.0});
    rest.markers(residual, plot::series_colour(1), "residual");
    picture.panels.push_back({"fit-" + column, column + ", measured and of the model", both});
    picture.panels.push_back({"residual-" + column, column + ": model less data", rest});
  }
  return picture;
}

std::string json_text_of(const SceneFile& scene, const FitStudy& study, const FitResult& result) {
  const std::size_t n = result.parameters.size();
  Json json = Json::object();
  json["title"] = scene.run.scene.title;
  json["method"] = name(scene.run.method);
  json["parameters"] = Json::object();
  for (std::size_t k = 0; k < n; ++k) {
    const Estimate& one = result.parameters[k];
    const FittedParameter& asked = study.parameters[k];
    json["parameters"][one.key] = {{"estimate", one.estimate},
                                   {"standard_deviation", one.standard_deviation},
                                   {"model_error", result.model_errors[k]},
                                   {"half_width_95", deviations_of_95(result) * one.standard_deviation},
                                   {"at_bound", one.at_bound},
                                   {"start", asked.start},
                                   {"low", asked.low},
                                   {"high", asked.high}};
  }
  json["covariance"] = matrix(result.covariance, n);
  json["correlation"] = matrix(result.correlation, n);
  json["residual"] = result.residual;
  json["residuals"] = Json::object();
  for (std::size_t i = 0; i < study.traces.size(); ++i)
    json["residuals"][name(study.traces[i].column, study.traces[i].place)] = {
        {"root_mean_square", root_mean_square(study.traces[i], result.traces[i])},
        {"deviation", study.traces[i].deviation}};
  if (!study.changes.empty()) json["residuals"]["events"] = {{"deviation", study.change_deviation}};
  json["data"] = study.understood;
  json["measured"] = result.measured;
  json["degrees_of_freedom"] = result.freedom;
  json["runs"] = result.runs;
  json["iterations"] = result.iterations;
  json["converged"] = result.converged;
  json["reason"] = result.reason;
  json["starts"] = result.sums;
  json["singular_values"] = result.singular_values;
  json["undetermined"] = Json::array();
  for (const Undetermined& lack : result.undetermined) {
    Json shares = Json::object();
    for (std::size_t k = 0; k < n; ++k) shares[study.parameters[k].key] = lack.shares[k];
    json["undetermined"].push_back({{"singular_value", lack.singular_value}, {"shares", shares}});
  }
  return study_json(std::move(json), remarks(study, result), scene);
}

std::string terminal_text(const SceneFile& scene, const FitStudy& study, const FitResult& result) {
  const NumberText number = NumberText::terminal(scene.run.scene);
  std::string out;
  for (const std::string& line : study.understood) out += line + ".\n";
  out += (out.empty() ? "" : "\n") + text(estimates(result, number));
  out += fmt::format("\n{}.\n{} numbers, {} runs of the model.\n", verdict(result), result.measured, result.runs);
  for (std::size_t i = 0; i < study.traces.size(); ++i) {
    const std::string column = name(study.traces[i].column, study.traces[i].place);
    out += fmt::format("{}: root mean square of model less data {}.\n", column,
                       number(root_mean_square(study.traces[i], result.traces[i]), unit_of_trace(column)));
  }
  for (const std::string& line : remarks(study, result)) out += line + ".\n";
  return out + "\n";
}

PicturedPage page_of(const SceneFile& scene, const FitStudy& study, const FitResult& result) {
  const NumberText number = NumberText::page(scene.run.scene);
  Page page = Page::of_study(scene.run.scene, ": fit");
  page.add_head(notes_html({"The numbers of this scene are those that the fit starts from"}));
  Numbers numbers;
  numbers.add("Numbers measured", result.measured);
  numbers.add("Runs of the model", result.runs);
  numbers.add("Residual", number(result.residual), "in the standard deviations of the data");
  page.add_section("The fit", fmt::format("<p>{}.</p>\n", sentence_html(verdict(result))) +
                                  html(estimates(result, number)) + numbers.list());
  page.add(traces_picture(study, result, number));
  const std::vector<std::string> notes = remarks(study, result);
  if (!notes.empty()) page.add_section("What speaks against it, and what the data do not tell", notes_html(notes));
  if (!study.understood.empty()) page.add_section("The data", notes_html(study.understood));
  return page.with_figures();
}

}  // namespace

StudyReport fit_report(const SceneFile& scene, const FitStudy& study, const FitResult& result) {
  return {json_text_of(scene, study, result), page_of(scene, study, result), terminal_text(scene, study, result)};
}

}  // namespace viscobar
