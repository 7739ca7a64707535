#pragma once

#include <cstddef>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "integration/sundials/handles.hpp"

namespace viscobar::sundials {

/// An N_Vector of our own: contiguous, every operation vectorised and the linear combinations fused, because
/// distributions ship SUNDIALS' own vectors unoptimised. Its weighted norm is the maximum norm max |x_i w_i|: the
/// root mean square would dilute the error of one node in an impact by the square root of the mesh size.
/// Norms look at its first `weighed` entries, all by default: the others have no weight anyway.
Vector make_vector(std::size_t size, const Context& context, std::size_t weighed = static_cast<std::size_t>(-1));

/// What a probe looks at: entry i of it is entries[i] of a vector, where i is among the `selected`; others are left.
struct Probed {
  explicit Probed(std::vector<std::size_t> of) : entries(std::move(of)), selected(entries.size()) {
    std::iota(selected.begin(), selected.end(), std::size_t{0});
  }
  std::vector<std::size_t> entries, selected;
};

/// A vector that linear combinations only reach at the probed entries of their operands: evaluating an integrator's
/// interpolant into it costs a few operations instead of a pass over the whole history.
/// `probed` must outlive the vector.
Vector make_probe(const Probed& probed, const Context& context);

/// To be called behind each call of the library that may make vectors. @throws std::bad_alloc when it could not
void require_memory();

std::span<double> values(N_Vector vector);
inline std::span<double> values(const Vector& vector) { return values(vector.get()); }

}  // namespace viscobar::sundials
