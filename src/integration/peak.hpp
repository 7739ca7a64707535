#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "integration/bernstein.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// Takes the reactions of a step, which ends at `to`, into the peaks of its contact and of the run: those of either
/// sign, or the pushes alone.
inline void raise_peak(ContactAccount& account, std::span<const double> force, double to, double length,
                       bool pulls = true) {
  const double known = std::abs(account.latest.reaction);
  double lowest = force[0], highest = force[0];
  for (const double value : force) lowest = std::min(lowest, value), highest = std::max(highest, value);
  const double excess = Bernstein::excess(force.size() - 1) * (highest - lowest);
  if (highest + excess <= known && (!pulls || excess - lowest <= known)) return;
  const auto [least, most] = std::ranges::minmax_element(force);
  const Bernstein polynomial = Bernstein::through(force);
  const auto take = [&](double extreme, auto sample) {
    const double part = static_cast<double>(sample - force.begin()) / static_cast<double>(force.size() - 1);
    account.peak_reaction = std::max(account.peak_reaction, account.latest.raise(extreme, to - (1.0 - part) * length));
  };
  take(polynomial.largest(known), most);
  if (pulls) take(polynomial.smallest(-known), least);
}

}  // namespace viscobar
