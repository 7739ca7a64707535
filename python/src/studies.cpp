// viscobar._core: comparisons and studies. Their results cross as JSON text, as the program prints them.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>

#include "input/described_scene.hpp"
#include "report/fit/fit_request.hpp"
#include "report/judge/judge_request.hpp"
#include "report/scene_check.hpp"
#include "viscobar/report/reports.hpp"
#include "work.hpp"

namespace viscobar::python {

namespace {

/// Runs a study: its JSON and its page.
py::tuple reported(Work& work, auto study) {
  const StudyReport report = work(study);
  return py::make_tuple(report.json, report.page.html);
}

std::vector<MethodName> methods_of(const std::vector<std::string>& names) {
  std::vector<MethodName> methods;
  for (const std::string& word : names) {
    const auto found = std::find_if(std::begin(all_methods), std::end(all_methods),
                                    [&](MethodName method) { return name(method) == word; });
    if (found == std::end(all_methods)) throw std::invalid_argument(fmt::format("there is no method \"{}\"", word));
    methods.push_back(*found);
  }
  return methods;
}

py::dict to_dict(const Difference& d) {
  py::dict row;
  row["displacement_l2"] = d.displacement_l2;
  row["displacement_h1"] = d.displacement_h1;
  row["velocity_l2"] = d.velocity_l2;
  row["end_trace"] = d.end_trace;
  row["events"] = d.events_other;
  row["events_reference"] = d.events;
  row["events_matched"] = d.events_matched;
  row["largest_event_shift"] = d.largest_event_shift;
  row["energy_final"] = d.energy_final;
  return row;
}

/// The first contender is the reference. `own` are recordings of schemes of one's own.
py::tuple compare_methods(const PythonCase& self, const std::optional<std::vector<std::string>>& methods,
                          const std::vector<std::shared_ptr<Kept>>& own, std::size_t threads) {
  const Case& run = self.scene.run;
  const MethodChoice choice = methods ? chosen_methods(run, methods_of(*methods)) : fitting_methods(run);
  Work work(*self.faults);
  std::vector<Contender> contenders;
  for (const Case& one : choice.cases)
    contenders.push_back(
        {std::string(name(one.method)), one, [&](const Case& now) { return record_until(now, work.stop()); }});
  for (const auto& kept : own)
    contenders.push_back({kept->recording.label, run, [kept](const Case&) { return kept->recording; }});
  Comparison check = work([&] { return compare(contenders, threads); });
  // Their solver is the case's own method, but can be stopped.
  for (std::size_t i = 0; i < choice.cases.size(); ++i) check.runs[i].built_in = true;
  const StudyReport told = compare_report(self.scene, choice, check);
  py::list differences, kept;
  for (std::size_t i = 0; i < check.runs.size(); ++i) {
    const Difference* difference = check.to_reference(i);
    differences.append(difference ? py::object(to_dict(*difference)) : py::none());
    kept.append(check.runs[i].recording ? py::cast(std::make_shared<Kept>(Kept{std::move(*check.runs[i].recording)}))
                                        : py::none());
  }
  return py::make_tuple(told.json, told.page.html, differences, kept);
}

py::tuple limit_study(const PythonCase& self, const std::vector<double>& epsilons,
                      const std::vector<std::size_t>& elements, const std::vector<double>& steps, double budget,
                      std::size_t threads, const py::object& progress) {
  if (const auto fault = limit_fault(self.scene.run.scene)) throw SceneError({{"", 0, 0, fault->key, fault->problem}});
  Work work(*self.faults);
  LimitStudy study;
  study.scene = self.scene.run;
  study.epsilons = epsilons;
  study.elements = elements;
  study.steps = steps;
  study.budget = budget;
  study.threads = threads;
  study.interrupted = work.stop();
  const auto told = work.telling(progress);
  study.progress = [&](std::size_t done, std::size_t all) {
    if (told) told(done, all);
    if (work.stopped()) throw Interrupted();
  };
  return reported(work, [&] {
    if (self.scene.accuracy && study.elements.empty()) {
      const AccuracyResult solved = limit_to_accuracy(study, *self.scene.accuracy);
      study.elements = {solved.run.elements};
      study.estimate = solved.estimate;
    }
    const LimitResult result = limit_of(study);
    return limit_report(self.scene, study, result, balance_errors(study, result));
  });
}

py::tuple precision_study(const PythonCase& self, const std::vector<std::string>& methods,
                          const std::vector<double>& tolerances, const std::vector<std::size_t>& elements,
                          std::size_t halvings, std::size_t repeat, double seconds, std::size_t threads) {
  Work work(*self.faults);
  PrecisionStudy study;
  study.scene = self.scene.run;
  study.methods = methods_of(methods);
  study.tolerances = tolerances;
  study.elements = elements;
  study.halvings = halvings;
  study.repeat = repeat;
  study.seconds = seconds;
  study.threads = threads;
  study.stop = work.stop();
  return reported(work, [&] { return precision_report(self.scene, study, precision_of(study)); });
}

/// Output of `viscobar fit` as JSON, and its page.
py::tuple fit_scene(const std::string& text, FitRequest request) {
  Faults faults;
  Work work(faults);
  return reported(work, [&] {
    auto [scene, study] = prepared_fit(
        request, [&](const std::vector<Setting>& settings) { return parse_scene_with(text, "", settings); });
    study.stop = work.stop();
    return fit_report(scene, study, fit(study));
  });
}

/// Output of `viscobar compare --with`, and its page.
py::tuple judge_files(const std::string& text, const std::vector<std::vector<std::string>>& schemes) {
  Faults faults;
  Work work(faults);
  return reported(work, [&] {
    PreparedJudgement prepared = prepared_judgement(schemes, parse_scene_with(text, "", of_the_bar_itself()));
    prepared.study.stop = work.stop();
    return judge_report(prepared, judge(prepared.study));
  });
}

}  // namespace

void bind_studies(py::module_& m) {
  m.def("compare", &compare_methods);
  m.def("limit", &limit_study);
  m.def("natural_penalties", [](const PythonCase& self) { return natural_penalties(self.scene.run.scene); });
  m.def("decades", &decades);
  m.def("precision", &precision_study);
  m.def("check", [](const PythonCase& self) {
    Work work(*self.faults);
    return work([&] { return check_json(check_scene(self.scene, work.stop())); });
  });
  m.def("fit", [](const std::string& text, const std::string& data, const std::string& events,
                  std::vector<std::string> parameters, std::vector<std::string> bounds,
                  std::vector<std::string> deviations, std::size_t starts, std::size_t runs) {
    return fit_scene(text,
                     {data, events, std::move(parameters), std::move(bounds), std::move(deviations), starts, runs});
  });
  m.def("judge", &judge_files);
}

}  // namespace viscobar::python
