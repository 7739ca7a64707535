#include "integration/stepwise_run.hpp"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "dynamics/penalised_system.hpp"
#include "integration/layout.hpp"
#include "integration/sensitivities.hpp"
#include "integration/stepwise_part.hpp"
#include "run/framed_parts.hpp"
#include "run/step_failure.hpp"
#include "viscobar/dynamics/load_error.hpp"

namespace viscobar {

namespace {

// Makes a part of the run and turns whatever stops it into an IntegrationError that says how far it came. `statistics`
// are those of the parts before, and become those of all.
PartEnd run_part(const char* method, const BarSystem& bar, const Penalty& penalty, const StartingPoint& start,
                 std::span<const double> times, const Observers& observers, const MakeStepper& make_stepper) {
  PenalisedSystem system(bar, penalty);
  const Layout layout(system, observers.energy, observers.directions.size());
  std::unique_ptr<Sensitivities> sensitivities;
  if (!observers.directions.empty())
    sensitivities = std::make_unique<Sensitivities>(system, penalty, observers.directions);
  Statistics statistics = statistics_before(start);
  const std::size_t before = statistics.load_evaluations;
  const std::unique_ptr<LegStepper> stepper =
      make_stepper({system, layout, times, statistics,
                    sensitivities ? sensitivities->derivatives() : std::span<Derivative* const>()});
  StepwisePart run(system, layout, *stepper, statistics, times, observers, begin_of(start, times), sensitivities.get());
  const auto conclude = [&] {
    statistics.unknowns = bar.size() + (bar.inertia().massive_end() - bar.inertia().massive_begin());
    statistics.load_evaluations = before + system.load().evaluations();
    run.count_seconds();
  };
  const auto explain = [&](Failure why, const std::exception& cause) {
    conclude();
    run.tell_reached();
    return IntegrationError(why, fmt::format("{} stopped at t = {}: {}", method, statistics.reached_time, cause.what()),
                            statistics);
  };
  try {
    if (auto checkpoint = run(start)) {
      conclude();
      checkpoint->statistics = statistics;
      return std::move(*checkpoint);
    }
  } catch (const StepFailure& failure) {
    throw explain(failure.why, failure);
  } catch (const LoadError& error) {
    throw explain(Failure::load, error);
  } catch (const std::domain_error& error) {
    throw explain(Failure::inertia, error);
  }
  conclude();
  return statistics;
}

}  // namespace

Statistics run_stepwise(const char* method, const BarSystem& system, const Penalty& penalty, const StartingPoint& start,
                        std::span<const double> times, const Observers& observers, const MakeStepper& make_stepper) {
  return run_in_parts(system, start, times, observers, [&](const BarSystem& bar, const StartingPoint& from) {
    return run_part(method, bar, penalty, from, times, observers, make_stepper);
  });
}

}  // namespace viscobar
