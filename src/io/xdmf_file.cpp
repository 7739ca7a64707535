#include "io/xdmf_file.hpp"

#include <fmt/format.h>

#include <iterator>
#include <string_view>
#include <utility>

#include "io/output_file.hpp"
#include "viscobar/io/io_error.hpp"

namespace viscobar {

namespace {

constexpr std::string_view head =
    "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n"
    "<Grid Name=\"bar\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
constexpr std::string_view closing_tags = "</Grid>\n</Domain>\n</Xdmf>\n";

}  // namespace

XdmfFile::XdmfFile(std::filesystem::path path, std::string field_file, std::size_t nodes)
    : path_(std::move(path)), field_file_(std::move(field_file)), nodes_(nodes), end_(head.size()) {}

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
    std::size_t end = end_;
    std::string text;
    for (std::size_t i = 0; i < pending_.size(); ++i) {
      text += grid(rows_ + i, pending_[i]);
      if (text.size() < (1 << 20) && i + 1 < pending_.size()) continue;
      file.write_at(end, text);
      end += text.size();
      text.clear();
    }
    file.write_at(end, closing_tags);
    file.close();
    next.take_place();
    end_ = end;
  } catch (const std::filesystem::filesystem_error& error) {
    throw IoError(path_, "cannot be replaced: " + error.code().message());
  }
  rows_ += pending_.size();
  pending_.clear();
  next_ = Clock::now() + 20 * (Clock::now() - started);
}

std::string XdmfFile::grid(std::size_t row, double time) const {
  std::string text = fmt::format(
      "<Grid Name=\"{0}\" GridType=\"Uniform\"><Time Value=\"{1}\"/>\n"
      "<Topology TopologyType=\"Polyline\" NumberOfElements=\"1\" NodesPerElement=\"{2}\">"
      "<DataItem Dimensions=\"1 {2}\" Format=\"HDF\" NumberType=\"Int\" "
      "Precision=\"4\">{3}:/line</DataItem></Topology>\n"
      "<Geometry GeometryType=\"XYZ\"><DataItem Dimensions=\"{2} 3\" Format=\"HDF\" NumberType=\"Float\" "
      "Precision=\"8\">{3}:/points</DataItem></Geometry>\n",
      row, time, nodes_, field_file_);
  for (const auto& [name, dataset] : {std::pair{"displacement", "u"}, std::pair{"velocity", "v"}})
    // A row of the dataset, as start:stride:count:extent; it grows while the run lasts, so its extent is given as far
    // as this row.
    fmt::format_to(std::back_inserter(text),
                   "<Attribute Name=\"{0}\" AttributeType=\"Scalar\" Center=\"Node\">"
                   "<DataItem Dimensions=\"{1}\" Format=\"HDF\" NumberType=\"Float\" Precision=\"8\">"
                   "{2}:/{3}|{4} 0:1 1:1 {1}:{5} {1}</DataItem></Attribute>\n",
                   name, nodes_, field_file_, dataset, row, row + 1);
  return text + "</Grid>\n";
}

}  // namespace viscobar
