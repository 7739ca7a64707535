#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "run/stopwatch.hpp"
#include "text/checksum.hpp"

namespace viscobar {

/// Pieces of the description that lets ParaView open field.h5: a temporal collection of grids whose cells are the
/// elements, with displacement and velocity at the nodes and the stress of each cell. The first grid has the mesh, the
/// others refer to it.
namespace xdmf {

extern const std::string_view head, closing_tags;

/// The beginning of a grid, which ends with "</Grid>\n".
void add_grid_head(std::string& text, std::size_t row, double time, std::size_t nodes);

/// A quantity of a grid; `name` is u, v or stress, `place` says where its values are in field.h5.
void add_attribute(std::string& text, std::string_view name, std::size_t values, std::string_view place);

std::vector<double> points(std::span<const double> x);  ///< (J+1) x 3, the nodes in space
std::vector<int> line(std::size_t nodes);               ///< J x 2, the nodes of each element

}  // namespace xdmf

/// The description of a field that grows. A new one is made from the old and takes its place at once, so whatever
/// happens to a run there is a whole one; that costs a copy, and is done so often that it takes a twentieth of the
/// time.
/// @throws IoError
class XdmfFile {
 public:
  XdmfFile(std::filesystem::path path, std::size_t nodes);

  void begin();
  /// Adds the next times; their rows must be in the field file by now.
  void append(std::span<const double> times);
  void close();
  Checksum checksum() const;

 private:
  void publish();
  void add_grid(std::string& text, std::size_t row, double time) const;

  std::filesystem::path path_;
  std::size_t nodes_, rows_ = 0;
  Checksum written_;  // of what stands before the closing tags
  std::vector<double> pending_;
  WallClock clock_;
  double next_ = 0.0;  // on it
};

}  // namespace viscobar
