#include "results/export_xdmf.hpp"

#include <fmt/format.h>

#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "results/output_file.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;
using Quantity = FieldReader::Quantity;

class Datasets {
 public:
  explicit Datasets(const fs::path& path) : path_(path) {
    begin_hdf5();
    file_.reset(hdf5_checked(path, "cannot be created",
                             [&] { return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT); }));
    groups_.reset(H5Pcreate(H5P_LINK_CREATE));
    H5Pset_create_intermediate_group(groups_.get(), 1);
  }

  template <class Value>
  void write(const std::string& name, hid_t stored, hid_t type, std::span<const hsize_t> extent,
             std::span<const Value> values) {
    const Hdf5Dataspace space(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr));
    const Hdf5Dataset dataset(hdf5_checked(path_, "cannot create a dataset", [&] {
      return H5Dcreate2(file_.get(), name.c_str(), stored, space.get(), groups_.get(), H5P_DEFAULT, H5P_DEFAULT);
    }));
    hdf5_checked(path_, "cannot be written",
                 [&] { return H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()); });
  }

  void close() {
    hdf5_checked(path_, "cannot be closed", [&] { return H5Fclose(file_.release()); });
  }

 private:
  fs::path path_;
  Hdf5File file_;
  Hdf5Properties groups_;
};

}  // namespace

void export_xdmf(const FieldReader& field, const fs::path& target) {
  NewFile values(target / "field.h5"), description(target / "field.xdmf");
  Datasets datasets(values.part());
  const std::size_t n = field.nodes();
  std::vector<double> points(3 * n, 0.0);
  for (std::size_t j = 0; j < n; ++j) points[3 * j] = field.x()[j];
  std::vector<int> line(2 * (n - 1));
  for (std::size_t k = 0; k < line.size(); ++k) line[k] = static_cast<int>((k + 1) / 2);
  const hsize_t extent_of_points[] = {n, 3}, extent_of_line[] = {n - 1, 2};
  datasets.write<double>("points", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, extent_of_points, points);
  datasets.write<int>("line", H5T_STD_I32LE, H5T_NATIVE_INT, extent_of_line, line);

  std::string text =
      "<?xml version=\"1.0\"?>\n<Xdmf xmlns:xi=\"http://www.w3.org/2001/XInclude\" Version=\"3.0\">\n<Domain>\n"
      "<Grid Name=\"bar\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  struct Part {
    const char *name, *dataset, *center;
    Quantity quantity;
  };
  constexpr Part parts[] = {{"displacement", "u", "Node", Quantity::displacement},
                            {"velocity", "v", "Node", Quantity::velocity},
                            {"stress", "stress", "Cell", Quantity::stress}};
  std::vector<double> row;
  for (std::size_t k = 0; k < field.rows(); ++k) {
    text += fmt::format("<Grid Name=\"{}\" GridType=\"Uniform\"><Time Value=\"{}\"/>\n", k, field.times()[k]);
    if (k == 0)
      text += fmt::format(
          "<Topology TopologyType=\"Polyline\" NumberOfElements=\"{1}\" NodesPerElement=\"2\"><DataItem "
          "Dimensions=\"{1} 2\" Format=\"HDF\" NumberType=\"Int\" Precision=\"4\">field.h5:/line</DataItem></Topology>\n"
          "<Geometry GeometryType=\"XYZ\"><DataItem Dimensions=\"{0} 3\" Format=\"HDF\" NumberType=\"Float\" "
          "Precision=\"8\">field.h5:/points</DataItem></Geometry>\n",
          n, n - 1);
    else
      text += "<xi:include xpointer=\"element(/1/1/1/1/2)\"/><xi:include xpointer=\"element(/1/1/1/1/3)\"/>\n";
    for (const Part& part : parts) {
      if (!field.has(part.quantity)) continue;
      row.resize(field.width(part.quantity));
      field.read(part.quantity, k, row);
      const std::string name = fmt::format("/{}/{}", part.dataset, k);
      const hsize_t extent[] = {row.size()};
      datasets.write<double>(name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, extent, row);
      fmt::format_to(std::back_inserter(text),
                     "<Attribute Name=\"{}\" Center=\"{}\"><DataItem Dimensions=\"{}\" Format=\"HDF\" "
                     "NumberType=\"Float\" Precision=\"8\">field.h5:{}</DataItem></Attribute>\n",
                     part.name, part.center, row.size(), name);
    }
    text += "</Grid>\n";
  }
  datasets.close();
  values.take_place();
  OutputFile file(description.part());
  file.write_at(0, text + "</Grid>\n</Domain>\n</Xdmf>\n");
  file.close();
  description.take_place();
}

}  // namespace viscobar
