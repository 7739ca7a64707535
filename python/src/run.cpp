// A run in memory, and the Python functions that it calls.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "case/chatter.hpp"
#include "case/run_cost.hpp"
#include "input/described_scene.hpp"
#include "kept.hpp"
#include "record/run_outcome.hpp"
#include "report/run/run_page.hpp"
#include "results/csv.hpp"
#include "results/summary.hpp"
#include "run/stopwatch.hpp"
#include "studies/accuracy/plan.hpp"
#include "viscobar/record/record_run.hpp"

namespace viscobar::python {

NodalDensity::NodalDensity(Function function, std::vector<double> nodes)
    : function_(std::move(function)), nodes_(std::make_shared<const std::vector<double>>(std::move(nodes))) {
  py::array_t<double> array(static_cast<py::ssize_t>(nodes_->size()), nodes_->data());
  array.attr("setflags")(py::arg("write") = false);
  array_ = shared(std::move(array));
}

double NodalDensity::operator()(double x, double t) const {
  if (time_ != t) evaluate(t);
  const std::vector<double>& nodes = *nodes_;
  if (next_ >= nodes.size() || nodes[next_] != x)
    next_ = static_cast<std::size_t>(std::lower_bound(nodes.begin(), nodes.end(), x) - nodes.begin());
  if (next_ < nodes.size() && nodes[next_] == x) return values_[next_++];
  return function_(x, t);  // of another mesh
}

void NodalDensity::evaluate(double t) const {
  if (function_.faults().any()) throw Raised();
  const Gil gil;
  try {
    const py::object value =
        py::reinterpret_borrow<py::object>(function_.object())(py::handle(array_.get()), py::float_(t));
    const auto values = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(value);
    if (!values) throw py::error_already_set();
    const bool one = values.size() == 1;
    if (!one && static_cast<std::size_t>(values.size()) != nodes_->size())
      throw py::value_error(function_.key() + ": the function returned " + std::to_string(values.size()) +
                            " values for " + std::to_string(nodes_->size()) + " nodes");
    values_.resize(nodes_->size());
    if (one)
      std::fill(values_.begin(), values_.end(), *values.data());
    else
      std::copy_n(values.data(), values_.size(), values_.begin());
    time_ = t;
    next_ = 0;
    return;
  } catch (py::error_already_set& error) {
    error.restore();
  } catch (const py::value_error& error) {
    PyErr_SetString(PyExc_ValueError, error.what());
  }
  function_.faults().keep();
  throw Raised();
}

Observers filling(Recording& recording, const Case& run, std::size_t rows) {
  const std::size_t nodes = run.mesh().nodes();
  const double bytes = 2.0 * sizeof(double) * static_cast<double>(rows * nodes);
  if (bytes > memory_limit())
    throw SceneError({{"", 0, 0, "output.every",
                       fmt::format("keeps {} output times of {} nodes in memory, {:.0f} GB; take a larger one, or "
                                   "fewer elements",
                                   rows, nodes, bytes / 1e9)}});
  return recording.filling(run, rows);
}

Recording record_until(const Case& run, const std::function<bool()>& stop) {
  Recording recording;
  Observers observers = filling(recording, run, run.output_times().size());
  observers.progress = [&](double) { return stop() ? RunControl::stop : RunControl::go_on; };
  recording.statistics = simulate(resolve(run), observers);
  if (!recording.statistics.completed) throw Interrupted();
  return recording;
}

Run::Run(PythonCase run) : case_(std::move(run)), setup_(resolve(case_.scene.run)), system_(setup_.system()) {}

// How a run is stopped: a flag is set, the next step makes a checkpoint, and the run ends there. All that this module
// knows of stopping is here and in record_until().
Observers Run::observers(py::object& self, py::object& observer, py::object& on_event) {
  const Case& run = case_.scene.run;
  Observers observers = filling(recording, run, kept_times_.empty() ? run.output_times().size() : kept_times_.size());
  span_.clear();
  joints_.clear();
  observers.snapshot = [this, keep = std::move(observers.snapshot)](const Snapshot& at) {
    keep(at);
    span_.push_back(at.reaction_span);
    joints_.insert(joints_.end(), at.joint_forces.begin(), at.joint_forces.end());
  };
  // With Python's lock.
  const auto ask = [this](auto&& call) {
    const Gil gil;
    try {
      stopping_ = PyObject_IsTrue(call().ptr()) == 1 || stopping_;
      if (PyErr_Occurred()) throw py::error_already_set();
    } catch (py::error_already_set& error) {
      error.restore();
      case_.faults->keep();
      stopping_ = true;
    }
  };
  if (!observer.is_none())
    observers.snapshot = [this, ask, &self, &observer, keep = std::move(observers.snapshot)](const Snapshot& at) {
      keep(at);
      if (stopping_) return;
      const std::size_t nodes = recording.mesh.nodes(), first = recording.u.size() - nodes;
      ask([&] {
        const auto shape = static_cast<py::ssize_t>(nodes);
        return observer(at.time, view(&recording.u[first], {shape}, self), view(&recording.v[first], {shape}, self));
      });
    };
  if (!kept_times_.empty())
    observers.snapshot = [this, keep = std::move(observers.snapshot)](const Snapshot& at) {
      if (std::ranges::binary_search(kept_times_, at.time)) keep(at);
    };
  observers.event = [this, ask, &on_event, &run, keep = std::move(observers.event),
                     chatter = ChatterWatch(system_)](const Event& event) mutable {
    keep(event);
    if (!event.sensitivities.empty()) outcome_.changes.push_back(event.sensitivities);
    if (run.method != MethodName::characteristics)
      if (const auto first = chatter.heard(event)) warn(chatter_warning(setup_, system_, *first));
    if (!on_event.is_none() && !stopping_)
      ask([&] {
        return on_event(py::dict(py::arg("t") = event.time, py::arg("where") = place(event),
                                 py::arg("change") = event.change == Change::closing ? "closing" : "opening",
                                 py::arg("velocity") = event.velocity));
      });
  };
  // No observer of each step: the library would stop its clock for it, which takes a twentieth of a small bar's step.
  Checkpoints& checkpoints = observers.checkpoints.emplace();
  checkpoints.asked = [this, signals = Signals(*case_.faults)]() mutable {
    stopping_ = signals.heard() || stopping_;
    return stopping_;
  };
  checkpoints.take = [](const Checkpoint&) { return RunControl::stop; };
  return observers;
}

void Run::solve(py::object& self, py::object& observer, py::object& on_event) {
  const Observers all = observers(self, observer, on_event);
  const py::gil_scoped_release released;
  simulate_into(outcome_, setup_, system_, std::nullopt, all, all_times_);
  judge(outcome_, setup_, system_, [this](const std::string& warning) { warn(warning); });
}

void Run::solve_to_accuracy(py::object& self, py::object& observer, py::object& on_event) {
  AccuracyStudy study;
  study.scene = case_.scene.run;
  study.request = *case_.scene.accuracy;
  study.threads = 1;  // functions of the scene may be Python's
  study.stop = [signals = Signals(*case_.faults)]() mutable { return signals.heard(); };
  const SceneFile asked = case_.scene;
  std::optional<accuracy::Plan> plan;
  const auto fail_with = [&](const std::string& why) { fail(outcome_, Ending::failed, why); };
  do {
    try {
      const py::gil_scoped_release released;
      if (!plan) plan.emplace(study);
      const Case chosen = plan->next();
      case_.scene = with_settings(asked, chosen);
      setup_ = resolve(chosen);
      system_ = setup_.system();
    } catch (const StudyStopped&) {
      return fail(outcome_, Ending::interrupted, "interrupted");
    } catch (const IntegrationError& error) {
      return fail_with(error.what());
    } catch (const Raised&) {
      return fail_with("a Python function raised an exception");
    }
    recording = {};
    outcome_ = {};
    solve(self, observer, on_event);
    if (outcome_.ending != Ending::completed) return;
    try {
      const py::gil_scoped_release released;
      outcome_.error_estimate = plan->judge();
    } catch (const StudyStopped&) {
      return fail(outcome_, Ending::interrupted, "interrupted");
    } catch (const IntegrationError& error) {
      return warn(fmt::format("error: there is no estimate: {}", error.what()));
    }
  } while (plan->again());
  if (!outcome_.error_estimate->doubt.empty()) warn("error: " + outcome_.error_estimate->doubt);
}

void Run::go(py::object self, py::object observer, py::object on_event, const std::vector<double>& times) {
  const WallClock clock;
  kept_times_ = times;
  if (!times.empty())  // as far as the scene goes, whatever of it is kept
    std::ranges::set_union(times, std::array{0.0, case_.scene.run.end}, std::back_inserter(all_times_));
  case_.scene.accuracy ? solve_to_accuracy(self, observer, on_event) : solve(self, observer, on_event);
  if (!outcome_.statistics && rows() > 0) outcome_.reached_time = recording.times.back();
  outcome_.wall_seconds = clock.seconds();
  case_.faults->rethrow();
}

std::string Run::summary() const { return summary_json(case_.scene, system_, outcome_, {}); }

std::string Run::page() const {
  ReportData data(case_.scene.run, system_);
  replay([&](const Snapshot& at) { data.add(at); }, [&](const Event& event) { data.add(event); });
  Page page = report_page(setup_, system_, outcome_, data);
  tell_whole_run(page, outcome_.wall_seconds);
  return page.html();
}

std::array<std::vector<double>, 6> Run::energies() const {
  std::array<std::vector<double>, 6> columns;
  for (const EnergyState& at : recording.energy) {
    const double row[] = {at.kinetic, at.elastic, at.contact, at.dissipated, at.work, at.total()};
    for (std::size_t k = 0; k < columns.size(); ++k) columns[k].push_back(row[k]);
  }
  return columns;
}

}  // namespace viscobar::python
