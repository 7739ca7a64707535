#include "report/run/thinned_field.hpp"

#include <algorithm>

namespace viscobar {

ThinnedField::ThinnedField(const Mesh& mesh, At at) : node_stride_((mesh.elements + most - 1) / most) {
  const bool nodal = at == At::nodes;
  const std::size_t last = nodal ? mesh.elements : mesh.elements - 1;
  for (std::size_t j = 0; j < last; j += node_stride_) nodes_.push_back(j);
  nodes_.push_back(last);
  for (const std::size_t j : nodes_) x_.push_back(nodal ? mesh.node(j) : 0.5 * (mesh.node(j) + mesh.node(j + 1)));
  last_.resize(nodes_.size());
}

void ThinnedField::keep(double time) {
  last_time_ = time;
  if (count_++ % stride_ != 0) return;
  if (times_.size() == most) {
    const auto width = static_cast<std::ptrdiff_t>(nodes_.size());
    for (std::size_t row = 1; 2 * row < most; ++row) {
      times_[row] = times_[2 * row];
      const auto from = values_.begin() + static_cast<std::ptrdiff_t>(2 * row) * width;
      std::copy(from, from + width, values_.begin() + static_cast<std::ptrdiff_t>(row) * width);
    }
    times_.resize(most / 2);
    values_.resize(most / 2 * nodes_.size());
    stride_ *= 2;
  }
  times_.push_back(time);
  values_.insert(values_.end(), last_.begin(), last_.end());
}

std::span<const double> ThinnedField::row(std::size_t row) const {
  if (row == times_.size()) return last_;
  return std::span(values_).subspan(row * nodes_.size(), nodes_.size());
}

}  // namespace viscobar
