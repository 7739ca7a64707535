// viscobar._core: ensembles and sweeps.
#include <pybind11/stl.h>

#include <algorithm>
#include <map>

#include "input/described_scene.hpp"
#include "studies/parallel.hpp"
#include "sweep/sweep_workers.hpp"
#include "viscobar/studies/ensemble/ensemble.hpp"
#include "viscobar/sweep/sweep.hpp"
#include "work.hpp"

namespace viscobar::python {

namespace {

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
  Work work(faults);
  study.stop = work.stop();
  study.progress = work.telling(progress);
  EnsembleResult result = work([&] { return ensemble(study); });
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
  Work run(faults);
  const std::vector<double> costs = run([&] { return plan_cases(sweep, threads); });
  SweepQueue queue(sweep, costs);
  std::map<std::size_t, SweepRow> rows;
  if (threads == 0) threads = cores();
  const SweepWork work{sweep, queue, [&](const SweepRow& row) { rows[row.index] = row; }, [] {}, run.stop()};
  const auto tell = [&] {
    for (const auto& [index, row] : rows) table.append(to_dict(sweep.plan, row));
  };
  try {
    run([&] { run_on_threads(work, std::min(threads, queue.size())); });
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

void bind_sweeps(py::module_& m) {
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
