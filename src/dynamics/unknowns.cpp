#include "viscobar/dynamics/unknowns.hpp"

#include <algorithm>
#include <cassert>
#include <stdexcept>

namespace viscobar {

Unknowns::Unknowns(std::size_t nodes, const std::array<std::optional<double>, 2>& walls) : walls_(walls) {
  const std::size_t fixed = std::size_t{left_fixed()} + std::size_t{right_fixed()};
  if (nodes <= fixed)
    throw std::invalid_argument("both ends are fixed and the mesh has no node between them: 2 elements are needed");
  size_ = nodes - fixed;
}

void Unknowns::expand_displacement(std::span<const double> u, std::span<double> nodal) const {
  expand_velocity(u, nodal);
  if (walls_[0]) nodal.front() = *walls_[0];
  if (walls_[1]) nodal.back() = *walls_[1];
}

void Unknowns::expand_velocity(std::span<const double> w, std::span<double> nodal) const {
  assert(nodal.size() == size_ + std::size_t{left_fixed()} + std::size_t{right_fixed()});
  nodal.front() = nodal.back() = 0.0;
  std::ranges::copy(w, nodal.subspan(first_node()).begin());
}

}  // namespace viscobar
