#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>

#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar {

namespace {

// Of a load at `place`, which says where and when: what is no number, or throws, stops a run for the same reason.
template <class Load>
double finite(double t, Load&& load, auto&& place) {
  double value = 0.0;
  try {
    value = load();
  } catch (const std::exception& error) {
    throw LoadError(t, fmt::format("{} cannot be evaluated: {}", place(), error.what()));
  } catch (...) {
    throw LoadError(t, fmt::format("{} cannot be evaluated", place()));
  }
  if (!std::isfinite(value))
    throw LoadError(t, fmt::format("{} is {}", place(), std::isnan(value) ? "not a number" : "infinite"));
  return value;
}

double history_at(const TimeFunction& history, double t) {
  return finite(
      t, [&] { return history(t); }, [&] { return fmt::format("the history of the load at t = {}", t); });
}

double density_at(const SpaceTimeFunction& density, double x, double t) {
  return finite(
      t, [&] { return density(x, t); }, [&] { return fmt::format("the load at x = {}, t = {}", x, t); });
}

}  // namespace

LoadVector::LoadVector(const BarSystem& system) : system_(system) {
  if (std::holds_alternative<BarSystem::SteadyVector>(*system.load_)) return;
  weighted_.resize(system.size());
  if (const auto* separable = std::get_if<BarSystem::SeparableVector>(&*system.load_)) breaks_ = separable->breaks;
  if (const auto* general = std::get_if<BarSystem::GeneralVector>(&*system.load_)) {
    nodal_.resize(2 * system.mesh().nodes());
    breaks_ = general->breaks;
    breaks_at_ = general->breaks_at;
  }
  if (breaks_ || breaks_at_)
    next_.assign(1 + (breaks_at_ ? system.mesh().nodes() : 0), -std::numeric_limits<double>::infinity());
}

bool LoadVector::steady() const { return weighted_.empty(); }

// Each break is searched for once, when the one before it at its place has been passed.
double LoadVector::next_break(double after, double until) {
  constexpr double never = std::numeric_limits<double>::infinity();
  const Mesh& mesh = system_.mesh();
  double first = never;
  for (std::size_t k = 0; k < next_.size(); ++k) {
    if (next_[k] <= after) {
      if (k > 0)
        next_[k] = breaks_at_(mesh.node(k - 1), after, until).value_or(never);
      else
        next_[k] = breaks_ ? breaks_(after, until).value_or(never) : never;
    }
    first = std::min(first, next_[k]);
  }
  return first;
}

double LoadVector::enter(double t, double end) {
  if (next_.empty()) return end;
  const double rounding = 64.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t), std::abs(end));
  double next = next_break(t - rounding, end + rounding);
  if (next <= t + rounding) {
    first_ = t + rounding;
    next = next_break(first_, end + rounding);
  }
  last_ = std::max(first_, next - rounding);
  return next < end - rounding ? next : end;
}

std::span<const double> LoadVector::at(double t) {
  if (const auto* steady = std::get_if<BarSystem::SteadyVector>(&*system_.load_)) return steady->weighted;
  t = inside(t);
  if (time_ == t) return weighted_;
  ++evaluations_;
  if (const auto* separable = std::get_if<BarSystem::SeparableVector>(&*system_.load_)) {
    const double history = history_at(separable->history, t);
    std::transform(separable->weighted.begin(), separable->weighted.end(), weighted_.begin(),
                   [history](double profile) { return history * profile; });
  } else {
    const auto& general = std::get<BarSystem::GeneralVector>(*system_.load_);
    const Mesh& mesh = system_.mesh();
    const std::span<double> values(nodal_.data(), mesh.nodes()), product(nodal_.data() + mesh.nodes(), mesh.nodes());
    for (std::size_t j = 0; j < values.size(); ++j) values[j] = density_at(general.density, mesh.node(j), t);
    general.mass.multiply(values, product);
    std::copy_n(product.begin() + static_cast<std::ptrdiff_t>(system_.first_node()), weighted_.size(),
                weighted_.begin());
  }
  time_ = t;
  return weighted_;
}

double LoadVector::at(double t, std::size_t unknown) const {
  if (const auto* steady = std::get_if<BarSystem::SteadyVector>(&*system_.load_)) return steady->weighted[unknown];
  t = inside(t);
  if (const auto* separable = std::get_if<BarSystem::SeparableVector>(&*system_.load_))
    return history_at(separable->history, t) * separable->weighted[unknown];
  const auto& general = std::get<BarSystem::GeneralVector>(*system_.load_);
  const std::size_t node = unknown + system_.first_node();
  const auto density = [&](std::size_t j) { return density_at(general.density, system_.mesh().node(j), t); };
  const auto& beside = general.mass.off_diagonal;
  double sum = general.mass.diagonal[node] * density(node);
  if (!beside.empty() && node > 0) sum += beside[node - 1] * density(node - 1);
  if (!beside.empty() && node < beside.size()) sum += beside[node] * density(node + 1);
  if (const auto& ends = general.mass.end_rows) {
    const std::size_t last = general.mass.size() - 1;
    for (std::size_t k = 0; k < 3; ++k) {
      if (node == 0) sum += ends->first[k] * density(k);
      if (node == last) sum += ends->last[k] * density(last - k);
    }
  }
  return sum;
}

}  // namespace viscobar
