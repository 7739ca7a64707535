#include <fmt/format.h>

#include <cmath>
#include <exception>
#include <stdexcept>

#include "characteristics/piecewise_fit.hpp"
#include "characteristics/run.hpp"

namespace viscobar::characteristics {

namespace {

std::function<double(double)> checked(const SpaceFunction& f, double length, const std::string& key) {
  return [&f, length, key](double place) {
    const double x = length * place;
    double value = 0.0;
    try {
      value = f(x);
    } catch (const std::exception& error) {
      throw std::invalid_argument(fmt::format("{} cannot be evaluated at x = {}: {}", key, x, error.what()));
    }
    if (!std::isfinite(value))
      throw std::invalid_argument(
          fmt::format("{} is {} at x = {}", key, std::isnan(value) ? "not a number" : "infinite", x));
    return value;
  };
}

// A jump is an infinite strain. Roots of zero change that much within a rounding of the place. Returns what jumps, all
// together.
double refuse_jumps(const Piecewise& u, double length) {
  constexpr double visible = 1e-6;
  double sum = 0.0;
  const double scale = u.bound();
  for (std::size_t i = 0; i + 1 < u.size(); ++i) {
    const double at = u[i].end, before = u(i, at), after = u(i + 1, at);
    // Pieces as short as roundings of the place are a jump that has been halved to its end.
    const double within = u[i].width() < 1e-12 ? u.polynomial(i).upper() - u.polynomial(i).lower() : 0.0;
    sum += std::abs(after - before);
    if (std::abs(after - before) > visible * scale || within > visible * scale)
      throw std::invalid_argument(
          fmt::format("initial.displacement jumps from {:.6g} to {:.6g} at x = {:.6g}: the strain is infinite there; "
                      "characteristics needs a continuous displacement",
                      before, after, length * at));
  }
  return sum;
}

}  // namespace

InitialData initial_data(const Scene& scene, const LineBar& bar) {
  InitialData data;
  PiecewiseFit fit;
  const Member* member = scene.chain.empty() ? nullptr : &scene.chain[bar.member];
  const auto fitted = [&](bool velocity, const SpaceFunction& f, Places places) -> const Piecewise& {
    const std::string_view what = velocity ? "velocity" : "displacement";
    const std::string key =
        member ? fmt::format("the initial {} of bar {}", what, bar.member + 1) : fmt::format("initial.{}", what);
    if (member)
      for (NextBreak* one : {&places.breaks, &places.detail})
        if (*one) *one = along(*one, bar.begin);
    const std::vector<double> breaks = shares_of(places.breaks, bar.length),
                              guards = shares_of(places.detail, bar.length);
    try {
      return fit.of(checked(f, bar.length, key), {.breaks = breaks, .guards = guards});
    } catch (const StepFailure& error) {
      throw std::invalid_argument(fmt::format("{}: {}", key, error.what()));
    }
  };
  data.displacement = fitted(false, member ? member->displacement : scene.displacement, scene.displacement_places);
  data.displacement_error = fit.error() + refuse_jumps(data.displacement, bar.length);
  data.velocity = fitted(true, member ? member->velocity : scene.velocity, scene.velocity_places);
  data.velocity_error = fit.error();
  const double factor = bar.speed / bar.length;
  for (std::size_t i = 0; i < data.displacement.size(); ++i) {
    const Piecewise::Piece& piece = data.displacement[i];
    data.strain_velocity.append(piece.end, piece, factor / piece.half * data.displacement.polynomial(i).derivative());
  }
  return data;
}

}  // namespace viscobar::characteristics
