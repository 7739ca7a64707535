#include "viscobar/analysis/case.hpp"

namespace viscobar {

Statistics simulate(const Case& run, const BarSystem& system, const Observers& observers) {
  return simulate(run, system, run.output_times(), observers);
}

Statistics simulate(const Case& run, const BarSystem& system, std::span<const double> times,
                    const Observers& observers) {
  const State start = system.initial_state();
  switch (run.method) {
    case MethodName::cvode:
      return integrate(system, start, times, Cvode{penalty(run), run.tolerance, run.formulas}, observers);
    case MethodName::ida: return integrate(system, start, times, Ida{penalty(run), run.tolerance}, observers);
    case MethodName::arkode: return integrate(system, start, times, Arkode{penalty(run), run.tolerance}, observers);
    case MethodName::odeint: return integrate(system, start, times, odeint(run), observers);
    case MethodName::rigid: return integrate(system, start, times, Rigid{run.tolerance}, observers);
    case MethodName::exponential: return integrate(system, start, times, Exponential{penalty(run)}, observers);
    case MethodName::fully_discrete:
    case MethodName::finite_difference:
      return integrate(system, start, times, FullyDiscrete{*run.step, run.start, run.restitution.value_or(0.0)},
                       observers);
  }
  return {};
}

}  // namespace viscobar
