#include "io/xdmf_file.hpp"

#include <utility>

namespace viscobar {

namespace {

constexpr std::string_view closing_tags = "</Grid>\n</Domain>\n</Xdmf>\n";

}  // namespace

XdmfFile::XdmfFile(const std::filesystem::path& path, std::string field_file, std::size_t nodes)
    : file_(path), field_file_(std::move(field_file)), nodes_(nodes) {
  const std::string head =
      "<?xml version=\"1.0\"?>\n<Xdmf Version=\"2.0\">\n<Domain>\n"
      "<Grid Name=\"bar\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  file_.write_at(0, head + std::string(closing_tags));
  end_ = head.size();
}

void XdmfFile::append(std::span<const double> times) {
  std::string grids;
  const auto out = std::back_inserter(grids);
  const auto attribute = [&](const char* name, const char* dataset) {
    // The dataset grows while the run lasts, so its extent is given as far as this row.
    fmt::format_to(out,
                   "<Attribute Name=\"{0}\" AttributeType=\"Scalar\" Center=\"Node\">"
                   "<DataItem ItemType=\"HyperSlab\" Dimensions=\"1 {1}\" Type=\"HyperSlab\">"
                   "<DataItem Dimensions=\"3 2\" Format=\"XML\" NumberType=\"Int\">{2} 0 1 1 1 {1}</DataItem>"
                   "<DataItem Dimensions=\"{3} {1}\" Format=\"HDF\" NumberType=\"Float\" Precision=\"8\">{4}:/{5}"
                   "</DataItem></DataItem></Attribute>\n",
                   name, nodes_, rows_, rows_ + 1, field_file_, dataset);
  };
  for (const double time : times) {
    fmt::format_to(out,
                   "<Grid Name=\"{0}\" GridType=\"Uniform\"><Time Value=\"{1}\"/>\n"
                   "<Topology TopologyType=\"Polyline\" NumberOfElements=\"1\" NodesPerElement=\"{2}\">"
                   "<DataItem Dimensions=\"1 {2}\" Format=\"HDF\" NumberType=\"Int\" Precision=\"4\">{3}:/line"
                   "</DataItem></Topology>\n"
                   "<Geometry GeometryType=\"XYZ\"><DataItem Dimensions=\"{2} 3\" Format=\"HDF\" NumberType=\"Float\" "
                   "Precision=\"8\">{3}:/points</DataItem></Geometry>\n",
                   rows_, time, nodes_, field_file_);
    attribute("displacement", "u");
    attribute("velocity", "v");
    grids += "</Grid>\n";
    ++rows_;
  }
  // One call: a kill leaves the file with the old end or with the new one.
  file_.write_at(end_, grids + std::string(closing_tags));
  end_ += grids.size();
}

}  // namespace viscobar
