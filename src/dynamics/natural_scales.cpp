#include "dynamics/natural_scales.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

namespace viscobar {

namespace {

double largest(std::span<const double> values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

// max over x of |f|, its mean over time: M f by the weight of a node inside. A load that is a blow moves the bar by its
// impulse and not by its height.
double mean_load(const BarSystem& system, double end) {
  if (!system.loaded()) return 0.0;
  LoadVector load(system);
  const int looks = load.steady() ? 1 : 64;
  double sum = 0.0;
  for (int k = 0; k < looks; ++k) try {
      sum += largest(load.at(end * (k + 0.5) / looks)) / looks;
    } catch (const LoadError&) {  // a run that comes there says so
    }
  return sum / system.mesh().spacing();
}

}  // namespace

NaturalScales natural_scales(const BarSystem& system, double end) {
  const Bar& bar = system.bar();
  const State start = system.initial_state();
  const double crossing = bar.length * std::sqrt(bar.density / bar.modulus), tau = std::min(crossing, end);
  const double mean = std::accumulate(start.u.begin(), start.u.end(), 0.0) / static_cast<double>(start.u.size());
  double deviation = 0.0;
  for (const double u : start.u) deviation = std::max(deviation, std::abs(u - mean));
  const double scale = std::max({deviation, tau * largest(start.v), tau * tau * mean_load(system, end) / bar.density});
  return {crossing, scale > 0.0 && std::isfinite(scale) ? scale : bar.length};
}

}  // namespace viscobar
