#include "viscobar/schemes/schemes.hpp"
namespace viscobar {
Statistics integrate(const BarSystem&, const State&, std::span<const double>, const FullyDiscrete&, const Observers&) {
  throw std::logic_error("scheme");
}
}  // namespace viscobar
