#pragma once

#include <functional>
#include <memory>
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

/// The same as Recording::filling() of what the memory of the machine can hold. @throws SceneError
Observers filling(Recording& recording, const Case& run, std::size_t rows);

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
  /// stop the run by a true value. `times`, rising from 0 on to the end at most, are kept in place of the output times;
  /// empty: those of the scene. Python's lock is released.
  void go(py::object self, py::object observer, py::object on_event, const std::vector<double>& times);

  const PythonCase& scene() const { return case_; }
  const Outcome& outcome() const { return outcome_; }
  std::string summary() const;
  std::string page() const;
  /// Writes the run into an empty directory, as `viscobar run` does. `summary` is what summary() says, or says of
  /// Python functions. @throws IoError
  void save(const std::string& directory, const std::string& summary) const;
  /// The columns of joints.csv but for the time, with their names.
  py::dict joints() const;
  py::dict gauges() const;             ///< the columns of gauges.csv but for the time
  py::array_t<double> stress() const;  ///< as field.h5 has it
  /// The columns of energy.csv but for the time.
  std::array<std::vector<double>, 6> energies() const;

 private:
  void solve(py::object& self, py::object& observer, py::object& on_event);
  void solve_to_accuracy(py::object& self, py::object& observer, py::object& on_event);
  Observers observers(py::object& self, py::object& observer, py::object& on_event);
  void warn(const std::string& warning) { outcome_.warnings.push_back(warning); }
  /// Tells the run again, contact changes before the output time that follows them.
  void replay(const std::function<void(const Snapshot&)>& snapshot,
              const std::function<void(const Event&)>& event) const;

  PythonCase case_;
  Setup setup_;
  BarSystem system_;
  Outcome outcome_;
  std::vector<double> span_;        // reactions of a span obstacle at the output times
  std::vector<double> joints_;      // forces of the joints at the output times, row by row
  std::vector<double> kept_times_;  // that were asked for; empty: those of the scene
  std::vector<double> all_times_;   // and the first and the last of the run
  bool stopping_ = false;
};

// They bind what module.cpp does not.
void bind_results(py::module_& module);
void bind_studies(py::module_& module);
void bind_orders(py::module_& module);
void bind_sweeps(py::module_& module);

/// A copy.
inline py::array_t<double> array_of(const std::vector<double>& values) {
  return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}

}  // namespace viscobar::python
