#pragma once

#include <span>

#include "integration/stepper.hpp"
#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/dynamics/penalty_law.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// The run of a method that makes steps and interpolates them, on the penalised system: a located contact change or a
/// break of the load ends a leg, output is interpolated.
/// @throws IntegrationError, which says how far it came
Statistics run_stepwise(const char* method, const BarSystem& system, const Penalty& penalty, const StartingPoint& start,
                        std::span<const double> times, const Observers& observers, const MakeStepper& make_stepper);

}  // namespace viscobar
