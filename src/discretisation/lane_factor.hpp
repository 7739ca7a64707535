#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "discretisation/lanes.hpp"
#include "viscobar/discretisation/tridiagonal.hpp"

namespace viscobar {

/// An order of the nodes of a chain of bars in which 16 lanes of equally many nodes lie side by side,
///
///     first nodes | row 0 of all lanes | row 1 of all | ... | other nodes,
///
/// so that what is done to a lane node by node is done to all of them at once. The first and the other nodes are the
/// *interface*, in the order of the nodes. A lane is a *run* of neighbours, or several runs where nodes of the
/// interface lie between, as at contacts of joints; row k of lane l is stored at first + 16 k + l. In an *even* order
/// each lane is one run, and one node of the interface lies between each two: those and the one behind the last lane
/// are stored as one more row. Without rows, as on a short bar, it is the order of the nodes itself. The first two and
/// the last two nodes are where they always are, three where a matrix has end rows.
struct LaneOrder {
  /// Neighbours in a lane, from row `begin` on.
  struct Run {
    std::size_t node, lane, begin, count;
    std::size_t end() const { return begin + count; }         ///< row behind it
    std::size_t node_behind() const { return node + count; }  ///< of the interface, as the one before it
  };

  std::size_t size = 0;  ///< nodes
  std::size_t first = 0, rows = 0;
  std::vector<Run> runs{};  ///< rising

  std::size_t row(std::size_t k) const { return first + k * lane_count; }  ///< where row k begins
  std::size_t interface_size() const { return size - rows * lane_count; }  ///< nodes in no lane
  bool even() const {
    return runs.size() == lane_count && runs.back().node == runs.front().node + (lane_count - 1) * (rows + 1);
  }
  /// Where node i of the interface is stored.
  std::size_t stored(std::size_t i) const { return i < first || rows == 0 ? i : i + rows * lane_count; }
  /// Number of one of them among the interface's nodes.
  std::size_t interface_index(std::size_t node) const {
    std::size_t inner = 0;
    for (const Run& run : runs) inner += run.node < node ? run.count : 0;
    return node - inner;
  }
  /// Where a node is stored.
  std::size_t place(std::size_t node) const {
    for (const Run& run : runs)
      if (run.node <= node && node < run.node_behind()) return row(run.begin + node - run.node) + run.lane;
    return stored(interface_index(node));
  }

  /// out[node] = value(where the node is stored)
  template <class Value>
  void to_nodes(Value&& value, std::span<double> out) const {
    each_of_interface([&](std::size_t node, std::size_t at) { out[node] = value(at); });
    for (const Run& run : runs)
      for (std::size_t k = 0; k < run.count; ++k) out[run.node + k] = value(row(run.begin + k) + run.lane);
  }

  /// The values of the nodes in this order.
  void from_nodes(std::span<const double> nodal, std::span<double> out) const {
    each_of_interface([&](std::size_t node, std::size_t at) { out[at] = nodal[node]; });
    if (runs.size() != lane_count) {
      for (const Run& run : runs) {
        const double* const from = &nodal[run.node];
        double* const to = &out[row(run.begin) + run.lane];
        std::size_t k = 0;
        for (; k + 4 <= run.count; k += 4)
          for (const std::size_t j : {k, k + 1, k + 2, k + 3}) to[j * lane_count] = from[j];
        for (; k < run.count; ++k) to[k * lane_count] = from[k];
      }
      return;
    }
    for (std::size_t k = 0; k < rows; ++k)
      for (std::size_t l = 0; l < lane_count; ++l) out[row(k) + l] = nodal[runs[l].node + k];
  }

