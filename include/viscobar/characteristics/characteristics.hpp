#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/run/run.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// The exact solution of an undamped bar, without mesh, penalty or time step. With c = sqrt(E / rho) the waves
///
///     v - c u_x = v - s / (rho c)  to the right,     v + c u_x = v + s / (rho c)  to the left
///
/// are carried at the speed c and changed by the load alone, and an end sends back what arrives: unchanged from a free
/// end or an open contact, with its sign turned from a fixed end or a closed contact, whose reaction is -rho c times
/// what arrives. The waves are kept as polynomial pieces that represent the data to rounding (docs/characteristics.md).
struct Characteristics {
  /// Passages L / c of a wave through the bar that a run may take.
  static constexpr double most_passages = 1e9;
  std::size_t most_pieces = 50'000;  ///< of a wave, where a run stops
  double restitution = 0.0;          ///< of masses that strike an obstacle or each other; only 0 is followed
};

/// Why the method does not take the scene until `end`; absent where it does.
std::optional<Finding> refusal(const Scene& scene, double end, const Characteristics& method);

/// The time at which the waves break into more pieces than a choice of method should wait for, each contact change
/// leaving a break that comes back for ever: 10,000 of a wave (docs/characteristics.md). Absent where they stay fewer
/// up to `end`, as far as 10^6 pieces, all passages together, or 10^7 evaluations of the load show.
/// @throws as integrate()
std::optional<double> roughens(const Scene& scene, double end);
/// Evaluations of the load that an output takes, by one in the first passage: of one in x and t that of all waves that
/// are under way then, some 10^5 for a smooth one; 0 of others, whose waves are known once for all.
/// @throws as integrate()
double evaluations_of_output(const Scene& scene, double end);

/// Follows the waves from the scene's own data, or a checkpoint, at times.front() to times.back(), telling the
/// observers. Snapshots are of the nodes of `mesh`, which has no other part in it; `times` are as of the other methods.
/// `steps` of the statistics are the passages, `unknowns` the most coefficients that the waves had at a time.
/// Observers are told of progress at output times, too.
/// @throws IntegrationError, with what was reached
/// @throws Unfit when the method does not take the scene, std::invalid_argument when data are no data of a bar
Statistics integrate(const Scene& scene, const Mesh& mesh, const std::optional<Checkpoint>& from,
                     std::span<const double> times, const Characteristics& method, const Observers& observers);

}  // namespace viscobar
