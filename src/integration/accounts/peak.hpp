#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "integration/bernstein.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// Takes the reactions of a step, which ends at `to`, into the peaks of its contact and of the run: those of either
/// sign, or the pushes alone. Reactions that are known up to `uncertain`, more than 1e-5 of them, count as what they
/// are at least.
inline void raise_peak(ContactAccount& account, std::span<const double> force, double to, double length,
                       bool pulls = true, double uncertain = 0.0) {
  const double known = std::abs(account.latest.reaction) + uncertain;
  double lowest = force[0], highest = force[0];
  for (const double value : force) lowest = std::min(lowest, value), highest = std::max(highest, value);
  const double excess = Bernstein::excess(force.size() - 1) * (highest - lowest);
  if (highest + excess <= known && (!pulls || excess - lowest <= known)) return;
  const auto [least, most] = std::ranges::minmax_element(force);
  const Bernstein polynomial = Bernstein::through(force);
  const auto take = [&](double extreme, auto sample) {
    if (!(std::abs(extreme) > known)) return;
    if (uncertain > 1e-5 * std::abs(extreme)) extreme -= std::copysign(uncertain, extreme);
    const double part = static_cast<double>(sample - force.begin()) / static_cast<double>(force.size() - 1);
    account.peak_reaction = std::max(account.peak_reaction, account.latest.raise(extreme, to - (1.0 - part) * length));
  };
  take(polynomial.largest(known), most);
  if (pulls) take(polynomial.smallest(-known), least);
}

}  // namespace viscobar
