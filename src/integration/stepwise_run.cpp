#include "integration/stepwise_run.hpp"

#include <memory>
#include <optional>
#include <utility>

#include "dynamics/penalised_system.hpp"
#include "integration/layout.hpp"
#include "integration/sensitivities.hpp"
#include "integration/stepwise_part.hpp"
#include "run/framed_parts.hpp"

namespace viscobar {

namespace {

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
  const auto reached = [&] {
    conclude();
    run.tell_reached();
    return statistics;
  };
  return part_or_failure(method, reached, [&]() -> PartEnd {
    std::optional<Checkpoint> checkpoint = run(start);
    conclude();
    if (!checkpoint) return statistics;
    checkpoint->statistics = statistics;
    return std::move(*checkpoint);
  });
}

}  // namespace

Statistics run_stepwise(const char* method, const BarSystem& system, const Penalty& penalty, const StartingPoint& start,
                        std::span<const double> times, const Observers& observers, const MakeStepper& make_stepper) {
  return run_in_parts(system, start, times, observers, [&](const BarSystem& bar, const StartingPoint& from) {
    return run_part(method, bar, penalty, from, times, observers, make_stepper);
  });
}

}  // namespace viscobar
