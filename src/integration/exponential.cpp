#include <span>

#include "integration/exponential/run.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Exponential& method, const Observers& observers) {
  refuse_directions("exponential", observers);
  refuse_laws("exponential", system.inputs());
  if (system.size() > Exponential::most_unknowns)
    throw Unfit("exponential", {"mesh.elements", "its matrices are dense, and the unknown nodes are too many"});
  if (!system.contacts().empty() && !(method.penalty.epsilon > 0.0))
    throw Unfit("exponential", {"contact.epsilon", "must be positive"});
  return run_in_parts(system, start, times, observers, [&](const BarSystem& bar, const StartingPoint& from) {
    return exponential::Run(bar, from, times, method.penalty, observers)(from);
  });
}

}  // namespace viscobar
