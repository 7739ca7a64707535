// viscobar._core: scenes, cases, runs, errors. The package around it (python/viscobar) is its only user.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include "case/scene_numbers.hpp"
#include "characteristics/function_of_time.hpp"
#include "dynamics/pieces.hpp"
#include "input/input_text.hpp"
#include "input/scene_values.hpp"
#include "kept.hpp"
#include "results/csv.hpp"
#include "scene/end_kinds.hpp"
#include "viscobar/case/recorder.hpp"
#include "viscobar/results/io_error.hpp"
#include "viscobar/results/versions.hpp"
#include "viscobar/studies/limit/limit.hpp"

namespace viscobar::python {

namespace {

py::object error_class(const char* name) { return py::module_::import("viscobar._errors").attr(name); }

void set_scene_error(const SceneError& error) {
  py::list findings;
  for (const Diagnostic& one : error.diagnostics)
    findings.append(py::make_tuple(one.source, one.line, one.column, one.key, one.message));
  const py::object type = error_class("SceneError");
  PyErr_SetObject(type.ptr(), type(findings).ptr());
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const SceneError& error) {
    set_scene_error(error);
  } catch (const IoError& error) {
    PyErr_SetString(PyExc_OSError, error.what());
  } catch (const IntegrationError& error) {
    const py::object type = error_class("IntegrationError");
    PyErr_SetObject(type.ptr(), type(error.what()).ptr());
  }
}

/// A load of Python functions. What is a formula in the scene is in the case already; a function has a formula of the
/// same kind in its place.
void put_load(Case& run, const py::dict& functions, const std::function<Function(const char*)>& function) {
  if (functions.contains("load.density")) {
    std::vector<double> nodes;
    const Mesh mesh = run.mesh();
    for (std::size_t j = 0; j < mesh.nodes(); ++j) nodes.push_back(mesh.node(j));
    const py::object density = functions["load.density"];
    const py::object takes_arrays = py::module_::import("viscobar._scene").attr("takes_arrays");
    if (takes_arrays(density, py::array_t<double>(static_cast<py::ssize_t>(nodes.size()), nodes.data())).cast<bool>())
      run.scene.load = GeneralLoad{NodalDensity(function("load.density"), std::move(nodes))};
    else
      run.scene.load = GeneralLoad{function("load.density")};
  }
  if (!run.scene.load) return;
  if (functions.contains("load.profile")) {
    if (auto* steady = std::get_if<SteadyLoad>(&*run.scene.load)) {
      *steady = {[f = function("load.profile"), factor = steady->profile(0.0)](double x) { return factor * f(x); }};
    } else {
      auto& separable = std::get<SeparableLoad>(*run.scene.load);
      separable.profile = function("load.profile");
      separable.places = {};
    }
  }
  if (functions.contains("load.history")) std::get<SeparableLoad>(*run.scene.load).history = function("load.history");
}

SceneError at_key(const std::string& key, const std::string& message) { return SceneError({{"", 0, 0, key, message}}); }

/// Takes the Python functions of time: forces on the ends, motion of ends and obstacles.
void put_ends(Case& run, const py::dict& functions, const std::function<Function(const char*)>& function) {
  namespace waves = characteristics;
  const Bar& bar = run.scene.bar;
  const double passage = bar.transit();
  const auto moved = [&](const std::string& key) {
    try {
      return waves::function_through(function(key.c_str()), run.end, passage);
    } catch (const std::invalid_argument& error) {
      throw at_key(key, error.what());
    }
  };
  const auto put = [&](const std::string& table, EndCondition& end, EndInput& input) {
    if (const std::string key = table + ".force"; functions.contains(key))
      input.force = EndForce{function(key.c_str())};
    if (const std::string key = table + ".motion"; functions.contains(key) && is_fixed(end)) {
      const waves::FunctionOfTime of = moved(key);
      if (std::abs(of.start) > 1e-12 * bar.length)
        throw at_key(key,
                     fmt::format("must be 0 at t = 0, where the end is at its initial displacement, is {}", of.start));
      input.motion = of.motion;
    }
    auto* obstacle = std::get_if<Obstacle>(&end);
    if (const std::string key = table + ".gap"; functions.contains(key) && obstacle) {
      const waves::FunctionOfTime of = moved(key);
      obstacle->gap = of.start;
      const auto moves = [sign = obstacle->side == Side::above ? 1.0 : -1.0](const TimeFunction& gap) -> TimeFunction {
        return [sign, gap](double t) { return sign * gap(t); };
      };
      input.motion = {moves(of.motion.displacement), moves(of.motion.velocity), moves(of.motion.acceleration),
                      of.motion.breaks};
    }
  };
  put("left", run.scene.left, run.scene.left_input);
  put("right", run.scene.right, run.scene.right_input);
}

/// A scene from text, Python functions in the places that the keys of `functions` name. `study` is the command whose
/// demands the method has to meet.
PythonCase parse(const std::string& text, const std::string& source, const py::dict& functions,
                 const std::string& study) {
  const auto faults = std::make_shared<Faults>();
  const auto function = [&](const char* key) { return Function(functions[key], key, faults); };
  const auto adapt = [&](Case& run) {
    // A chain takes it for the bars that the package has named, which have none of their own.
    const auto put = [&](const std::string& leaf, SpaceFunction& data, SpaceFunction Member::*own) {
      const std::string key = "initial." + leaf;
      if (!functions.contains(key)) return;
      data = function(key.c_str());
      std::vector<Member>& chain = run.scene.chain;
      double begin = 0.0;
      for (std::size_t k = 0; k < chain.size(); begin += chain[k++].bar.length)
        if (functions.contains(fmt::format("bar.{}.{}", k + 1, leaf)))
          chain[k].*own = [whole = function(key.c_str()), begin](double x) { return whole(begin + x); };
      if (!chain.empty()) data = along(chain, own);
    };
    put("displacement", run.scene.displacement, &Member::displacement);
    put("velocity", run.scene.velocity, &Member::velocity);
    put_load(run, functions, function);
    put_ends(run, functions, function);
    // Directions are taken again: Python functions are no formulas, and know no parameters.
    if (!functions.empty())
      for (Direction& along : run.directions)
        if (along.key == "bar.length") along = direction(run, along.key);
    if (study == "limit" || (study == "compare" && is_penalised(run.method))) run.method = penalised_method(run);
  };
  try {
    return {parse_scene(text, source, {}, adapt), faults};
  } catch (...) {
    faults->rethrow();
    throw;
  }
}

// Values of a case that a scheme of one's own reads.

std::optional<std::string> end_side(const EndCondition& end) {
  const auto* obstacle = std::get_if<Obstacle>(&end);
  return obstacle ? std::optional(std::string(name(obstacle->side))) : std::nullopt;
}

std::optional<double> end_gap(const EndCondition& end) {
  const auto* obstacle = std::get_if<Obstacle>(&end);
  return obstacle ? std::optional(obstacle->gap) : std::nullopt;
}

template <class Value>
py::array_t<double> at_nodes(const PythonCase& self, Value value) {
  const Mesh mesh = self.scene.run.mesh();
  py::array_t<double> values(static_cast<py::ssize_t>(mesh.nodes()));
  try {
    for (std::size_t j = 0; j < mesh.nodes(); ++j) values.mutable_data()[j] = value(mesh.node(j));
  } catch (const Raised&) {
    self.faults->rethrow();
    throw;
  }
  return values;
}

std::vector<std::pair<std::size_t, std::size_t>> nodes_of_members(const Case& run) {
  std::vector<std::pair<std::size_t, std::size_t>> nodes;
  for (const Piece& piece : pieces_of(run.scene, run.mesh())) nodes.emplace_back(piece.first, piece.last());
  return nodes;
}

py::array_t<double> load_at(const PythonCase& self, double t) {
  const auto& load = self.scene.run.scene.load;
  if (!load) return at_nodes(self, [](double) { return 0.0; });
  if (const auto* steady = std::get_if<SteadyLoad>(&*load)) return at_nodes(self, steady->profile);
  if (const auto* general = std::get_if<GeneralLoad>(&*load))
    return at_nodes(self, [&](double x) { return general->density(x, t); });
  const auto& separable = std::get<SeparableLoad>(*load);
  double factor = 0.0;
  return at_nodes(self, [&, first = true](double x) mutable {
    if (std::exchange(first, false)) factor = separable.history(t);
    return factor * separable.profile(x);
  });
}

using Rows = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// The steps of a scheme of one's own as a recording on the output times of the case.
std::shared_ptr<Kept> recorded(const PythonCase& self, const std::string& label, const Rows& t, const Rows& u,
                               const Rows& v, const Rows& left, const Rows& right, const py::list& events) {
  Recorder recorder(self.scene.run, label);
  const auto nodes = static_cast<std::size_t>(u.shape(1));
  for (py::ssize_t n = 0; n < t.shape(0); ++n)
    recorder.step(t.at(n), std::span(u.data(n, 0), nodes), std::span(v.data(n, 0), nodes), left.at(n), right.at(n));
  for (const py::handle& row : events) {
    const auto [time, at_left, closing, velocity, impulse] = row.cast<std::tuple<double, bool, bool, double, double>>();
    recorder.change({time, at_left ? Where::left : Where::right, at_left ? 0 : self.scene.run.elements,
                     closing ? Change::closing : Change::opening, velocity, impulse});
  }
  return std::make_shared<Kept>(Kept{recorder.recording()});
}

/// A column of the events.
template <class Value>
py::list column(const Kept& self, Value value) {
  py::list all;
  for (const Event& event : self.recording.events) all.append(value(event));
  return all;
}

template <class Values>
py::object rows_of(const py::object& self, Values values) {
  const Kept& kept = self.cast<const Kept&>();
  const std::vector<double>& all = kept.recording.*values;
  const auto rows = static_cast<py::ssize_t>(kept.rows());
  if (all.empty() && rows > 0) return py::none();
  const auto width = rows > 0 ? static_cast<py::ssize_t>(all.size()) / rows : 1;
  const bool field = values == &Recording::u || values == &Recording::v;
  return view(all.data(), field ? std::vector{rows, width} : std::vector{rows}, self);
}

void bind_cases(py::module_& m) {
  const auto value = [](auto get) { return [get](const PythonCase& self) { return get(self.scene.run); }; };
  py::class_<PythonCase>(m, "Case",
                         R"(What a scheme of one's own is given: a scene on its mesh, with step and output times.

J is the number of elements, K that of the output times. Units are those of the scene.)")
      .def_property_readonly(
          "x", [](const PythonCase& self) { return at_nodes(self, [](double x) { return x; }); }, "Nodes, J+1.")
      .def_property_readonly("members", value(&nodes_of_members), "First and last node of each bar in line.")
      .def_property_readonly(
          "t", [](const PythonCase& self) { return array_of(self.scene.run.output_times()); }, "Output times, K.")
      .def_property_readonly("elements", value([](const Case& run) { return run.elements; }), "J.")
      .def_property_readonly("h", value([](const Case& run) { return run.mesh().spacing(); }),
                             "Size of an element, the mean on a graded mesh.")
      .def_property_readonly("end", value([](const Case& run) { return run.end; }), "The last time.")
      .def_property_readonly("step", value([](const Case& run) { return resolve(run).step; }),
                             "Time step: the scene's, else the one chosen for it.")
      .def_property_readonly("length", value([](const Case& run) { return run.scene.bar.length; }), "L.")
      .def_property_readonly("density", value([](const Case& run) { return run.scene.bar.density; }), "rho.")
      .def_property_readonly("modulus", value([](const Case& run) { return run.scene.bar.modulus; }), "E.")
      .def_property_readonly("viscosity", value([](const Case& run) { return run.scene.bar.viscosity; }), "eta.")
      .def_property_readonly("left", value([](const Case& run) { return std::string(end_kind(run.scene.left).name); }),
                             "Kind of the end x = 0: obstacle, free or fixed.")
      .def_property_readonly("right",
                             value([](const Case& run) { return std::string(end_kind(run.scene.right).name); }),
                             "Likewise of x = L.")
      .def_property_readonly(
          "left_gap", value([](const Case& run) { return end_gap(run.scene.left); }),
          "Gap of the obstacle there: u >= -gap below, u <= gap above; None for another kind of end.")
      .def_property_readonly("right_gap", value([](const Case& run) { return end_gap(run.scene.right); }), "Likewise.")
      .def_property_readonly("left_side", value([](const Case& run) { return end_side(run.scene.left); }),
                             "below or above, where the obstacle is; None for another kind of end.")
      .def_property_readonly("right_side", value([](const Case& run) { return end_side(run.scene.right); }),
                             "Likewise.")
      .def_property_readonly("span_gap", value([](const Case& run) {
                               return run.scene.span ? std::optional(run.scene.span->gap) : std::nullopt;
                             }),
                             "Gap of the obstacle along the bar, or None.")
      .def_property_readonly("span_side", value([](const Case& run) {
                               return run.scene.span ? end_side(EndCondition(*run.scene.span)) : std::nullopt;
                             }),
                             "below, above or both, or None.")
      .def_property_readonly("epsilon", value([](const Case& run) { return run.epsilon; }),
                             "reaction = penetration / epsilon, or None.")
      .def_property_readonly("restitution", value([](const Case& run) { return run.restitution; }), "0 to 1, or None.")
      .def_property_readonly("relative_tolerance", value([](const Case& run) { return run.tolerance.relative; }),
                             "Of adaptive methods.")
      .def_property_readonly("absolute_tolerance", value([](const Case& run) { return run.tolerance.absolute; }),
                             "Likewise.")
      .def_property_readonly("mass", value([](const Case& run) { return std::string(name(resolve(run).mass)); }),
                             "Name of the mass matrix that the scene's method would take.")
      .def_property_readonly("title", value([](const Case& run) { return run.scene.title; }), "Free text.")
      .def_property_readonly(
          "displacement", [](const PythonCase& self) { return at_nodes(self, self.scene.run.scene.displacement); },
          "u_0 at the nodes, J+1.")
      .def_property_readonly(
          "velocity", [](const PythonCase& self) { return at_nodes(self, self.scene.run.scene.velocity); },
          "u_1 at the nodes, J+1.")
      .def_property_readonly("loaded", value([](const Case& run) { return run.scene.load.has_value(); }),
                             "Whether there is a load.")
      .def("load", &load_at, py::arg("t"), "f(x_j, t) at the nodes, J+1, force per volume; zeros without a load.")
      .def_property_readonly(
          "description", [](const PythonCase& self) { return self.scene.description(); },
          "The scene as understood, as JSON text.");
}

void bind_runs(py::module_& m) {
  py::class_<Kept, std::shared_ptr<Kept>>(m, "Kept")
      .def_property_readonly("label", [](const Kept& self) { return self.recording.label; })
      .def_property_readonly("t", [](const py::object& self) { return rows_of(self, &Recording::times); })
      .def_property_readonly("u", [](const py::object& self) { return rows_of(self, &Recording::u); })
      .def_property_readonly("v", [](const py::object& self) { return rows_of(self, &Recording::v); })
      .def_property_readonly("reaction_left",
                             [](const py::object& self) { return rows_of(self, &Recording::reaction_left); })
      .def_property_readonly("reaction_right",
                             [](const py::object& self) { return rows_of(self, &Recording::reaction_right); })
      .def_property_readonly("sensitivity",
                             [](const Kept& self) {
                               py::dict all;
                               const auto rows = static_cast<py::ssize_t>(self.rows());
                               const auto nodes = static_cast<py::ssize_t>(self.recording.mesh.nodes());
                               for (const RecordedSensitivity& one : self.recording.sensitivities) {
                                 const auto field = [&](const std::vector<double>& values) {
                                   return py::array_t<double>({rows, nodes}, values.data());
                                 };
                                 all[py::str(one.key)] =
                                     py::dict(py::arg("u") = field(one.u), py::arg("v") = field(one.v),
                                              py::arg("reaction_left") = array_of(one.reaction_left),
                                              py::arg("reaction_right") = array_of(one.reaction_right));
                               }
                               return all;
                             })
      .def_property_readonly("x",
                             [](const Kept& self) {
                               const Mesh& mesh = self.recording.mesh;
                               py::array_t<double> x(static_cast<py::ssize_t>(mesh.nodes()));
                               for (std::size_t j = 0; j < mesh.nodes(); ++j) x.mutable_data()[j] = mesh.node(j);
                               return x;
                             })
      .def("event_columns", [](const Kept& self) {
        return py::make_tuple(
            column(self, [](const Event& one) { return one.time; }),
            column(self, [](const Event& one) { return place(one); }),
            column(self, [](const Event& one) { return one.change == Change::closing ? "closing" : "opening"; }),
            column(self, [](const Event& one) { return one.velocity; }));
      });
  py::class_<Run, Kept, std::shared_ptr<Run>>(m, "Run")
      .def(py::init<PythonCase>())
      .def("go",
           [](const py::object& self, py::object observer, py::object on_event, const std::vector<double>& times) {
             self.cast<Run&>().go(self, std::move(observer), std::move(on_event), times);
           })
      .def_property_readonly("ending",
                             [](const Run& self) {
                               constexpr const char* names[] = {"completed", "failed", "refused", "interrupted"};
                               return names[static_cast<int>(self.outcome().ending)];
                             })
      .def_property_readonly("error", [](const Run& self) { return self.outcome().error; })
      .def_property_readonly("warnings", [](const Run& self) { return self.outcome().warnings; })
      .def_property_readonly("reached_time", [](const Run& self) { return self.outcome().reached_time; })
      .def_property_readonly("method", [](const Run& self) { return std::string(name(self.scene().scene.run.method)); })
      .def_property_readonly("stress", &Run::stress)
      .def("summary", &Run::summary)
      .def("page", &Run::page)
      .def("save", &Run::save)
      .def("gauges", &Run::gauges)
      .def("joints", &Run::joints)
      .def("energies", [](const Run& self) {
        py::list columns;
        for (const auto& column : self.energies()) columns.append(array_of(column));
        return columns;
      });
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  m.doc() = "The library of viscobar, for the package around this module.";
  py::register_exception_translator(translate);
  m.attr("version") = versions().viscobar;
  py::list methods;
  for (const MethodName method : all_methods) methods.append(std::string(name(method)));
  m.attr("methods") = methods;
  bind_cases(m);
  bind_runs(m);
  m.def("percentage", &percentage);
  m.def("text_of", [](const std::string& file) { return input_text(file); });
  m.def("parse", &parse, py::arg("text"), py::arg("source"), py::arg("functions"), py::arg("study") = "run");
  m.def("belongs_to_end", &belongs_to_end);
  py::list kinds;
  for (const EndKind& kind : end_kinds) kinds.append(std::string(kind.name));
  m.attr("end_kinds") = kinds;
  m.def("recorded", &recorded);
  bind_results(m);
  bind_studies(m);
  bind_orders(m);
  bind_sweeps(m);
}

}  // namespace viscobar::python
