// viscobar._core: observed orders of schemes of one's own.
#include "viscobar/studies/orders/orders.hpp"

#include <pybind11/stl.h>

#include <algorithm>

#include "work.hpp"

namespace viscobar::python {

namespace {

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
  Work work(*self.faults);
  return work([&] { return std::make_shared<Kept>(Kept{record_until(self.scene.run, work.stop())}); });
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

}  // namespace

void bind_orders(py::module_& m) {
  m.def("refined", &refined);
  m.def("record", &record_case);
  m.def("orders", &observed_orders);
}

}  // namespace viscobar::python
