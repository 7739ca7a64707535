#include "dynamics/natural_scales.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <numeric>
#include <span>

#include "dynamics/assembly/assembled.hpp"
#include "dynamics/pieces.hpp"
#include "viscobar/dynamics/load_vector.hpp"

namespace viscobar {

namespace {

constexpr int looks_at_varying = 64;
constexpr double between_instants = 0.5 + 1e-9;

double largest(std::span<const double> values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

// The mean over [0, end] of f at so many times or more, which no formula names: a value at one instant is nothing.
// Each stretch between breaks, or from the begin of a pulse to its end, has one of its own at least. Where f is not
// finite it counts for nothing: a run that comes there says so.
double mean(double end, int looks, const auto& f, const NextBreak& breaks) {
  constexpr int most_stretches = 256;
  constexpr double rounding = 1e-13;  // a break is told again within one of it
  double sum = 0.0;
  int stretches = 0;
  for (double from = 0.0, to = end; from < end; from = to) {
    to = breaks && ++stretches < most_stretches ? breaks(from + rounding * end, end).value_or(end) : end;
    const double share = (to - from) / end;
    const auto here = std::max(1, static_cast<int>(std::ceil(looks * share)));
    for (int k = 0; k < here; ++k) try {
        const double value = f(from + (to - from) * (k + between_instants) / here);
        if (std::isfinite(value)) sum += share / here * value;
      } catch (const std::exception&) {
      }
  }
  return sum;
}

// Sums of the rows of rho M, of an end that of the next node: a row there has half an element, and what is mounted.
std::vector<double> row_weights(const BarSystem& system) {
  std::vector<double> weights(system.size());
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = row_sum(system.inertia().matrix(), i);
  if (weights.size() > 2) weights.front() = weights[1], weights.back() = weights[weights.size() - 2];
  return weights;
}

// max over x of |f| / rho, its mean over time: the load of a row by its weight, which has the section that it has. A
// load that is a blow moves the bar by its impulse and not by its height.
double mean_acceleration(const BarSystem& system, double end) {
  if (!system.loaded()) return 0.0;
  LoadVector load(system);
  const std::vector<double> weights = row_weights(system);
  // A force on an end is none along the bar.
  const auto& [left, right] = system.inputs();
  const bool ends = left.force || right.force || system.frame().moving();
  const std::size_t outer = ends && weights.size() > 2 ? 1 : 0;
  return mean(
      end, load.steady() ? 1 : looks_at_varying,
      [&](double t) {
        const std::span<const double> all = load.at(t);
        double most = 0.0;
        for (std::size_t i = outer; i + outer < all.size(); ++i)
          if (weights[i] > 0.0) most = std::max(most, std::abs(all[i]) / weights[i]);
        return most;
      },
      [&](double after, double until) -> std::optional<double> {
        const double next = load.enter(after, until);
        return next < until ? std::optional(next) : std::nullopt;
      });
}

double mean_size(const TimeFunction& f, const NextBreak& breaks, double end) {
  return mean(
      end, looks_at_varying, [&](double t) { return std::abs(f(t)); }, breaks);
}

// The displacement that forces on the ends and the motion of fixed ones make, by their means over time: F / (rho c A)
// is the velocity of the wave that a force sends, which goes on for tau.
double moved_by_ends(const BarSystem& system, double tau, double end) {
  const Bar& bar = system.bar();
  double most = 0.0;
  for (const bool right : {false, true}) {
    const EndInput& input = system.inputs()[right];
    if (input.force)
      most = std::max(most, tau * mean_size(input.force->value, input.force->breaks, end) /
                                (bar.impedance() * area_at(system, right)));
    if (input.motion && system.unknowns().wall(right))
      most = std::max(most, mean_size(input.motion->displacement, input.motion->breaks, end));
  }
  return most;
}

// An obstacle that moves is something only to a bar that it comes to, and gives a scale to one that nothing else moves.
double moved_by_obstacles(const BarSystem& system, double end) {
  double most = 0.0;
  for (const bool right : {false, true})
    if (const EndInput& input = system.inputs()[right]; input.motion && !system.unknowns().wall(right))
      most = std::max(most, mean_size(input.motion->displacement, input.motion->breaks, end));
  return most;
}

}  // namespace

double area_at(const BarSystem& system, bool right) {
  const Piece& bar = end_bar(system.elements().pieces(), right);
  return bar.area(bar.end_element(right));
}

double displacement_of_data(const BarSystem& system, double end) {
  const Bar& bar = system.bar();
  const State start = system.initial_state();
  const double tau = std::min(bar.transit(), end);
  const double mean = std::accumulate(start.u.begin(), start.u.end(), 0.0) / static_cast<double>(start.u.size());
  double deviation = 0.0;
  for (const double u : start.u) deviation = std::max(deviation, std::abs(u - mean));
  double scale = std::max(
      {deviation, tau * largest(start.v), tau * tau * mean_acceleration(system, end), moved_by_ends(system, tau, end)});
  if (scale == 0.0) scale = moved_by_obstacles(system, end);
  return std::isfinite(scale) ? scale : 0.0;
}

std::optional<std::string> too_small(const State& start, const BarSystem& system, double end) {
  // The squares of smaller displacements, energies among them, have no digits left.
  constexpr double least = 1e-100;
  if (largest(start.u) >= least || largest(start.v) >= least) return std::nullopt;
  const double moved = displacement_of_data(system, end);
  if (moved == 0.0 || moved >= least) return std::nullopt;
  return fmt::format(
      "the data move the bar by some {:.1e}, which is too small for the squares of double precision: write 0, or take "
      "other units",
      moved);
}

NaturalScales natural_scales(const BarSystem& system, double end) {
  const Bar& bar = system.bar();
  const double scale = displacement_of_data(system, end);
  return {bar.transit(), scale > 0.0 ? scale : bar.length};
}

}  // namespace viscobar