 private:
  void each_of_interface(auto&& use) const {
    std::size_t node = 0, i = 0;
    for (const Run& run : runs) {
      for (; node < run.node; ++node, ++i) use(node, stored(i));
      node = run.node_behind();
    }
    for (; node < size; ++node, ++i) use(node, stored(i));
  }
};

/// Fields in a LaneOrder, zero at first. Rows begin on cache lines, and the same row of different fields lies at
/// different places of a page: a processor that takes a load for a store a page apart would wait for it.
class LaneFields {
 public:
  LaneFields(const LaneOrder& order, std::size_t count) : size_(order.size) {
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

/// A x = b for a positive definite tridiagonal matrix with one-sided rows, by substructuring. A run of LaneOrder is
/// coupled to the nodes of the interface beside it by e_left and e_right. Its m rows T are eliminated:
///
///     T = L D U,    y = L^{-1} b,    w = 1 / D,    l_{k+1} = T_{k+1,k} w_k,    u_{k+1} = T_{k,k+1} w_k,
///     g = D^{-1} L^{-1} e_0,    q = D^{-1} U^{-T} (c_1 e_0 + c_2 e_1),
///     (condensed matrix) x_interface = b_interface - (q.y to the left of each run, and to its right
///                                                     (d_1 - d_2 u_{m-1}) w_{m-1} y_{m-1} + d_2 w_{m-2} y_{m-2}),
///     x_k = w_k y_k - g_k (e_left x_left) - u_{k+1} x_{k+1},    k = m - 1, ..., 0,    x_m = x_right.
///
/// The row of the node before it takes x_0 and x_1 of the run by c_1 and c_2, that of the node behind it those from its
/// end on by d_1 and d_2; c_2 and d_2 are entries of one-sided rows, as at joints. Such a row r inside a run gives L
/// the entry (r, r - 2) and U the entry (r, r + 2).
///
/// So each sweep is one recurrence for 16 lanes. Where rows are alike but for some at either end, as those of a uniform
/// bar are, its coefficients are three numbers a row, else five a node. What is bound by an obstacle stays in the
/// small condensed system. So do the one-sided rows of the ends, with their columns, and all of them in an order that
/// is not even. All arrays are in the order of order().
class LaneFactor {
 public:
  LaneFactor() = default;
  /// The factor where rows are alike but for some at either end.
  /// @throws NotPositive
  explicit LaneFactor(const BandedMatrix& matrix, double scale = 1.0);
  /// The same of any rows; `kept` nodes stay in the interface.
  LaneFactor(const BandedMatrix& matrix, double scale, const std::vector<std::size_t>& kept);
  /// All of the matrix is the interface.
  static LaneFactor without_rows(const BandedMatrix& matrix);

  const LaneOrder& order() const { return order_; }
  /// Matrix of the interface; all of A when there are no rows. Whoever factorises it finds out whether it is definite.
  const BandedMatrix& condensed() const { return condensed_; }

  /// First sweep. `right(k)` is row k of b divided by the `scale` of the constructor, asked for k = 0, 1, ... once
  /// each. Where it has a next_break(), that gives what the last row of each run lacks, as they end, rising, and what
  /// the first row of the one behind it in its lane has too much. y receives the eliminated rows, and `interface`,
  /// which holds b there, what they pull.
  template <class Row>
  void eliminate(const Row& right, std::span<double> y, std::span<double> interface) const {
    if (order_.rows == 0) return;
    if (unlike_.lower.empty())
      eliminate_by(alike_, right, y, interface);
    else
      eliminate_by(unlike_, right, y, interface);
  }

  /// Second sweep, from the solution at the interface: y becomes x, and `use(k, x)` receives row k of it, k = m - 1,
  /// ..., 0.
  template <class Row>
  void substitute(std::span<const double> interface, std::span<double> y, const Row& use) const {
    if (order_.rows == 0) return;
    if (unlike_.lower.empty())
      substitute_by(alike_, interface, y, use);
    else
      substitute_by(unlike_, interface, y, use);
  }

 private:
  template <class Coefficient>
  struct Rows {
    // l_0, ..., l_{m-1}, l_0 being 0, or 1 where a run follows another; u_1, ..., u_m; scale w; g.
    std::vector<Coefficient> lower, upper, scaled_inverse_pivot, from_left;
    std::vector<Coefficient> to_left;  // q, or, where A is symmetric, g; empty: g
  };
  // A run and its neighbours in the interface. The run feels the left one by coupling g. That one's row takes q.y of
  // it, times by_left, and the right one's row the last y and the one before, times to_right.
  struct Ends {
    std::size_t lane = 0, left = 0, right = 0;
    double coupling = 0.0, by_left = 0.0;
    std::array<double, 2> to_right{};
  };
  // The same of all lanes of an even order: each couples the nodes of the interface beside it.
  struct EvenEnds {
    Lanes coupling = 0.0, by_left = 0.0;
    std::array<Lanes, 2> to_right{};
  };
  // L(k, k - 2) and U(k, k + 2) of one-sided rows.
  struct Second {
    Lanes lower = 0.0, upper = 0.0;
  };
  // Rows up to `end`, in which no run begins: which feel a left neighbour at all.
  struct Piece {
    std::size_t end;
    bool felt;
    std::vector<Ends> ended{};       // runs that end with it, but for the last of each lane
    std::optional<Second> second{};  // of its first row
  };
  // A run as its neighbours see it: how far it feels the left one; the factor of q in that one's row, and what the row
  // takes of T^{-1} e_0 and T^{-1} e_{m-1}, over it; the same of the right one's row, last column first. `beyond` has
  // c_2 and d_2 of a run of one node, which are of the neighbours themselves.
  struct Reach {
    std::size_t rows = 0;
    double coupling, corner = 0.0, through = 0.0, last = 0.0, back = 0.0;
    std::array<double, 2> to_right{}, beyond{};
    bool symmetric;
  };

  void take_alike(const BandedMatrix& matrix);
  void take_all(const BandedMatrix& matrix, const std::vector<std::size_t>& kept);
  bool take_even(const BandedMatrix& matrix, std::size_t begin, std::size_t end);
  void build(const BandedMatrix& matrix, bool alike);
  Reach eliminate_run(const BandedMatrix& matrix, const LaneOrder::Run& run, auto&& each) const;
  void condense(const BandedMatrix& matrix, const std::vector<Reach>& reach);
  void cut(const BandedMatrix& matrix, const std::vector<Reach>& reach);
  void cut_evenly(const BandedMatrix& matrix, const std::vector<Reach>& reach,
                  const std::map<std::size_t, Second>& seconds);

  // Calls that lanes pass through cost more than their arithmetic: all are inlined.
  template <class C, class Row>
  [[gnu::flatten]] void eliminate_by(const Rows<C>& of, const Row& given, std::span<double> y,
                                     std::span<double> interface) const {
    // Copies, since a store of lanes may alias anything; arguments that are copies stay in memory.
    Row right = given;
    const C *lower = of.lower.data(), *to_left = of.to_left.empty() ? of.from_left.data() : of.to_left.data();
    double* row = &y[order_.row(0)];
    Lanes eliminated = 0.0, pull = 0.0;
    std::size_t k = 0;
    // A run has ended in front of `row`, and passes to its neighbours. Returns the force in front of the next one.
    const auto end = [&](const Ends& run, double pulled) __attribute__((always_inline)) {
      double* const last = row - lane_count + run.lane;
      double in_front = 0.0;
      if constexpr (requires { right.next_break(); }) {
        const auto [behind, before] = right.next_break();
        *last += behind;  // it is linear in its force
        pulled += reinterpret_cast<const double*>(to_left + k - 1)[run.lane] * behind;
        in_front = before;
      }
      interface[run.left] -= scale_ * run.by_left * pulled;
      interface[run.right] -= run.to_right[0] * *last;
      if (run.to_right[1] != 0.0) interface[run.right] -= run.to_right[1] * *(last - lane_count);
      return in_front;
    };
    const auto add = [&](const Lanes& force, auto felt) __attribute__((always_inline)) {
      eliminated = force - lower[k] * eliminated;
      if constexpr (felt) pull += to_left[k] * eliminated;
      store_lanes(eliminated, row);
      ++k, row += lane_count;
    };
    for (const Piece& piece : pieces_) {
      if constexpr (std::is_same_v<C, Lanes>)
        if (piece.second) {
          Lanes force = right(k);
          if (k >= 2) force -= piece.second->lower * load_lanes(row - 2 * lane_count);
          add(force, std::true_type());
        }
      if (piece.felt)
        while (k < piece.end) add(right(k), std::true_type());
      else
        while (k < piece.end) add(right(k), std::false_type());
      if constexpr (std::is_same_v<C, Lanes>) {
        if (piece.ended.empty()) continue;
        change_lanes(pull, [&](auto& pulls) {
          change_lanes(eliminated, [&](auto& values) {
            for (const Ends& run : piece.ended) values[run.lane] = end(run, pulls[run.lane]), pulls[run.lane] = 0.0;
          });
        });
      }
    }
    if (order_.even()) {
      double* left = &interface[order_.first - 1];
      store_lanes(load_lanes(left) - scale_ * even_.by_left * pull, left);
      Lanes pulled = even_.to_right[0] * eliminated;
      if constexpr (std::is_same_v<C, Lanes>) pulled += even_.to_right[1] * load_lanes(row - 2 * lane_count);
      store_lanes(load_lanes(left + 1) - pulled, left + 1);
    } else if constexpr (std::is_same_v<C, Lanes>) {
      std::array<double, lane_count> pulls;
      store_lanes(pull, pulls.data());
      for (const Ends& run : last_) end(run, pulls[run.lane]);
    }
  }

  template <class C, class Row>
  [[gnu::flatten]] void substitute_by(const Rows<C>& of, std::span<const double> interface, std::span<double> y,
                                      const Row& given) const {
    const Row use = given;
    const C *upper = of.upper.data(), *inverse_pivot = of.scaled_inverse_pivot.data(), *from_left = of.from_left.data();
    double* rows = &y[order_.row(0)];
    Lanes left, x;
    const auto enter = [&](std::span<const Ends> runs) {
      change_lanes(left, [&](auto& lefts) {
        change_lanes(x, [&](auto& values) {
          for (const Ends& run : runs)
            lefts[run.lane] = -run.coupling * interface[run.left], values[run.lane] = interface[run.right];
        });
      });
    };
    if (order_.even())
      left = -even_.coupling * load_lanes(&interface[order_.first - 1]), x = load_lanes(&interface[order_.first]);
    else
      left = x = 0.0, enter(last_);
    std::size_t k = order_.rows;
    const auto take = [&](const Lanes& y_k) __attribute__((always_inline)) {
      x = y_k - upper[k] * x;
      store_lanes(x, rows + k * lane_count);
      use(k, x);
    };
    for (std::size_t p = pieces_.size(); p-- > 0;) {
      const Piece& piece = pieces_[p];
      const std::size_t begin = p > 0 ? pieces_[p - 1].end : 0;
      if (std::is_same_v<C, Lanes> && !piece.ended.empty()) enter(piece.ended);
      const std::size_t last = piece.second ? begin + 1 : begin;
      if (piece.felt) {
        while (k > last) {
          --k;
          take(inverse_pivot[k] * load_lanes(rows + k * lane_count) + from_left[k] * left);
        }
      } else {
        while (k > last) {
          --k;
          take(inverse_pivot[k] * load_lanes(rows + k * lane_count));
        }
      }
      if constexpr (std::is_same_v<C, Lanes>)
        if (k > begin) {
          --k;
          Lanes y_k = inverse_pivot[k] * load_lanes(rows + k * lane_count) + from_left[k] * left;
          if (k + 2 < order_.rows) y_k -= piece.second->upper * load_lanes(rows + (k + 2) * lane_count);
          take(y_k);
        }
    }
  }

  LaneOrder order_;
  double scale_ = 1.0;
  Rows<double> alike_;
  Rows<Lanes> unlike_;
  std::vector<Piece> pieces_;
  std::array<Ends, lane_count> last_{};  // the last run of each lane, but in an even order
  EvenEnds even_;
  BandedMatrix condensed_;
};

}  // namespace viscobar
