#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "calls.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/results/outcome.hpp"

namespace viscobar::python {

/// A sound scene as the library takes it, and the exceptions of the Python functions in it.
struct PythonCase {
  SceneFile scene;
  std::shared_ptr<Faults> faults;
};

/// A run in memory whose arrays Python sees.
struct Kept {
  Recording recording;

  std::size_t rows() const { return recording.times.size(); }
};

/// Observers that fill a recording. Its arrays do not move while they grow.
Observers filling(Recording& recording, const Case& run);

/// Ends a study.
struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted") {}
};

/// Library's record(), ended by Interrupted as soon as `stop` says so.
Recording record_until(const Case& run, const std::function<bool()>& stop);

/// A run of viscobar.run(): what record_run() makes files of, kept in memory.
class Run : public Kept {
 public:
  explicit Run(PythonCase run);

  /// Runs the scene. `observer(t, u, v)` at output times and `on_event(event)` at contact changes, None or a function,
  /// stop the run by a true value. Python's lock is released.
  void go(py::object self, py::object observer, py::object on_event);

  const PythonCase& scene() const { return case_; }
  const Outcome& outcome() const { return outcome_; }
  std::string summary() const;
  std::string page() const;
  /// The columns of energy.csv but for the time.
  std::array<std::vector<double>, 6> energies() const;

 private:
  void solve(py::object& self, py::object& observer, py::object& on_event);
  void solve_to_accuracy(py::object& self, py::object& observer, py::object& on_event);
  Observers observers(py::object& self, py::object& observer, py::object& on_event);
  void warn(const std::string& warning) { outcome_.warnings.push_back(warning); }

  PythonCase case_;
  Setup setup_;
  BarSystem system_;
  Outcome outcome_;
  std::vector<double> span_;  // reactions of a span obstacle at the output times
  bool stopping_ = false;
};

/// Binds what module.cpp does not.
void bind_studies(py::module_& module);

}  // namespace viscobar::python
