#include "integration/radau/stepper.hpp"
#include "integration/stepwise_run.hpp"
#include "run/parts.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Rigid& method, const Observers& observers) {
  refuse_laws("rigid", system.inputs());
  const Penalty rigid{0.0, method.restitution};
  if (radau::takes(system))
    return run_stepwise("rigid", system, rigid, start, times, observers,
                        [&](const StepperParts& parts) { return radau::make_stepper(parts, method.tolerance); });
  if (system.inertia().has_massless() || system.bar().damped())
    return integrate(system, start, times, Arkode{rigid, method.tolerance}, observers);
  return integrate(system, start, times, Cvode{rigid, method.tolerance}, observers);
}

}  // namespace viscobar
