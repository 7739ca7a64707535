// viscobar._core: results on the disk, and the tables of a run that are not kept but made.
#include <algorithm>

#include "dynamics/gauge.hpp"
#include "dynamics/pieces.hpp"
#include "input/input_text.hpp"
#include "kept.hpp"
#include "report/page.hpp"
#include "results/csv.hpp"
#include "results/field/hdf5_handle.hpp"
#include "results/growing_files.hpp"
#include "results/output_file.hpp"
#include "results/result_directory.hpp"
#include "results/result_info.hpp"

namespace viscobar::python {

namespace {

namespace fs = std::filesystem;

/// The text of summary.json of a sound result of `viscobar run`.
std::string stored_summary(const std::string& name) {
  const fs::path place = name;
  settle_result_directory(place);
  if (!fs::exists(place / "summary.json"))
    throw std::invalid_argument(name + " holds no result of a run: there is no summary.json");
  for (const VerifiedFile& file : verify_result(place))
    if (file.state == FileState::damaged) throw IoError(place / file.name, "is damaged: " + file.reason);
  return input_text(place / "summary.json");
}

/// The numbers of a dataset of field.h5, of any extents.
py::array_t<double> dataset(const std::string& file, const std::string& name) {
  begin_hdf5();
  const Hdf5File opened = hdf5_file(file);
  const Hdf5Dataset data = hdf5_dataset(file, opened, name);
  const Hdf5Dataspace space(H5Dget_space(data.get()));
  std::vector<hsize_t> extents(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space.get()))));
  H5Sget_simple_extent_dims(space.get(), extents.data(), nullptr);
  py::array_t<double> values(std::vector<py::ssize_t>(extents.begin(), extents.end()));
  if (values.size() > 0) read_values(file, data, H5T_NATIVE_DOUBLE, values.mutable_data());
  return values;
}

}  // namespace

void Run::replay(const std::function<void(const Snapshot&)>& snapshot,
                 const std::function<void(const Event&)>& event) const {
  const std::size_t nodes = recording.mesh.nodes(), joints = rows() > 0 ? joints_.size() / rows() : 0;
  auto next = recording.events.begin();
  for (std::size_t k = 0; k < rows(); ++k) {
    for (; next != recording.events.end() && next->time <= recording.times[k]; ++next) event(*next);
    Snapshot at{recording.times[k], recording.displacement(k), recording.velocity(k), recording.reaction_left[k],
                recording.reaction_right[k]};
    at.joint_forces = std::span(joints_).subspan(k * joints, joints);
    if (k < recording.energy.size()) at.energy = recording.energy[k];
    if (k < span_.size()) at.reaction_span = span_[k];
    std::vector<FieldSensitivity> rates;
    for (const RecordedSensitivity& of : recording.sensitivities)
      rates.push_back({std::span(of.u).subspan(k * nodes, nodes), std::span(of.v).subspan(k * nodes, nodes),
                       of.reaction_left[k], of.reaction_right[k]});
    at.sensitivities = rates;
    snapshot(at);
  }
  for (; next != recording.events.end(); ++next) event(*next);
}

void Run::save(const std::string& directory, const std::string& summary) const {
  const ResultDirectory results(directory, ResultKind::run);
  SceneFile whole = case_.scene;
  whole.run.files = {};  // all of them, whatever output.write says
  GrowingFiles files(results.path(), whole);
  files.take_places();
  replay([&](const Snapshot& at) { files.append(at); }, [&](const Event& event) { files.append(event); });
  FileChecksums written;
  const auto close = [&](const char* name, auto& file) {
    if (!file) return;
    file->close();
    written[name] = file->checksum();
  };
  for (std::size_t k = 0; k < files.tables.size(); ++k) close(GrowingFiles::names[k], files.tables[k]);
  close("field.h5", files.field);
  written["field.xdmf"] = files.field->xdmf_checksum();
  written.merge(write_page(results.path(), "report.html", {page(), {}}));
  write_atomically(results.path() / "summary.json", sealed_summary(summary, written), true);
}

py::dict Run::joints() const {
  py::dict all;
  const std::vector<std::size_t> nodes = joint_nodes_of(case_.scene.run);
  if (nodes.empty()) return all;
  const std::string header = joints_header(case_.scene.run.scene);
  const std::vector<std::string_view> names = split(header, ',');
  const std::size_t width = rows() > 0 ? joints_.size() / rows() : 0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    std::vector<double> left, right, force;
    for (std::size_t row = 0; row < rows(); ++row) {
      const std::span<const double> u = recording.displacement(row);
      left.push_back(u[nodes[k] - 1]);
      right.push_back(u[nodes[k]]);
      force.push_back(k < width ? joints_[row * width + k] : 0.0);
    }
    for (std::size_t q = 0; const auto* column : {&left, &right, &force})
      all[py::str(std::string(names[1 + 3 * k + q++]))] = array_of(*column);
  }
  return all;
}

py::dict Run::gauges() const {
  const Case& run = case_.scene.run;
  const std::vector<std::string> names = gauge_columns(run.gauges);
  const auto count = static_cast<py::ssize_t>(rows());
  std::vector<py::array_t<double>> columns(names.size());
  for (auto& column : columns) column = py::array_t<double>(count);
  const std::vector<Gauge> gauges = make_gauges(run.gauges, recording.mesh, run.scene);
  for (std::size_t k = 0; k < rows(); ++k)
    for (std::size_t i = 0; i < gauges.size(); ++i) {
      const auto [u, v, strain, stress] = gauges[i](recording.displacement(k), recording.velocity(k));
      const double values[] = {u, v, strain, stress};
      for (std::size_t q = 0; q < 4; ++q) columns[4 * i + q].mutable_data()[k] = values[q];
    }
  py::dict all;
  for (std::size_t i = 0; i < names.size(); ++i) all[py::str(names[i])] = columns[i];
  return all;
}

py::array_t<double> Run::stress() const {
  const Scene& scene = case_.scene.run.scene;
  const Mesh& mesh = recording.mesh;
  const std::vector<Bar> bars = element_bars(scene, mesh);
  py::array_t<double> all({rows(), mesh.elements});
  double* next = all.mutable_data();
  for (std::size_t k = 0; k < rows(); ++k)
    for (std::size_t j = 0; j < mesh.elements; ++j)
      *next++ =
          element_stress(bars.empty() ? scene.bar : bars[j], mesh, recording.displacement(k), recording.velocity(k), j);
  return all;
}

void bind_results(py::module_& m) {
  m.def("stored_summary", &stored_summary);
  m.def("dataset", &dataset);
}

}  // namespace viscobar::python
