#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace viscobar::python {

namespace py = pybind11;

/// Python's lock, for a thread that may have it already.
class Gil {
 public:
  Gil() : state_(PyGILState_Ensure()) {}
  ~Gil() { PyGILState_Release(state_); }
  Gil(const Gil&) = delete;
  Gil& operator=(const Gil&) = delete;

 private:
  PyGILState_STATE state_;
};

/// Leads out of the library after Python code has raised an exception, which is in Faults.
struct Raised : std::runtime_error {
  Raised() : std::runtime_error("a Python function raised an exception") {}
};

/// The first exception of Python code that the library has called. The library makes errors of its own of what passes
/// through it; the user is to see the exception itself.
class Faults {
 public:
  bool any() const { return any_.load(std::memory_order_relaxed); }
  /// Keeps what Python has just raised. With Python's lock.
  void keep() {
    py::error_already_set raised;
    if (!any()) first_.emplace(std::move(raised));
    any_ = true;
  }
  /// With Python's lock.
  void rethrow() {
    if (!any()) return;
    py::error_already_set raised = std::move(*first_);
    first_.reset();
    any_ = false;
    throw raised;
  }

 private:
  std::optional<py::error_already_set> first_;
  std::atomic<bool> any_{false};
};

/// A Python object that may be copied and dropped by any thread.
inline std::shared_ptr<PyObject> shared(py::object object) {
  return {object.release().ptr(), [](PyObject* kept) {
            const Gil gil;
            Py_DECREF(kept);
          }};
}

/// A Python function of numbers with a number as its value, for the library: double(double...). `key` names it.
class Function {
 public:
  Function(py::object function, std::string key, std::shared_ptr<Faults> faults)
      : function_(shared(std::move(function))), key_(std::move(key)), faults_(std::move(faults)) {}

  template <class... Number>
  double operator()(Number... at) const {
    if (faults_->any()) throw Raised();
    const Gil gil;
    PyObject* arguments[] = {nullptr, PyFloat_FromDouble(at)...};
    PyObject* value =
        PyObject_Vectorcall(function_.get(), arguments + 1, sizeof...(at) | PY_VECTORCALL_ARGUMENTS_OFFSET, nullptr);
    for (PyObject* argument : arguments) Py_XDECREF(argument);
    const double number = value ? number_of(value) : 0.0;
    Py_XDECREF(value);
    if (!PyErr_Occurred()) return number;
    faults_->keep();
    throw Raised();
  }

  PyObject* object() const { return function_.get(); }
  const std::string& key() const { return key_; }
  Faults& faults() const { return *faults_; }

 private:
  double number_of(PyObject* value) const {
    const double number = PyFloat_AsDouble(value);
    if (number == -1.0 && PyErr_Occurred())
      PyErr_Format(PyExc_TypeError, "%s: the function returned %s, not a number", key_.c_str(),
                   Py_TYPE(value)->tp_name);
    return number;
  }

  std::shared_ptr<PyObject> function_;
  std::string key_;
  std::shared_ptr<Faults> faults_;
};

/// f(x, t) of a Python function that takes all nodes in one call. The library asks node by node: the first node asked
/// for at a new time makes the call, the others find their values.
class NodalDensity {
 public:
  NodalDensity(Function function, std::vector<double> nodes);
  double operator()(double x, double t) const;

 private:
  void evaluate(double t) const;

  Function function_;
  std::shared_ptr<const std::vector<double>> nodes_;
  std::shared_ptr<PyObject> array_;  // of the nodes
  mutable std::vector<double> values_;
  mutable std::optional<double> time_;
  mutable std::size_t next_ = 0;
};

/// Hears Ctrl-C while the library works: every 20 ms, for Python's lock costs more than a step. Even the clock costs a
/// hundredth of one, and is looked at so often that some 5 ms pass in between.
class Signals {
 public:
  explicit Signals(Faults& faults) : faults_(faults) {}
  /// To be asked after each step: whether a handler has raised an exception, which Faults then holds.
  bool heard() {
    if (static_cast<double>(++steps_) < stride_) return faults_.any();
    const auto now = Clock::now();
    const double passed = std::chrono::duration<double>(now - looked_).count();
    stride_ = std::clamp(static_cast<double>(steps_) * 5e-3 / std::max(passed, 1e-9), 1.0, 4.0 * stride_);
    steps_ = 0;
    looked_ = now;
    if (now < next_) return faults_.any();
    next_ = now + std::chrono::milliseconds(20);
    const Gil gil;
    if (PyErr_CheckSignals() != 0) faults_.keep();
    return faults_.any();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Faults& faults_;
  std::size_t steps_ = 0;
  double stride_ = 1.0;
  Clock::time_point looked_ = Clock::now(), next_ = looked_ + std::chrono::milliseconds(20);
};

/// A view of rows of numbers that `owner` keeps, which nobody may write to.
inline py::array_t<double> view(const double* values, std::vector<py::ssize_t> shape, const py::handle& owner) {
  py::array_t<double> all(std::move(shape), values, owner);
  py::detail::array_proxy(all.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return all;
}

}  // namespace viscobar::python
