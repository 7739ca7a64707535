#pragma once

#include <fmt/format.h>

#include <cmath>
#include <exception>

#include "viscobar/dynamics/load_error.hpp"

namespace viscobar {

/// The value of a load, or of what is one, that `place` says where and when it is: what is no number, or throws, stops
/// a run for the same reason. @throws LoadError
template <class Load, class Place>
double finite_load(double t, Load&& load, Place&& place) {
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

}  // namespace viscobar
