#include "viscobar/integration/integrate.hpp"
namespace viscobar {
Statistics integrate(const BarSystem&, const State&, std::span<const double>, const Exponential&, const Observers&) {
  throw std::logic_error("exponential");
}
}  // namespace viscobar
