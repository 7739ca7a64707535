#pragma once

#include <memory>

#include "integration/stepper.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar::radau {

/// Unknowns that a system must have.
bool takes(const BarSystem& system);

/// Steps by Formula. For systems that takes() holds of.
std::unique_ptr<LegStepper> make_stepper(const StepperParts& run, const Tolerance& tolerance);

}  // namespace viscobar::radau
