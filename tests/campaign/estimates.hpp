#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "viscobar/case/case.hpp"

/// Random bars that are thrown, pushed and pulled, with settings as a user may choose them, and how far a run of them
/// is from the motion of the bar itself.
namespace viscobar::campaign {

/// Scene number `index` of the campaign `seed`, as a file. The same on every machine.
///
/// One or two obstacles at the ends, on either side, free and fixed ends, waves as initial data that fit a free end or
/// not, with or without load; viscosities from 0 to 2; by each method in turn, with its own mass, tolerance, penalty
/// and step or given ones, restitution 0 to 1, 10 to 60 elements, 7 to 700 output times. One in twelve has an obstacle
/// along the bar.
std::string thrown_scene(std::uint64_t seed, std::size_t index);

/// The same of bars that chatter: little viscosity between two obstacles, by penalised methods on each mass, the
/// exact one and (2.8), without restitution and with one of 0 to 1.
std::string chattering_scene(std::uint64_t seed, std::size_t index);

/// The same of bars that bounce many times: thrown or pulled at one obstacle by a load or a force on the other end,
/// with masses of a hundredth to twice the bar's on the ends.
std::string bouncing_scene(std::uint64_t seed, std::size_t index);

/// The motion of the bar itself, with a rigid obstacle, at a thousand times: by characteristics without viscosity, by
/// `rigid` on a finer mesh with it, on twice as many elements again to see how good that is.
struct TrueError {
  double error = 0.0;  ///< max |u - u_*| of nodes and times
  double own = 0.0;    ///< how far the two finer runs are apart
  bool sharp() const { return own <= 0.1 * error; }
};
/// True error of a sound case. Absent where its reference takes too long or fails.
std::optional<TrueError> true_error(const Case& run);

}  // namespace viscobar::campaign
