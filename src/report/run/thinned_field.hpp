#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "viscobar/discretisation/mesh.hpp"

namespace viscobar {

/// The displacement over space and time as far as a picture shows it: every 2^k-th output time, k growing so that there
/// are never more than 400 of them, and every stride-th node, at most 401 of them, the ends always among them. The last
/// output time is kept, too.
class ThinnedField {
 public:
  explicit ThinnedField(const Mesh& mesh);

  void add(double time, std::span<const double> u);

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
  bool last_kept() const { return count_ == 0 || (count_ - 1) % stride_ == 0; }

  std::size_t node_stride_, stride_ = 1, count_ = 0;
  std::vector<std::size_t> nodes_;
  std::vector<double> x_, times_, values_, last_;
  double last_time_ = 0.0;
};

}  // namespace viscobar
