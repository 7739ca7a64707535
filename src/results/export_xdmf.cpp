#include "results/export_xdmf.hpp"

#include <fmt/format.h>

#include <array>
#include <string>
#include <vector>

#include "results/field/xdmf_file.hpp"
#include "results/output_file.hpp"

namespace viscobar {

void export_xdmf(const FieldReader& field, const std::filesystem::path& target) {
  using Quantity = FieldReader::Quantity;
  NewFile values(target / "field.h5"), description(target / "field.xdmf");
  const std::filesystem::path& path = values.part();
  begin_hdf5();
  Hdf5File file(hdf5_checked(path, "cannot be created",
                             [&] { return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT); }));
  const Hdf5Properties groups(H5Pcreate(H5P_LINK_CREATE));
  H5Pset_create_intermediate_group(groups.get(), 1);
  const std::size_t n = field.nodes();
  write_dataset(path, file.get(), "points", std::array<hsize_t, 2>{n, 3}, xdmf::points(field.x()));
  write_dataset(path, file.get(), "line", std::array<hsize_t, 2>{n - 1, 2}, xdmf::line(n));

  std::string text(xdmf::head);
  std::vector<double> row;
  for (std::size_t k = 0; k < field.rows(); ++k) {
    text += xdmf::grid_head(k, field.times()[k], n);
    for (const auto& [name, quantity] :
         {std::pair("u", Quantity::displacement), {"v", Quantity::velocity}, {"stress", Quantity::stress}}) {
      if (!field.has(quantity)) continue;
      row.resize(field.width(quantity));
      field.read(quantity, k, row);
      const std::string place = fmt::format("{}/{}", name, k);
      write_dataset(path, file.get(), place, std::array<hsize_t, 1>{row.size()}, row, groups.get());
      text += xdmf::attribute(name, row.size(), place);
    }
    text += "</Grid>\n";
  }
  hdf5_checked(path, "cannot be closed", [&] { return H5Fclose(file.release()); });
  values.take_place();
  OutputFile out(description.part());
  out.write_at(0, text.append(xdmf::closing_tags));
  out.close();
  description.take_place();
}

}  // namespace viscobar
