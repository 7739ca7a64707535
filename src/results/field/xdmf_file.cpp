#include "results/field/xdmf_file.hpp"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <iterator>
#include <utility>

#include "results/output_file.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace xdmf {

constexpr std::string_view head =
    "<?xml version=\"1.0\"?>\n<Xdmf xmlns:xi=\"http://www.w3.org/2001/XInclude\" Version=\"3.0\">\n<Domain>\n"
    "<Grid Name=\"bar\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
constexpr std::string_view closing_tags = "</Grid>\n</Domain>\n</Xdmf>\n";

void add_grid_head(std::string& text, std::size_t row, double time, std::size_t nodes) {
  const auto end = std::back_inserter(text);
  fmt::format_to(end, FMT_COMPILE("<Grid Name=\"{}\" GridType=\"Uniform\"><Time Value=\"{}\"/>\n"), row, time);
  // The second and third child of the first grid: the mesh, which does not change.
  if (row > 0)
    text += "<xi:include xpointer=\"element(/1/1/1/1/2)\"/><xi:include xpointer=\"element(/1/1/1/1/3)\"/>\n";
  else
    fmt::format_to(end,
                   "<Topology TopologyType=\"Polyline\" NumberOfElements=\"{1}\" NodesPerElement=\"2\"><DataItem "
                   "Dimensions=\"{1} 2\" Format=\"HDF\" NumberType=\"Int\" "
                   "Precision=\"4\">field.h5:/line</DataItem></Topology>\n"
                   "<Geometry GeometryType=\"XYZ\"><DataItem Dimensions=\"{0} 3\" Format=\"HDF\" "
                   "NumberType=\"Float\" Precision=\"8\">field.h5:/points</DataItem></Geometry>\n",
                   nodes, nodes - 1);
}

void add_attribute(std::string& text, std::string_view name, std::size_t values, std::string_view place) {
  fmt::format_to(
      std::back_inserter(text),
      FMT_COMPILE(
          "<Attribute Name=\"{}\" Center=\"{}\"><DataItem Dimensions=\"{}\" Format=\"HDF\" NumberType=\"Float\" "
          "Precision=\"8\">field.h5:/{}</DataItem></Attribute>\n"),
      name == "u"   ? "displacement"
      : name == "v" ? "velocity"
                    : name,
      name == "stress" ? "Cell" : "Node", values, place);
}

std::vector<double> points(std::span<const double> x) {
  std::vector<double> all(3 * x.size(), 0.0);
  for (std::size_t j = 0; j < x.size(); ++j) all[3 * j] = x[j];
  return all;
}

std::vector<int> line(std::size_t nodes) {
  std::vector<int> all(2 * (nodes - 1));
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = static_cast<int>((k + 1) / 2);
  return all;
}

}  // namespace xdmf

using namespace xdmf;

XdmfFile::XdmfFile(std::filesystem::path path, std::size_t nodes)
    : path_(std::move(path)), nodes_(nodes), written_(Checksum::of(head)) {}

void XdmfFile::begin() { write_atomically(path_, std::string(head) + std::string(closing_tags)); }

void XdmfFile::append(std::span<const double> times) {
  pending_.insert(pending_.end(), times.begin(), times.end());
  if (clock_.seconds() >= next_) publish();
}

void XdmfFile::close() {
  if (!pending_.empty()) publish();
  if (!std::filesystem::exists(path_)) throw IoError(path_, "was removed while it was written");
}

void XdmfFile::publish() {
  const WallClock writing;
  try {
    NewFile next(path_);
    std::filesystem::copy_file(path_, next.part());
    OutputFile file(next.part(), OutputFile::Content::keep);
    Checksum written = written_;
    std::string text;
    for (std::size_t i = 0; i < pending_.size(); ++i) {
      add_grid(text, rows_ + i, pending_[i]);
      if (text.size() < (1 << 20) && i + 1 < pending_.size()) continue;
      file.write_at(written.bytes, text);
      written.add(text);
      text.clear();
    }
    file.write_at(written.bytes, closing_tags);
    file.close();
    next.take_place();
    written_ = written;
  } catch (const std::filesystem::filesystem_error& error) {
    throw IoError(path_, "cannot be replaced: " + error.code().message());
  }
  rows_ += pending_.size();
  pending_.clear();
  next_ = clock_.seconds() + 20.0 * writing.seconds();
}

Checksum XdmfFile::checksum() const {
  Checksum whole = written_;
  whole.add(closing_tags);
  return whole;
}

void XdmfFile::add_grid(std::string& text, std::size_t row, double time) const {
  add_grid_head(text, row, time, nodes_);
  // A row of the dataset, as start:stride:count:extent; it grows while the run lasts, so its extent is given as far as
  // this row.
  for (const auto& [name, values] : {std::pair{"u", nodes_}, {"v", nodes_}, {"stress", nodes_ - 1}})
    add_attribute(text, name, values,
                  fmt::format(FMT_COMPILE("{0}|{1} 0:1 1:1 {2}:{3} {2}"), name, row, values, row + 1));
  text += "</Grid>\n";
}

}  // namespace viscobar
