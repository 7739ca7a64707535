#pragma once

#include "viscobar/case/case.hpp"

namespace viscobar {

/// The absolute part of a run's tolerance of displacements, chosen where it is not given.
inline double absolute_tolerance(const Case& run) {
  return allowance(run.tolerance, resolve(run).system(), run.end).displacement;
}

}  // namespace viscobar
