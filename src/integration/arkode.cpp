#include "integration/stepwise_run.hpp"
#include "integration/sundials/arkode_stepper.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

Statistics integrate(const BarSystem& system, const State& start, std::span<const double> times, const Arkode& method,
                     const Observers& observers) {
  PenalisedSystem penalised(system, method.penalty);
  const Layout layout(penalised, observers.energy);
  Statistics statistics;
  sundials::ArkodeStepper stepper(penalised, layout, method.tolerance, times.back(), statistics);
  return run_stepwise("arkode", penalised, layout, stepper, statistics, start, times, observers);
}

}  // namespace viscobar
