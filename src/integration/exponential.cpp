#include <algorithm>
#include <span>

#include "integration/exponential/run.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Exponential& method, const Observers& observers) {
  refuse_directions("exponential", observers);
  if (const auto law = law_refusal("exponential", system.inputs()[0], system.inputs()[1], true))
    throw Unfit("exponential", *law);
  if (system.size() > Exponential::most_unknowns)
    throw Unfit("exponential", {"mesh.elements", "its matrices are dense, and the unknown nodes are too many"});
  const auto has_penalty = [&](const Contact& contact) { return !system.stop(contact); };
  if (std::ranges::any_of(system.contacts(), has_penalty) && !(method.penalty.epsilon > 0.0))
    throw Unfit("exponential", {"contact.epsilon", "must be positive"});
  return run_in_parts(system, start, times, observers, [&](const BarSystem& bar, const StartingPoint& from) {
    return exponential::Run(bar, from, times, method.penalty, observers)(from);
  });
}

}  // namespace viscobar
