// viscobar._core: comparisons, studies and sweeps. Their results cross as JSON text, as the program prints them.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <future>
#include <map>

#include "input/described_scene.hpp"
#include "kept.hpp"
#include "report/fit/fit_request.hpp"
#include "report/judge/judge_request.hpp"
#include "report/scene_check.hpp"
#include "studies/parallel.hpp"
#include "sweep/sweep_workers.hpp"
#include "viscobar/record/record_run.hpp"
#include "viscobar/report/reports.hpp"
#include "viscobar/studies/ensemble/ensemble.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar::python {

namespace {

/// Does the work in another thread, without Python's lock, while this one hears signals; `stop` tells the work of one.
template <class Work>
void hearing_signals(Faults& faults, std::atomic<bool>& stop, Work work) {
  {
    const py::gil_scoped_release released;
    std::future<void> done = std::async(std::launch::async, std::move(work));
    Signals signals(faults);
    while (done.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready)
      if (signals.heard()) stop = true;
    try {
      done.get();
    } catch (...) {
      if (!faults.any()) throw;
    }
  }
  faults.rethrow();
}

/// Runs a study so: its JSON and its page.
template <class Study>
py::tuple reported(Faults& faults, std::atomic<bool>& stop, Study study) {
  StudyReport report;
  hearing_signals(faults, stop, [&] { report = study(); });
  return py::make_tuple(report.json, report.page.html);
}

/// Tells a Python function how many are done of how many; empty for None. What it raises stops the work.
std::function<void(std::size_t, std::size_t)> telling(const py::object& progress, Faults& faults,
                                                      std::atomic<bool>& stop) {
  if (progress.is_none()) return {};
  return [&](std::size_t done, std::size_t all) {
    if (stop) return;
    const Gil gil;
    try {
      progress(done, all);
    } catch (py::error_already_set& raised) {
      raised.restore();
      faults.keep();
      stop = true;
    }
  };
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
  std::atomic<bool> stop{false};
  std::vector<Contender> contenders;
  for (const Case& one : choice.cases)
    contenders.push_back({std::string(name(one.method)), one,
                          [&](const Case& now) { return record_until(now, [&] { return stop.load(); }); }});
  for (const auto& kept : own)
    contenders.push_back({kept->recording.label, run, [kept](const Case&) { return kept->recording; }});
  Comparison check;
  hearing_signals(*self.faults, stop, [&] { check = compare(contenders, threads); });
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
  std::atomic<bool> stop{false};
  LimitStudy study;
  study.scene = self.scene.run;
  study.epsilons = epsilons;
  study.elements = elements;
  study.steps = steps;
  study.budget = budget;
  study.threads = threads;
  study.interrupted = [&] { return stop.load(); };
  const auto told = telling(progress, *self.faults, stop);
  study.progress = [&](std::size_t done, std::size_t all) {
    if (told) told(done, all);
    if (stop) throw Interrupted();
  };
  return reported(*self.faults, stop, [&] {
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
  std::atomic<bool> stop{false};
  PrecisionStudy study;
  study.scene = self.scene.run;
  study.methods = methods_of(methods);
  study.tolerances = tolerances;
  study.elements = elements;
  study.halvings = halvings;
  study.repeat = repeat;
  study.seconds = seconds;
  study.threads = threads;
  study.stop = [&] { return stop.load(); };
  return reported(*self.faults, stop, [&] { return precision_report(self.scene, study, precision_of(study)); });
}

// Orders.

Refine refine_of(const std::string& what) {
  return what == "mesh" ? Refine::mesh : what == "step" ? Refine::step : Refine::both;
}

std::vector<PythonCase> refined(const PythonCase& self, const std::string& what, std::size_t levels) {
  Case run = self.scene.run;
  run.step = resolve(run).step;
  std::vector<PythonCase> all;
  for (Case& one : refinements(run, refine_of(what), levels))
    all.push_back({{std::move(one), self.scene.values, {}, std::nullopt}, self.faults});
  return all;
}

std::shared_ptr<Kept> record_case(const PythonCase& self) {
  auto kept = std::make_shared<Kept>();
  std::atomic<bool> stop{false};
  hearing_signals(*self.faults, stop,
                  [&] { kept->recording = record_until(self.scene.run, [&] { return stop.load(); }); });
  return kept;
}

/// An exact solution by its values at nodes and times.
class Sampled {
 public:
  Sampled(std::shared_ptr<const Recording> exact, const std::vector<double> Recording::*values)
      : exact_(std::move(exact)), values_(values) {
    for (std::size_t j = 0; j < exact_->mesh.nodes(); ++j) nodes_.push_back(exact_->mesh.node(j));
  }
  double operator()(double x, double t) const {
    return (*exact_.*values_)[nearest(exact_->times, t) * nodes_.size() + nearest(nodes_, x)];
  }
  double operator()(double t) const { return (*exact_.*values_)[nearest(exact_->times, t)]; }

 private:
  static std::size_t nearest(const std::vector<double>& sorted, double value) {
    const auto above = std::lower_bound(sorted.begin() + 1, sorted.end() - 1, value);
    return static_cast<std::size_t>(above - sorted.begin()) - (value - *(above - 1) < *above - value ? 1 : 0);
  }

  std::shared_ptr<const Recording> exact_;
  const std::vector<double> Recording::*values_;
  std::vector<double> nodes_;
};

/// The solution of Python functions u(x, t), v(x, t), reaction_left(t), reaction_right(t); or else by characteristics
/// where they fit, on the finest of the meshes, which has the nodes of all.
std::optional<exact::Solution> solution_of(const std::vector<PythonCase>& cases, const py::dict& functions) {
  const PythonCase& self = cases.back();
  exact::Solution solution{self.scene.run.scene, {}, {}, {}, {}};
  if (functions.contains("u")) {
    const auto function = [&](const char* key) { return Function(functions[key], key, self.faults); };
    solution.u = function("u");
    if (functions.contains("v")) solution.v = function("v");
    if (functions.contains("reaction_left")) solution.reaction_left = function("reaction_left");
    if (functions.contains("reaction_right")) solution.reaction_right = function("reaction_right");
    return solution;
  }
  PythonCase exact = self;
  exact.scene.run.method = MethodName::characteristics;
  if (!sound(exact.scene.run)) return std::nullopt;
  const std::shared_ptr<const Recording> waves = std::make_shared<Recording>(std::move(record_case(exact)->recording));
  solution.u = Sampled(waves, &Recording::u);
  solution.v = Sampled(waves, &Recording::v);
  solution.reaction_left = Sampled(waves, &Recording::reaction_left);
  solution.reaction_right = Sampled(waves, &Recording::reaction_right);
  return solution;
}

/// Rows and orders of recordings of refined cases: to the exact solution, or else each to the next finer step.
py::tuple observed_orders(const std::vector<PythonCase>& cases, const std::vector<std::shared_ptr<Kept>>& kept,
                          const std::string& what, const py::dict& functions) {
  const auto solution = solution_of(cases, functions);
  if (!solution && what != "step")
    throw std::invalid_argument(
        "no exact solution of this scene is known; give one, or refine the step alone: each step is then compared with "
        "the next finer one");
  const bool velocity = !solution || solution->v,
             reaction = solution && (solution->reaction_left || solution->reaction_right);
  std::vector<Case> runs;
  for (const PythonCase& one : cases) runs.push_back(one.scene.run);
  const Solver recall = [&](const Case& run) {
    std::size_t i = 0;
    while (runs[i].elements != run.elements || runs[i].step != run.step) ++i;
    Recording recording = kept[i]->recording;
    if (!velocity) recording.v.clear();
    if (!reaction) recording.reaction_left.clear(), recording.reaction_right.clear();
    return recording;
  };
  const Refine refine = refine_of(what);
  // On one thread: the exact solution may be a Python function.
  OrderStudy study;
  try {
    study = solution ? order_study(recall, *solution, runs, refine, 1) : self_study(recall, runs, 1);
  } catch (...) {
    cases.back().faults->rethrow();
    throw;
  }
  py::list rows;
  for (const OrderStudy::Row& row : study.rows) {
    py::dict one;
    one["elements"] = row.elements;
    one["step"] = row.step;
    one["displacement_l2"] = row.error.displacement_l2;
    one["end_trace"] = row.error.end_trace;
    if (velocity) one["velocity_l2"] = row.error.velocity_l2;
    if (reaction) one["reaction_l1"] = row.error.reaction_l1;
    rows.append(one);
  }
  py::dict orders;
  const auto add = [&](const char* key, const std::optional<SequenceOrder>& order) {
    orders[key] = order ? py::object(py::make_tuple(order->order, order->standard_error, order->bound)) : py::none();
  };
  add("displacement_l2", study.displacement_l2);
  add("end_trace", study.end_trace);
  if (velocity) add("velocity_l2", study.velocity_l2);
  if (reaction) add("reaction_l1", study.reaction_l1);
  return py::make_tuple(rows, orders);
}

/// Output of `viscobar fit` as JSON, and its page.
py::tuple fit_scene(const std::string& text, FitRequest request) {
  Faults faults;
  std::atomic<bool> stop{false};
  return reported(faults, stop, [&] {
    auto [scene, study] = prepared_fit(
        request, [&](const std::vector<Setting>& settings) { return parse_scene_with(text, "", settings); });
    study.stop = [&] { return stop.load(); };
    return fit_report(scene, study, fit(study));
  });
}

/// Output of `viscobar compare --with`, and its page.
py::tuple judge_files(const std::string& text, const std::vector<std::vector<std::string>>& schemes) {
  Faults faults;
  std::atomic<bool> stop{false};
  return reported(faults, stop, [&] {
    PreparedJudgement prepared = prepared_judgement(schemes, parse_scene_with(text, "", of_the_bar_itself()));
    prepared.study.stop = [&] { return stop.load(); };
    return judge_report(prepared, judge(prepared.study));
  });
}

/// A list, a row for each bar: what the first axis is long is theirs.
py::array array_of(std::vector<double> values, std::size_t bars, const std::vector<std::size_t>& shape) {
  std::vector<py::ssize_t> whole{static_cast<py::ssize_t>(bars)};
  whole.insert(whole.end(), shape.begin(), shape.end());
  auto* kept = new std::vector<double>(std::move(values));
  const py::capsule owner(kept, [](void* all) { delete static_cast<std::vector<double>*>(all); });
  return py::array_t<double>(std::move(whole), kept->data(), owner);
}

py::dict ensemble_of(const std::string& text, const std::vector<std::string>& keys,
                     const std::vector<py::array_t<double, py::array::c_style | py::array::forcecast>>& values,
                     std::vector<std::string> outputs, std::optional<double> error, std::size_t threads,
                     const py::object& progress) {
  EnsembleStudy study;
  study.model = [&](std::span<const double> at) {
    std::vector<Setting> settings;
    for (std::size_t k = 0; k < keys.size(); ++k) settings.push_back(std::pair(keys[k], SceneValue(at[k])));
    return parse_scene_with(text, "", settings).run;
  };
  study.keys = keys;
  for (const auto& list : values) study.values.emplace_back(list.data(), static_cast<std::size_t>(list.size()));
  study.outputs = std::move(outputs);
  study.error = error;
  study.threads = threads;
  Faults faults;
  std::atomic<bool> stop{false};
  study.stop = [&] { return stop.load(); };
  study.progress = telling(progress, faults, stop);
  EnsembleResult result;
  hearing_signals(faults, stop, [&] { result = ensemble(study); });
  py::dict told;
  for (std::size_t o = 0; o < result.outputs.size(); ++o)
    told[py::str(result.outputs[o].name)] = array_of(std::move(result.values[o]), result.bars, result.outputs[o].shape);
  const auto codes = [&](const auto& list) {
    py::array_t<std::uint8_t> all(static_cast<py::ssize_t>(list.size()));
    for (std::size_t i = 0; i < list.size(); ++i)
      all.mutable_at(static_cast<py::ssize_t>(i)) = static_cast<std::uint8_t>(list[i]);
    return all;
  };
  told["status"] = codes(result.status);
  told["way"] = codes(result.ways);
  told["error"] = array_of(std::move(result.error), result.bars, {});
  told["steps"] = py::array_t<std::int64_t>(static_cast<py::ssize_t>(result.steps.size()),
                                            std::vector<std::int64_t>(result.steps.begin(), result.steps.end()).data());
  told["messages"] = result.messages;
  py::dict times;
  for (const EnsembleOutput& output : result.outputs)
    if (!output.times.empty()) times[py::str(output.name)] = array_of(output.times, output.times.size(), {});
  told["times"] = times;
  return told;
}

// Sweeps.

VariedKey::Values values_of(const py::list& values) {
  const auto all = [&](auto is) { return std::all_of(values.begin(), values.end(), is); };
  if (all([](const py::handle& value) { return py::isinstance<py::str>(value); }))
    return values.cast<std::vector<std::string>>();
  if (all([](const py::handle& value) { return py::isinstance<py::int_>(value); }))
    return values.cast<std::vector<std::int64_t>>();
  return values.cast<std::vector<double>>();
}

py::dict to_dict(const SweepPlan& plan, const SweepRow& row) {
  py::dict one;
  one["index"] = row.index;
  const std::vector<std::size_t> chosen = plan.choice(row.index);
  for (std::size_t k = 0; k < plan.keys.size(); ++k)
    std::visit([&](const auto& list) { one[py::str(plan.keys[k].key)] = list[chosen[k]]; }, plan.keys[k].values);
  one["completed"] = row.completed;
  one["error"] = row.error;
  const std::vector<QuantityColumn> columns = plan.columns();
  for (std::size_t k = 0; k < columns.size(); ++k) one[py::str(columns[k].name)] = row.column(k);
  one["seconds"] = row.seconds;
  one["integration_seconds"] = row.integration_seconds;
  return one;
}

/// Appends the rows to `table`, in the order of the cases; those that are done also where the sweep is interrupted.
void run_sweep(const SweepFile& sweep, std::size_t threads, py::list table) {
  Faults faults;
  std::vector<double> costs;
  std::atomic<bool> stop{false};
  hearing_signals(faults, stop, [&] { costs = plan_cases(sweep, threads); });
  SweepQueue queue(sweep, costs);
  std::map<std::size_t, SweepRow> rows;
  if (threads == 0) threads = cores();
  const SweepWork work{sweep, queue, [&](const SweepRow& row) { rows[row.index] = row; }, [] {},
                       [&] { return stop.load(); }};
  const auto tell = [&] {
    for (const auto& [index, row] : rows) table.append(to_dict(sweep.plan, row));
  };
  try {
    hearing_signals(faults, stop, [&] { run_on_threads(work, std::min(threads, queue.size())); });
  } catch (...) {
    tell();
    throw;
  }
  tell();
}

void sweep_scene(const std::string& text, const py::dict& vary, bool zip, std::size_t threads, py::list table) {
  SweepFile sweep;
  sweep.scene_text = text;
  sweep.plan.combine = zip ? Combine::zip : Combine::grid;
  for (const auto& [key, values] : vary)
    sweep.plan.keys.push_back({key.cast<std::string>(), values_of(values.cast<py::list>())});
  heed_scene(sweep);
  run_sweep(sweep, threads, std::move(table));
}

}  // namespace

void bind_studies(py::module_& m) {
  m.def("compare", &compare_methods);
  m.def("limit", &limit_study);
  m.def("natural_penalties", [](const PythonCase& self) { return natural_penalties(self.scene.run.scene); });
  m.def("decades", &decades);
  m.def("precision", &precision_study);
  m.def("check", [](const PythonCase& self) {
    std::atomic<bool> stop{false};
    std::string json;
    hearing_signals(*self.faults, stop,
                    [&] { json = check_json(check_scene(self.scene, [&] { return stop.load(); })); });
    return json;
  });
  m.def("refined", &refined);
  m.def("record", &record_case);
  m.def("orders", &observed_orders);
  m.def("fit", [](const std::string& text, const std::string& data, const std::string& events,
                  std::vector<std::string> parameters, std::vector<std::string> bounds,
                  std::vector<std::string> deviations, std::size_t starts, std::size_t runs) {
    return fit_scene(text,
                     {data, events, std::move(parameters), std::move(bounds), std::move(deviations), starts, runs});
  });
  m.def("judge", &judge_files);
  m.def("ensemble", &ensemble_of);
  const auto words = [](auto last) {
    std::vector<std::string> all;
    for (int k = 0; k <= static_cast<int>(last); ++k) all.emplace_back(name(static_cast<decltype(last)>(k)));
    return all;
  };
  m.attr("bar_statuses") = words(BarStatus::not_run);
  m.attr("bar_ways") = words(BarWay::alone);
  m.def("sweep_scene", &sweep_scene);
  m.def("sweep_file", [](const std::string& file, std::size_t threads, py::list table) {
    run_sweep(read_sweep(file), threads, std::move(table));
  });
}

}  // namespace viscobar::python
