#pragma once

#include <optional>
#include <string>

#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// The solution of a scene of rho u_tt - E u_xx - eta u_xxt = f in closed form.
struct KnownSolution {
  std::string name;     ///< what it is, in words
  SpaceTimeFunction u;  ///< displacement
};

/// Recognises a scene whose solution up to `end` is known, by the values of its data: initial displacement and velocity
/// are looked at in a thousand places, a scene with a load is never recognised. With a, V, s numbers,
///
///     u_0 = a, u_1 = V, no contact before the end      u = a + V t
///     u_0 = a, u_1 = -V, eta = 0, one obstacle         exact::ElasticImpact, at either end
///     u_0 = s (L - x) - gap, u_1 = 0, eta = 0,         exact::PeriodThree in any units, at either end; with
///     obstacle at 0, L fixed                           tau = c t / L mod 3, y = x / L, the whole field is
///
///     u + gap = s L min(1 - y, 1 - tau),   -s L min(tau - 1, y, 1 - y, 2 - tau),   s L min(tau - 2, 1 - y)
///
/// for tau in [0,1), [1,2), [2,3). Manufactured loads are for library users, who know what they made.
std::optional<KnownSolution> known_solution(const Scene& scene, double end);

}  // namespace viscobar
