#include "viscobar/dynamics/inertia.hpp"

#include <algorithm>

#include "dynamics/assembly/assembled.hpp"

namespace viscobar {

namespace {

// The block of the unknowns from `begin` to `end`, mostly all of them.
void factorise_block(TridiagonalFactor& factor, const BandedMatrix& matrix, std::size_t begin, std::size_t end) {
  if (begin == 0 && end == matrix.size()) return factor.factorise(matrix);
  factor.factorise(restrict_to(matrix, begin, end - begin));
}

}  // namespace

Inertia::Inertia(const BandedMatrix& whole, const Unknowns& unknowns, std::array<bool, 2> massless, bool moved)
    : massless_(massless), matrix_(restrict_to(whole, unknowns.first_node(), unknowns.size())) {
  if (moved) whole_ = whole;
  for (const bool right : {false, true})
    if (unknowns.wall(right)) held_rows_[right] = whole.end_row(right);
  factorise_block(massive_factor_, matrix_, massive_begin(), massive_end());
}

double Inertia::held(bool right, std::span<const double> a) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, a.size()); ++k)
    sum += held_rows_[right][k] * a[right ? a.size() - 1 - k : k];
  return sum;
}

void Inertia::accelerate(std::span<double> force) const {
  if (massless_[0]) force.front() = 0.0;
  if (massless_[1]) force.back() = 0.0;
  massive_factor_.solve(force.subspan(massive_begin(), massive_end() - massive_begin()));
}

std::vector<double> Inertia::effective_masses() const {
  const std::size_t begin = massive_begin();
  const std::vector<double> inverse = inverse_diagonal(restrict_to(matrix_, begin, massive_end() - begin));
  std::vector<double> masses(matrix_.size(), 0.0);
  for (std::size_t i = 0; i < inverse.size(); ++i) masses[begin + i] = 1.0 / inverse[i];
  return masses;
}

double Inertia::contact_mass(const Contact& contact) const {
  const std::size_t i = contact.unknown;
  if (contact.joint > 0) {  // of two nodes that a force pushes apart
    std::vector<double> gained(matrix_.size());
    gained[i] = 1.0, gained[i - 1] = -1.0;
    accelerate(gained);
    return 1.0 / (gained[i] - gained[i - 1]);
  }
  return contact.where == Where::span ? row_sum(matrix_, i) : effective_masses()[i];
}

}  // namespace viscobar
