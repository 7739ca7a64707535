#include "integration/stepwise_run.hpp"
#include "integration/sundials/arkode_stepper.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Arkode& method, const Observers& observers) {
  return run_in_parts(start, observers, [&](const StartingPoint& from) {
    PenalisedSystem penalised(system, method.penalty);
    const Layout layout(penalised, observers.energy);
    Statistics statistics = statistics_before(from);
    sundials::ArkodeStepper stepper(penalised, layout, method.tolerance, times.back(), statistics);
    return run_stepwise("arkode", penalised, layout, stepper, statistics, from, times, observers);
  });
}

}  // namespace viscobar
