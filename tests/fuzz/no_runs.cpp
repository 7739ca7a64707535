// The table of methods names their integrate(), and no fuzzer runs a scene: none of the integrators is built for them.
#include <stdexcept>

#include "viscobar/characteristics/characteristics.hpp"
#include "viscobar/integration/integrate.hpp"
#include "viscobar/schemes/schemes.hpp"

namespace viscobar {

namespace {

[[noreturn]] Statistics refuse() { throw std::logic_error("a fuzzer runs no scene"); }

}  // namespace

using Times = std::span<const double>;

Statistics integrate(const BarSystem&, const StartingPoint&, Times, const Cvode&, const Observers&) { refuse(); }
Statistics integrate(const BarSystem&, const StartingPoint&, Times, const Ida&, const Observers&) { refuse(); }
Statistics integrate(const BarSystem&, const StartingPoint&, Times, const Arkode&, const Observers&) { refuse(); }
Statistics integrate(const BarSystem&, const StartingPoint&, Times, const Odeint&, const Observers&) { refuse(); }
Statistics integrate(const BarSystem&, const StartingPoint&, Times, const Exponential&, const Observers&) { refuse(); }
Statistics integrate(const BarSystem&, const StartingPoint&, Times, const Rigid&, const Observers&) { refuse(); }
Statistics integrate(const BarSystem&, const StartingPoint&, Times, const FullyDiscrete&, const Observers&) {
  refuse();
}
Statistics integrate(const Scene&, const Mesh&, const std::optional<Checkpoint>&, Times, const Characteristics&,
                     const Observers&) {
  refuse();
}
std::optional<double> roughens(const Scene&, double) { return std::nullopt; }
double evaluations_of_output(const Scene&, double) { return 0.0; }

}  // namespace viscobar
