#pragma once

#include <cstddef>
#include <cstdint>
#include <experimental/simd>
#include <span>
#include <vector>

namespace viscobar {

/// One value in each of the stretches of a bar that are worked on side by side.
using Lanes = std::experimental::fixed_size_simd<double, 16>;
constexpr std::size_t lane_count = Lanes::size();

inline Lanes load_lanes(const double* x) { return Lanes(x, std::experimental::element_aligned); }
inline void store_lanes(const Lanes& lanes, double* x) { lanes.copy_to(x, std::experimental::element_aligned); }

/// An order of the nodes of a bar in which 16 stretches of equal length lie side by side,
///
///     first nodes | row 0 of all stretches | row 1 of all | ... | last nodes,
///
/// so that what is done to a stretch node by node is done to all of them at once. Node first + l rows + k is stored at
/// first + 16 k + l. Without rows, as on a short bar, it is the order of the nodes itself. The nodes next to the border
/// of the stretches are stored next to it, so the first two and the last two nodes of a bar are where they always are,
/// three where a matrix has end rows.
struct LaneOrder {
  std::size_t first = 0, rows = 0, last = 0;

  std::size_t size() const { return first + rows * lane_count + last; }
  std::size_t row(std::size_t k) const { return first + k * lane_count; }  ///< where row k begins

  /// out[node] = value(where the node is stored)
  template <class Value>
  void to_nodes(Value&& value, std::span<double> out) const {
    for (std::size_t i = 0; i < first; ++i) out[i] = value(i);
    for (std::size_t l = 0; l < lane_count; ++l)
      for (std::size_t k = 0; k < rows; ++k) out[first + l * rows + k] = value(row(k) + l);
    for (std::size_t i = size() - last; i < size(); ++i) out[i] = value(i);
  }

  /// The values of the nodes in this order.
  void from_nodes(std::span<const double> nodal, std::span<double> out) const {
    for (std::size_t i = 0; i < first; ++i) out[i] = nodal[i];
    for (std::size_t k = 0; k < rows; ++k)
      for (std::size_t l = 0; l < lane_count; ++l) out[row(k) + l] = nodal[first + l * rows + k];
    for (std::size_t i = size() - last; i < size(); ++i) out[i] = nodal[i];
  }
};

/// Fields in a LaneOrder, zero at first. Rows begin on cache lines, and the same row of different fields lies at
/// different places of a page: a processor that takes a load for a store a page apart would wait for it.
class LaneFields {
 public:
  LaneFields(const LaneOrder& order, std::size_t count) : size_(order.size()) {
    constexpr std::size_t line = 64 / sizeof(double), page = 4096 / sizeof(double), apart = page / 8 + line;
    stride_ = (size_ + page - 1) / page * page + apart;
    block_.resize(count * stride_ + 2 * line);
    const std::size_t address = reinterpret_cast<std::uintptr_t>(block_.data()) / sizeof(double);
    begin_ = line + (line - (address + order.first) % line) % line;
  }
  LaneFields(const LaneFields&) = delete;
  LaneFields& operator=(const LaneFields&) = delete;

  std::span<double> operator[](std::size_t i) { return std::span(block_).subspan(begin_ + i * stride_, size_); }

 private:
  std::size_t size_, stride_, begin_;
  std::vector<double> block_;
};

}  // namespace viscobar
