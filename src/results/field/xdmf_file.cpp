#include "results/field/xdmf_file.hpp"

#include <fmt/format.h>

#include <iterator>
#include <string_view>
#include <tuple>
#include <utility>

#include "results/output_file.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

constexpr std::string_view head =
    "<?xml version=\"1.0\"?>\n<Xdmf xmlns:xi=\"http://www.w3.org/2001/XInclude\" Version=\"3.0\">\n<Domain>\n"
    "<Grid Name=\"bar\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
// The second and third child of the first grid: the mesh, which does not change.
constexpr std::string_view of_first =
    "<xi:include xpointer=\"element(/1/1/1/1/2)\"/><xi:include xpointer=\"element(/1/1/1/1/3)\"/>\n";
constexpr std::string_view closing_tags = "</Grid>\n</Domain>\n</Xdmf>\n";

}  // namespace

XdmfFile::XdmfFile(std::filesystem::path path, std::string field_file, std::size_t nodes)
    : path_(std::move(path)), field_file_(std::move(field_file)), nodes_(nodes), written_(Checksum::of(head)) {}

void XdmfFile::begin() { write_atomically(path_, std::string(head) + std::string(closing_tags)); }

void XdmfFile::append(std::span<const double> times) {
  pending_.insert(pending_.end(), times.begin(), times.end());
  if (Clock::now() >= next_) publish();
}

void XdmfFile::close() {
  if (!pending_.empty()) publish();
  if (!std::filesystem::exists(path_)) throw IoError(path_, "was removed while it was written");
}

void XdmfFile::publish() {
  const auto started = Clock::now();
  try {
    NewFile next(path_);
    std::filesystem::copy_file(path_, next.part());
    OutputFile file(next.part(), OutputFile::Content::keep);
    Checksum written = written_;
    std::string text;
    for (std::size_t i = 0; i < pending_.size(); ++i) {
      text += grid(rows_ + i, pending_[i]);
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
  next_ = Clock::now() + 20 * (Clock::now() - started);
}

Checksum XdmfFile::checksum() const {
  Checksum whole = written_;
  whole.add(closing_tags);
  return whole;
}

std::string XdmfFile::grid(std::size_t row, double time) const {
  std::string text = fmt::format("<Grid Name=\"{}\" GridType=\"Uniform\"><Time Value=\"{}\"/>\n", row, time);
  if (row == 0)
    fmt::format_to(std::back_inserter(text),
                   "<Topology TopologyType=\"Polyline\" NumberOfElements=\"{2}\" NodesPerElement=\"2\">"
                   "<DataItem Dimensions=\"{2} 2\" Format=\"HDF\" NumberType=\"Int\" "
                   "Precision=\"4\">{1}:/line</DataItem></Topology>\n"
                   "<Geometry GeometryType=\"XYZ\"><DataItem Dimensions=\"{0} 3\" Format=\"HDF\" NumberType=\"Float\" "
                   "Precision=\"8\">{1}:/points</DataItem></Geometry>\n",
                   nodes_, field_file_, nodes_ - 1);
  else
    text += of_first;
  for (const auto& [name, dataset, center, size] : {std::tuple("displacement", "u", "Node", nodes_),
                                                    {"velocity", "v", "Node", nodes_},
                                                    {"stress", "stress", "Cell", nodes_ - 1}})
    // A row of the dataset, as start:stride:count:extent; it grows while the run lasts, so its extent is given as far
    // as this row.
    fmt::format_to(std::back_inserter(text),
                   "<Attribute Name=\"{0}\" Center=\"{6}\">"
                   "<DataItem Dimensions=\"{1}\" Format=\"HDF\" NumberType=\"Float\" Precision=\"8\">"
                   "{2}:/{3}|{4} 0:1 1:1 {1}:{5} {1}</DataItem></Attribute>\n",
                   name, size, field_file_, dataset, row, row + 1, center);
  return text + "</Grid>\n";
}

}  // namespace viscobar
