#pragma once

#include <cstddef>
#include <cstdint>
#include <experimental/simd>
#include <span>
#include <vector>

#include "viscobar/discretisation/tridiagonal.hpp"

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

/// A x = b for a symmetric positive definite tridiagonal matrix whose rows are alike but for some at either end, as
/// those of a uniform bar are, by substructuring. The last row of each of the 16 stretches of LaneOrder is a
/// *separator*; with the first and last nodes the separators are the *interface* (in the order of the nodes). What lies
/// between two of them is one and the same m x m matrix T = tridiag(e, d, e) for all stretches, and is eliminated:
///
///     T = L D L^T,    y = L^{-1} b,    w = 1 / D,    l_{k+1} = e w_k,    g = -e D^{-1} L^{-1} e_0,
///     (condensed matrix) x_interface = b_interface + (g.y to the left, -l_m y_{m-1} to the right of each stretch),
///     x_k = w_k y_k + g_k x_left - l_{k+1} x_{k+1},    k = m - 1, ..., 0,    x_m = x_right.
///
/// So each sweep is one recurrence for 16 stretches, its coefficients are three numbers a row, and an end that is bound
/// by an obstacle stays in the small condensed system. So do the end rows of a matrix that has them. All arrays are in
/// the order of order().
class LaneFactor {
 public:
  LaneFactor() = default;
  /// @throws std::domain_error when the matrix is not positive definite
  explicit LaneFactor(const BandedMatrix& matrix, double scale = 1.0);
  /// For a matrix whose rows are not alike: all of it is the interface.
  static LaneFactor without_rows(const BandedMatrix& matrix);

  const LaneOrder& order() const { return order_; }
  /// Matrix of the interface; all of A when there are no rows. Whoever factorises it finds out whether it is definite.
  const BandedMatrix& condensed() const { return condensed_; }

  /// First sweep. `right(k)` is row k of b divided by the `scale` of the constructor, asked for k = 0, 1, ... once
  /// each; y receives the eliminated rows, and `interface`, which holds b there, what they pull.
  template <class Row>
  void eliminate(Row&& right, std::span<double> y, std::span<double> interface) const {
    if (order_.rows == 0) return;
    // Copies, since a store of lanes may alias anything.
    const double *lower = lower_.data(), *from_left = from_left_.data();
    const std::size_t reach = reach_, m = inner_rows();
    double* row = &y[order_.row(0)];
    Lanes eliminated = 0.0, pull = 0.0;
    for (std::size_t k = 0; k < reach; ++k, row += lane_count) {
      eliminated = right(k) - lower[k] * eliminated;
      pull += from_left[k] * eliminated;
      store_lanes(eliminated, row);
    }
    for (std::size_t k = reach; k < m; ++k, row += lane_count) {
      eliminated = right(k) - lower[k] * eliminated;
      store_lanes(eliminated, row);
    }
    double* left = &interface[order_.first - 1];
    store_lanes(load_lanes(left) + scale_ * pull, left);
    store_lanes(load_lanes(left + 1) - scale_ * lower[m] * eliminated, left + 1);
  }

  /// Second sweep, from the solution at the interface: `use(k, x)` receives row k of x, k = m - 1, ..., 0.
  template <class Row>
  void substitute(std::span<const double> interface, std::span<const double> y, Row&& use) const {
    if (order_.rows == 0) return;
    const double *lower = lower_.data() + 1, *inverse_pivot = scaled_inverse_pivot_.data(),
                 *from_left = from_left_.data();
    const std::size_t reach = reach_;
    const double* rows = &y[order_.row(0)];
    const Lanes left = load_lanes(&interface[order_.first - 1]);
    Lanes x = load_lanes(&interface[order_.first]);
    std::size_t k = inner_rows();
    while (k > reach) {
      --k;
      x = inverse_pivot[k] * load_lanes(rows + k * lane_count) - lower[k] * x;
      use(k, x);
    }
    while (k > 0) {
      --k;
      x = inverse_pivot[k] * load_lanes(rows + k * lane_count) + from_left[k] * left - lower[k] * x;
      use(k, x);
    }
  }

  /// m, rows without the separators.
  std::size_t inner_rows() const { return scaled_inverse_pivot_.size(); }

 private:
  void find_order(const BandedMatrix& matrix);
  void eliminate_inner(double d, double e);
  void condense(const BandedMatrix& matrix, double e);

  LaneOrder order_;
  double scale_ = 1.0;
  std::vector<double> lower_, scaled_inverse_pivot_, from_left_;  // l_0 = 0, ..., l_m; scale w; g
  std::size_t reach_ = 0;                                         // rows that feel their left neighbour at all
  BandedMatrix condensed_;
};

}  // namespace viscobar
