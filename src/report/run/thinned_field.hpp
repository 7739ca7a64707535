#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "viscobar/discretisation/mesh.hpp"

namespace viscobar {

/// A field over space and time as far as a picture shows it: every 2^k-th output time, k growing so that there
/// are never more than 400 of them, and every stride-th place, at most 401 of them, the ends always among them. The
/// last output time is kept, too.
class ThinnedField {
 public:
  /// Of values at the nodes of a mesh, or at the middles of its elements.
  enum class At { nodes, elements };
  explicit ThinnedField(const Mesh& mesh, At at = At::nodes);

  void add(double time, std::span<const double> values) {
    add_each(time, [&](std::size_t j) { return values[j]; });
  }
  /// value(j) at place j
  template <class Value>
  void add_each(double time, Value&& value) {
    for (std::size_t k = 0; k < nodes_.size(); ++k) last_[k] = value(nodes_[k]);
    keep(time);
  }

  /// Output times kept, the last one included.
  std::size_t rows() const { return times_.size() + (last_kept() ? 0 : 1); }
  double time(std::size_t row) const { return row < times_.size() ? times_[row] : last_time_; }
  std::span<const double> row(std::size_t row) const;
  const std::vector<double>& x() const { return x_; }

  static void members(auto& field, auto&& each) {
    each(field.stride_, field.count_, field.times_, field.values_, std::span(field.last_), field.last_time_);
  }

  std::size_t time_stride() const { return stride_; }
  std::size_t node_stride() const { return node_stride_; }

 private:
  static constexpr std::size_t most = 400;
  void keep(double time);
  bool last_kept() const { return count_ == 0 || (count_ - 1) % stride_ == 0; }

  std::size_t node_stride_, stride_ = 1, count_ = 0;
  std::vector<std::size_t> nodes_;
  std::vector<double> x_, times_, values_, last_;
  double last_time_ = 0.0;
};

}  // namespace viscobar
