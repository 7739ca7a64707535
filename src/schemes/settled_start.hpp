#pragma once

#include <cstddef>

#include "dynamics/jumps/jump_filter.hpp"
#include "dynamics/natural_scales.hpp"
#include "dynamics/penalised_system.hpp"

namespace viscobar {

/// Puts the high modes of the start at their equilibrium (JumpFilter), where nothing touches then: an impact is in the
/// scheme's own first step. `settled` is a system without penalty of the filter's bar, its leg begun.
inline JumpFilter::Taken settle_high_modes(JumpFilter& filter, PenalisedSystem& settled, double begin, double end,
                                           State& start) {
  State touched = start;
  settled.settle(begin, touched.u, touched.v);
  for (std::size_t i = 0; i < settled.contacts().size(); ++i)
    if (settled.contacts().closed(i)) return {};
  const NaturalScales scales = natural_scales(settled.bar(), end);
  const double rounding = 1e-12;
  return filter.begin(settled, begin, {rounding * scales.displacement, rounding * scales.velocity()}, start.u, start.v);
}

}  // namespace viscobar
